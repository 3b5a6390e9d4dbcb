# %% [markdown]
# # Cameras, grids and compound eyes
#
# One made-up scene, seen through a fisheye camera, on grids of the sphere, and by an ant. All of it is values on
# directions: the camera says where each pixel looks, the resampler what each direction sees.

# %%
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from insectnav.angles import bearing
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, journal_style, name_panel, save_figure
from insectnav.vision import (
    azimuth_elevation,
    desert_ant,
    directions,
    fisheye,
    honeybee,
    interommatidial_angles,
    panorama,
    resampler,
    rotation_matrix,
)
from insectnav.vision.sphere import equirectangular, fibonacci, gauss_legendre, thesis


def brightness(views: np.ndarray) -> np.ndarray:
    """A bright sky above a skyline of bushes, brighter towards a sun at 60° to the right; the ground is dark."""
    azimuth, elevation = azimuth_elevation(views)
    skyline = np.deg2rad(
        14.0 + 9.0 * np.sin(3.0 * azimuth) + 5.0 * np.sin(7.0 * azimuth + 1.0) + 2.0 * np.sin(23.0 * azimuth)
    )
    sun = np.exp(4.0 * (views @ directions(np.deg2rad(60.0), np.deg2rad(50.0)) - 1.0))
    return np.where(elevation > skyline, 0.6 + 0.4 * sun, np.where(elevation > 0.0, 0.25, 0.1))


# %% A fisheye of 185° that looks up: an image, and the 2000 directions of the published skyline codes
camera = fisheye((320, 320), np.deg2rad(185.0))
image = np.full(camera.size, np.nan)
shown = camera.pixels_seen()
image[shown] = brightness(camera.pixel_directions()[shown])
grid = thesis()
on_grid = resampler(camera, grid)(np.nan_to_num(image))
print(
    f"{grid.n_directions} directions, {np.rad2deg(grid.spacing):.1f}° apart, see {np.nanmean(on_grid):.3f} on average"
)

# %% The same camera tilted by 20°: its own frame tilts, what it sees does not
tilted = fisheye((320, 320), np.deg2rad(225.0), mounting=(-np.pi, np.deg2rad(70.0), 0.0))
tilted_image = np.zeros(tilted.size)
tilted_image[tilted.pixels_seen()] = brightness(tilted.pixel_directions()[tilted.pixels_seen()])
difference = np.abs(resampler(tilted, grid)(tilted_image) - on_grid)
print(f"tilted by 20°, it sees the same to {np.nanmean(difference):.3f} on average")

# %% A panorama through the eyes of an ant that looks 40° to the right, nose 10° down
scene = panorama(0.5, (-90.0, 90.0))
ant, bee = desert_ant(), honeybee()
see = resampler(scene, ant, rotation=rotation_matrix(np.deg2rad(40.0), np.deg2rad(-10.0)))
seen_by_ant = see(brightness(scene.pixel_directions()))
for eye in (ant, bee):
    right = eye.directions[eye.side == 1]
    angle, width = np.median(interommatidial_angles(right)), np.median(eye.acceptance)
    print(
        f"{eye.name}: {len(right)} ommatidia an eye, {np.rad2deg(angle):.1f}° apart, {np.rad2deg(width):.1f}° wide; "
        f"{np.count_nonzero(eye.is_dorsal_rim) // 2} of them in the dorsal rim"
    )

# %% Draw
grids = {
    "equirectangular, 10°": equirectangular(10.0, (0.0, 90.0)),
    "Gauss-Legendre, 18 rings": gauss_legendre(18),
    "Fibonacci, 648 points": fibonacci(648),
}
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 4.0), layout="constrained")
    top, bottom = figure.subfigures(2, 1, height_ratios=(1.0, 1.05))
    panels = top.subplots(1, 4)
    panels[0].imshow(np.ma.masked_invalid(image), cmap="gray", vmin=0.0, vmax=1.0)
    name_panel(panels[0], "a", "fisheye, looking up")
    for panel, letter, (name, points) in zip(panels[1:], "bcd", grids.items(), strict=True):
        above = points.directions[:, 2] > 0.0
        views, weights = points.directions[above], points.weights[above]
        # Seen from below, as by the camera, in a projection that keeps areas; so are the dots.
        radius = np.sqrt(2.0) * np.sin((np.pi / 2 - azimuth_elevation(views)[1]) / 2)
        angle = bearing(views[:, :2])
        panel.scatter(-radius * np.sin(angle), radius * np.cos(angle), s=350.0 * weights, color=COLOURS["blue"], lw=0)
        panel.add_patch(Circle((0, 0), 1.0, fill=False, lw=0.6))
        panel.set(xlim=(-1.05, 1.05), ylim=(-1.05, 1.05), aspect="equal")
        name_panel(panel, letter, name)
    for panel in panels:
        panel.axis("off")
    figure.get_layout_engine().set(h_pad=0.08)  # the titles touch the edge without
    maps = bottom.subplots(1, 2, subplot_kw={"projection": "mollweide"})
    spacing = np.concatenate([interommatidial_angles(bee.directions[bee.side == side]) for side in (-1, 1)])
    for panel, eye, values, limits, label, colours in (
        (maps[0], ant, seen_by_ant, (0.0, 1.0), "brightness seen", "gray"),
        (maps[1], bee, np.rad2deg(spacing), (1.5, 4.5), "interommatidial angle (deg)", "cividis"),
    ):
        one = eye.side == 1 if eye is bee else np.ones(eye.n_ommatidia, dtype=bool)
        azimuth, elevation = azimuth_elevation(eye.directions)
        size = 14.0 if eye is ant else 2.0
        dots = panel.scatter(azimuth[one], elevation[one], c=values[one], s=size, vmin=limits[0], vmax=limits[1],
                             cmap=colours, lw=0, rasterized=True)  # fmt: skip
        rim = eye.is_dorsal_rim & one
        panel.scatter(azimuth[rim], elevation[rim], s=1.5, color=COLOURS["red"], lw=0, label="dorsal rim")
        panel.set_xticks(np.deg2rad([-120, -60, 0, 60, 120]), ["-120°", "-60°", "0°", "60°", "120°"], fontsize=5.0)
        panel.set_yticks(np.deg2rad([-60, -30, 0, 30, 60]), ["-60°", "-30°", "0°", "30°", "60°"], fontsize=5.0)
        panel.grid(color="0.8", linewidth=0.3)
        panel.set_axisbelow(True)
        title = f"{eye.name}, {'both eyes' if eye is ant else 'right eye'}"
        name_panel(panel, "e" if eye is ant else "f", title)
        bottom.colorbar(dots, ax=panel, label=label, shrink=0.7, pad=0.02)
        panel.legend(loc="lower right", bbox_to_anchor=(1.05, -0.12), markerscale=2.5)

    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(figure, folder, "views")
print(f"figure: {folder / 'views.png'}")
