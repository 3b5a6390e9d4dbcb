# %% [markdown]
# # Where am I: a walk recognised in another season
#
# A rendered city is walked twice: in May with leaves and a high sun, and in January without leaves, under a low sun, a
# metre to the left, at another pace and with a heading that wavers. SeqSLAM matches the second walk to the first, and a
# visual compass tells the heading at each match. After Stone et al., RSS 2014 and ICRA 2016.
#
#     python examples/place_recognition.py [FOLDER]

# %%
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from insectnav.angles import bearing, wrap
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, RATES, journal_style, name_panel, save_figure
from insectnav.matching import begin_stream, difference_matrix, locate_next, seqslam, turns_of_matches
from insectnav.metrics.retrieval import (
    area_under_curve,
    position_error,
    precision_at_full_recall,
    precision_recall,
    recall_at_full_precision,
    right_matches,
)
from insectnav.vision import panorama
from insectnav.vision.descriptors import DESCRIPTORS
from insectnav.worlds import light_world, render
from insectnav.worlds.builders import build_world
from insectnav.worlds.sky import Sky

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
folder.mkdir(parents=True, exist_ok=True)


# %% Two walks of about a kilometre, a view every 6 m and every 6.6 m, 2 m above the ground, in pixels of 3°
def walk(route, start, end, spacing, aside):
    """Places every so many metres of the way, moved to the right of it, and headings along it."""
    reached = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(route, axis=0), axis=1))])
    along = np.arange(start, end, spacing)
    here, before, after = (
        np.stack([np.interp(along + shift, reached, route[:, k]) for k in (0, 1)], axis=-1) for shift in (0, -1, 1)
    )
    heading = bearing(after - before)
    return here + aside * np.stack([np.cos(heading), -np.sin(heading)], axis=-1), heading


def look(world, sky, place, heading):
    """Green light and the exact mask of the sky, (n, 35, 120) each."""
    eye = np.column_stack([place, np.full(len(place), 2.0)])
    return render(light_world(world, sky), eye, heading, camera=panorama(3.0), layers=("green", "sky"), supersampling=2)


may = build_world("city", seed=1)
january = build_world("city", seed=1, foliage=0.1, time_s=500.0)  # leaves have gone, cars and people moved on
high_sun = Sky(sun_azimuth=np.deg2rad(140.0), sun_elevation=np.deg2rad(45.0))
low_sun = Sky(sun_azimuth=np.deg2rad(220.0), sun_elevation=np.deg2rad(12.0))
place, heading = walk(may.route, 0.0, 1050.0, 6.0, 0.0)
query_place, query_heading = walk(january.route, 40.0, 1000.0, 6.6, -1.0)
query_heading = wrap(query_heading + np.deg2rad(8.0) * np.random.default_rng(5).normal(size=len(query_heading)))
known, seen = look(may, high_sun, place, heading), look(january, low_sun, query_place, query_heading)

# %% Descriptors, differences, sequences: which of the matches are within two frames, 12 m?
apart = np.linalg.norm(place[:, None] - query_place, axis=-1)
TOLERANCE = 2  # [frame]
ways = {
    "grey patches": ("patch-normalised", "green"),
    "binary sky": ("binary-sky", "sky"),
    "sky, harmonics": ("spherical-harmonics", "sky"),
    "sky, Zernike": ("zernike", "sky"),
}
curves, differences, found = {}, {}, {}
for name, (descriptor, layer) in ways.items():
    describe = DESCRIPTORS[descriptor]
    differences[name] = difference_matrix(describe(known[layer]), describe(seen[layer]), describe.metric)
    found[name] = seqslam(differences[name])
    is_right = right_matches(found[name].reference, apart.argmin(axis=0), TOLERANCE)
    curves[name] = curve = precision_recall(is_right, found[name].score)
    print(
        f"{name:16s} precision of all {precision_at_full_recall(curve):.2f}, recall without error "
        f"{recall_at_full_precision(curve):.2f}, area {area_under_curve(curve):.2f}"
    )

# %% Which way was I looking? Each view turned until it fits the one it was matched with
best = "sky, Zernike"
matches = found[best]
compass = turns_of_matches(known["sky"], seen["sky"], matches.reference, normalise=False)
is_matched = matches.reference >= 0
is_right = right_matches(matches.reference, apart.argmin(axis=0), TOLERANCE)
estimate = heading[matches.reference] - compass.turn
error = np.abs(np.rad2deg(wrap(estimate - query_heading)[is_right]))
metres = position_error(place, query_place, matches.reference)
print(f"{best}: off by {np.nanmedian(metres):.1f} m in the median, right matches by {np.median(error):.1f}° in heading")

# %% The same on the move: one view in, the best match of five views ago out, and where its line has led by now
describe = DESCRIPTORS["zernike"]
stream = begin_stream(describe(known["sky"]), describe.metric)
for view in seen["sky"][:60]:
    stream, match = locate_next(stream, describe(view))
behind = np.linalg.norm(place[match.reference_now] - query_place[59])
print(
    f"after 60 views: number {match.query} was taken at reference {match.reference}, by now the walker is at "
    f"{match.reference_now}, off by {behind:.1f} m"
)

# %% Draw
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 4.3), layout="constrained")
    axes = figure.subplot_mosaic("aaabbb;ccddee", height_ratios=[1.0, 1.9])
    example = int(np.flatnonzero(is_right)[60])
    for letter, layers, k, title in (
        ("a", seen, example, "rendered view in January"),
        ("b", known, matches.reference[example], "its match in May"),
    ):
        picture = layers["green"][k] / np.quantile(layers["green"][k], 0.97)
        axes[letter].imshow(np.clip(picture, 0, 1) ** 0.45, cmap="gray", extent=(-180, 180, -15, 90), aspect="auto")
        axes[letter].contour(
            np.linspace(-178.5, 178.5, 120), np.linspace(88.5, -13.5, 35), layers["sky"][k], [0.5],
            colors=COLOURS["orange"], linewidths=0.8,
        )  # fmt: skip
        axes[letter].set(xticks=range(-180, 181, 90), yticks=[0, 45, 90], xlabel="azimuth (deg)")
        name_panel(axes[letter], letter, title)
    axes["a"].set_ylabel("elevation (deg)")
    shades = axes["c"].imshow(differences[best], cmap=RATES, aspect="auto", origin="lower", interpolation="nearest")
    figure.colorbar(shades, ax=axes["c"], label="distance of amplitudes", pad=0.02, aspect=30)
    query = np.arange(len(query_place))
    for kind, colour in ((is_right, "white"), (is_matched & ~is_right, COLOURS["red"])):
        axes["c"].plot(query[kind], matches.reference[kind], ".", color=colour, markersize=1.8)
    axes["c"].set(xlabel="view in January", ylabel="view in May")
    name_panel(axes["c"], "c", f"difference ({best})")
    for (name, curve), colour in zip(curves.items(), ("grey", "blue", "green", "red"), strict=True):
        axes["d"].plot(curve.recall, curve.precision, drawstyle="steps-pre", color=COLOURS[colour], label=name)
    axes["d"].set(xlabel="recall", ylabel="precision", xlim=(0, 1.02), ylim=(0, 1.02))
    axes["d"].legend(loc="lower left")
    name_panel(axes["d"], "d", "within 12 m")
    axes["e"].plot(*place.T, color=COLOURS["grey"], linewidth=0.7, label="walk in May")
    for k in np.flatnonzero(is_matched & ~is_right):
        axes["e"].plot(*np.stack([query_place[k], place[matches.reference[k]]]).T, color=COLOURS["red"], linewidth=0.5)
    axes["e"].plot(*query_place[is_right].T, ".", color=COLOURS["blue"], markersize=3, label="right")
    axes["e"].plot(*query_place[is_matched & ~is_right].T, ".", color=COLOURS["red"], markersize=3, label="wrong")
    shown = np.flatnonzero(is_right)[::8]
    axes["e"].quiver(
        *query_place[shown].T, np.sin(estimate[shown]), np.cos(estimate[shown]),
        color=COLOURS["black"], scale=11, width=0.006, zorder=3,
    )  # fmt: skip
    axes["e"].set(xlabel="x (m)", ylabel="y (m)", aspect="equal", ylim=(-25, 430))
    axes["e"].legend(loc="best")
    name_panel(axes["e"], "e", "matches and headings")
    save_figure(figure, folder, "place-recognition")
print(f"figure: {folder / 'place-recognition.png'}")
