# %% [markdown]
# # Which place, and how tilted
#
# Skies above a forest trail, rendered, as a camera sees them that looks up and sees half of the sphere. A camera that
# tilts loses some of the sky and sees ground instead. Compared over all rotations, in what both views saw, the place is
# still found, and with it how the camera is turned and tilted; amplitudes of spherical harmonics take what is not seen
# for ground. All views are rendered; no photograph is used.
#
#     python examples/rotation_matching.py [FOLDER]

# %%
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, RATES, journal_style, name_panel, save_figure
from insectnav.matching import RotationParams, build_rotation_index, rotation_between
from insectnav.matching.rotation_search import best_rotations, tilt_rotations
from insectnav.matching.view_maps import look_up
from insectnav.vision import fisheye, panorama, rotation_matrix, to_world
from insectnav.vision.descriptors import sphere_amplitudes
from insectnav.vision.sphere import equirectangular
from insectnav.worlds import flat_world, render
from insectnav.worlds.builders import build_world

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
folder.mkdir(parents=True, exist_ok=True)

# %% Places every three metres along the trail, the eye 1 m above the ground
world = build_world("forest-trail", seed=3)
flat = flat_world(world.mesh)
along = np.linalg.norm(np.diff(world.route, axis=0), axis=1).cumsum()
ground = world.route[1:][np.searchsorted(along, np.arange(6.0, 140.0, 3.0))]
places = np.column_stack([ground, world.ground_height(ground) + 1.0])
grid = equirectangular(2.0)
seen = grid.directions[:, 2] > 0.0  # the camera's own hemisphere, however it is tilted


def skies(where, heading=0.0, pitch=0.0, roll=0.0):
    """Share of sky along each direction of the grid, (place, direction)."""
    layers = render(
        flat, where, heading, pitch, roll, camera=panorama(2.0, (-90.0, 90.0)), layers=("sky",), supersampling=2
    )
    return layers["sky"].reshape(len(where), -1)


# %% The index is built once, of level views that look north
references = skies(places)
index = build_rotation_index(references, seen, grid, RotationParams(fine_blur=np.deg2rad(2.0)))
remembered = sphere_amplitudes(np.where(seen, references, 0.0), grid, 60)

# %% The same places again, each camera turned anyhow and tilted towards anywhere
rng = np.random.default_rng(5)
tilts_deg, n_queries = np.arange(0, 61, 10), 20
recall = {"rotation matching": [], "spherical harmonics": []}
for tilt in np.deg2rad(tilts_deg):
    number = rng.choice(len(places), n_queries, replace=False)
    turn, towards = rng.uniform(-np.pi, np.pi, (2, n_queries))
    # Pitch and roll that together tilt the upward axis by the angle given.
    pitch = np.arcsin(np.sin(tilt) * np.cos(towards))
    roll = np.arctan2(np.sin(tilt) * np.sin(towards), np.cos(tilt))
    views = skies(places[number], turn, pitch, roll)
    match = index.match(views, seen)
    is_right = match.reference == number
    error = np.rad2deg(rotation_between(match.rotation, rotation_matrix(turn, pitch, roll))[is_right])
    spectra = sphere_amplitudes(np.where(seen, views, 0.0), grid, 60)
    nearest = np.linalg.norm(spectra[:, None] - remembered, axis=-1).argmin(axis=1)
    recall["rotation matching"].append(is_right.mean())
    recall["spherical harmonics"].append(np.mean(nearest == number))
    print(
        f"tilt {np.rad2deg(tilt):2.0f}°: {is_right.mean():4.0%} found, turned as said to {np.median(error):.2f}°; "
        f"by amplitudes {recall['spherical harmonics'][-1]:4.0%}"
    )

# %% One place for the figure, and the best score of its reference for each tilt that could be
chosen, pose = 20, (0.9, np.deg2rad(35.0), np.deg2rad(20.0))
view = skies(places[[chosen]], *pose)[0]
match = index.match(view, seen)
alone = build_rotation_index(references[[chosen]], seen, grid, index.params)
query = alone.coarse(view[None].astype(np.float32), seen[None])[0]
tilts = tilt_rotations(np.deg2rad(5.0), np.deg2rad(90.0))
scores = [
    best_rotations(query, alone.coarse.n_cells, tilt[None], alone.rings, np.ones(1), "difference")[0][0]
    for tilt in tilts
]

# %% Draw upward views as discs, like maps: ahead at the top, right on the right, the rim at the camera's horizon
disc = fisheye((240, 240), np.pi).pixel_directions()[:, ::-1]  # a picture taken upwards has right on the left
is_disc = np.isfinite(disc[..., 0])


def drawn(values, directions):
    """Picture (240, 240) of values on the grid along directions, NaN beyond the rim."""
    whole = index.fine(values[None].astype(np.float32), np.ones((1, grid.n_directions), bool))
    return np.where(is_disc, look_up(whole, index.fine.n_cells, np.nan_to_num(directions, nan=0.57735))[0], np.nan)


there = to_world(np.nan_to_num(disc), match.rotation.T)  # where the query saw what the reference sees
both = is_disc & (there[..., 2] > 0.0)
pictures = {
    "a": ("reference, level", drawn(references[chosen], disc)),
    "b": ("query, turned and tilted", drawn(view, disc)),
    "c": (
        "what differs",
        np.where(both, np.abs(drawn(references[chosen], disc) - drawn(view, there)), np.nan),
    ),
}
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 4.2), layout="constrained")
    axes = figure.subplot_mosaic("aabbcc;dddeee", height_ratios=[1.0, 1.1])
    for letter, (title, picture) in pictures.items():
        axes[letter].imshow(picture, cmap="gray" if letter != "c" else "magma_r", vmin=0, vmax=1)
        axes[letter].set_axis_off()
        name_panel(axes[letter], letter, title)
    # A tilt is shown by where the query has the zenith of the reference, which no turn about that zenith changes.
    away, towards = np.rad2deg(np.arccos(np.clip(tilts[:, 2, 2], -1, 1))), np.arctan2(tilts[:, 2, 0], tilts[:, 2, 1])
    shown = axes["d"].scatter(
        away * np.sin(towards), away * np.cos(towards), c=scores, s=14, cmap=RATES, linewidths=0, rasterized=True
    )
    marks = {"true": (rotation_matrix(*pose), "o", 45), "found": (match.rotation, "x", 18)}
    for label, (rotation, marker, size) in marks.items():
        right, ahead, up = rotation[2]
        x, y = np.rad2deg(np.arccos(up)) * np.array([right, ahead]) / np.hypot(right, ahead)
        colour = {"facecolors": "none", "edgecolors": COLOURS["red"]} if marker == "o" else {"color": COLOURS["red"]}
        axes["d"].scatter(x, y, s=size, marker=marker, linewidths=1.0, label=label, **colour)
    axes["d"].set(aspect="equal", xlabel="zenith to the right (deg)", ylabel="zenith ahead (deg)")
    axes["d"].set(xticks=[-90, 0, 90], yticks=[-90, 0, 90], xlim=(-95, 125), ylim=(-95, 125))
    axes["d"].legend(loc="upper right", handletextpad=0.2, borderaxespad=0.0)
    figure.colorbar(shown, ax=axes["d"], label="best score over all turns")
    name_panel(axes["d"], "d", "score over tilts")
    for (name, share), colour, marker in zip(recall.items(), ("blue", "orange"), "os", strict=True):
        axes["e"].plot(tilts_deg, 100 * np.array(share), marker=marker, markersize=4, color=COLOURS[colour], label=name)
    axes["e"].set(xlabel="tilt (deg)", ylabel="found at first place (%)", ylim=(0, 104), xticks=tilts_deg)
    axes["e"].legend(loc="lower left")
    name_panel(axes["e"], "e", f"recall, {len(places)} rendered places")
    save_figure(figure, folder, "rotation-matching")
print(f"figure: {folder / 'rotation-matching.png'}")
