# %% [markdown]
# # Homing by views, at the same heading and at any
#
# A clearing with trees round it, seen from a grid of places. How far the view at each place is from the one remembered
# at the goal is a surface; where its slope leads home is the catchment area. Pixel by pixel that works for an animal
# that looks the way it looked at the goal, with Zernike amplitudes for any heading. After Stone et al. 2018,
# doi 10.1098/rsfs.2018.0010.
#
#     python examples/compare_views.py [FOLDER]

# %%
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from insectnav.angles import bearing, wrap
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, RATES, journal_style, name_panel, save_figure
from insectnav.homing import catchment_area, feature_distance, random_headings, visual_compass
from insectnav.vision.descriptors import retinotopic, wrap_to_disk, zernike_amplitudes

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
folder.mkdir(parents=True, exist_ok=True)

# %% Trees, as upright cylinders with round tops; brightness is 1 for the sky, 0.25 for plants, 0.1 for the ground
rng = np.random.default_rng(3)
N_TREES, ROWS, COLUMNS, FINE = 60, 70, 240, 3  # pixels of 1.5°, three rays across each
angle, distance = rng.uniform(0, 2 * np.pi, N_TREES), rng.uniform(7.0, 25.0, N_TREES)
trees = np.stack([distance * np.sin(angle), distance * np.cos(angle)], axis=-1)
radius, height = rng.uniform(0.3, 1.2, N_TREES), rng.uniform(1.0, 6.0, N_TREES)
row_top = 90.0 - 1.5 * np.arange(ROWS)[:, None]  # [°]


def panorama(place, heading=0.0):
    """What is seen from a place, (ROWS, COLUMNS) bytes: each pixel by how much of it is sky, plants and ground."""
    azimuth = (np.arange(FINE * COLUMNS) + 0.5) * 2 * np.pi / (FINE * COLUMNS) - np.pi + heading
    to_tree = trees - place
    apart = np.linalg.norm(to_tree, axis=-1)[:, None]
    from_tree = azimuth - bearing(to_tree)[:, None]
    aside = apart * np.sin(from_tree) / radius[:, None]
    is_hit = (np.abs(aside) < 1.0) & (np.cos(from_tree) > 0.0)
    top = height[:, None] * np.sqrt(np.maximum(1.0 - aside**2, 0.0))
    skyline = np.rad2deg(np.arctan(np.where(is_hit, top / apart, 0.0).max(axis=0)))
    plants = np.clip((skyline - row_top + 1.5) / 1.5, 0.0, 1.0).reshape(ROWS, COLUMNS, FINE).mean(axis=-1)
    above_ground = np.where(row_top > 0.0, 1.0 - 0.75 * plants, 0.1)
    return np.rint(255 * above_ground).astype(np.uint8)


# %% Views on a grid of 0.25 m, all looking north, and again each at a heading of its own; the goal is off the middle
SPACING, N = 0.25, 33
side = SPACING * np.arange(N)
places = np.stack(np.meshgrid(side, side), axis=-1) - side[-1] / 2  # (y, x, 2) [m]
goal = np.array([16, 13])  # column and row
headings = random_headings((N, N), seed=1)
north = np.array([[panorama(place) for place in row] for row in places])
anyhow = np.array([[panorama(places[i, j], headings[i, j]) for j in range(N)] for i in range(N)])
remembered = north[goal[1], goal[0]]

# %% Distance of each view from the remembered one; from how far around does its slope lead to within 0.375 m?
surfaces = {}
for name, describe in (("pixels", retinotopic), ("Zernike amplitudes", zernike_amplitudes)):
    for how, views in (("same heading", north), ("random headings", anyhow)):
        surfaces[f"{name}, {how}"] = feature_distance(describe(views), describe(remembered))
catchments = {
    name: catchment_area(surface, SPACING, goal * SPACING, 1.5 * SPACING) for name, surface in surfaces.items()
}
for name, (area, _) in catchments.items():
    print(f"{name:36s} {area:6.2f} m² of {side[-1] ** 2:.0f} lead home")

# %% A visual compass: turn on the spot until the view fits best
found = visual_compass(anyhow[10:17, 13:20], remembered)
error = np.rad2deg(wrap(found.turn + headings[10:17, 13:20]))
print(f"visual compass within a metre of the goal: off by {np.abs(error).mean():.2f}° on average, a column is 1.5°")

# %% Draw
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 3.7), layout="constrained")
    axes = figure.subplot_mosaic("aaab;cdef", height_ratios=[1.0, 1.25])
    axes["a"].imshow(remembered, cmap="gray", vmin=0, vmax=255, extent=(-180, 180, -15, 90), aspect="auto")
    axes["a"].set(xlabel="azimuth (deg, right is positive)", ylabel="elevation (deg)", xticks=range(-180, 181, 90))
    name_panel(axes["a"], "a", "the remembered view")
    axes["b"].imshow(wrap_to_disk(remembered, 140), cmap="gray", vmin=0.0, vmax=1.0)
    axes["b"].set_axis_off()
    name_panel(axes["b"], "b", "wrapped")
    for letter, (name, surface) in zip("cdef", surfaces.items(), strict=True):
        panel, (area, is_inside) = axes[letter], catchments[name]
        panel.imshow(surface / surface.max(), origin="lower", cmap=RATES, extent=(-0.125, 8.125, -0.125, 8.125))
        panel.contour(side[:-1] + 0.125, side[:-1] + 0.125, is_inside, [0.5], colors=COLOURS["red"], linewidths=0.9)
        panel.plot(*goal * SPACING, "+", color="white", markersize=6)
        panel.set(xticks=[0, 4, 8], yticks=[0, 4, 8], xlabel="x (m)")
        name_panel(panel, letter, f"{name.replace(', ', chr(10))}\n{area:.1f} m²")
    axes["c"].set_ylabel("y (m)")
    save_figure(figure, folder, "compare-views")
print(f"figure: {folder / 'compare-views.png'}")
