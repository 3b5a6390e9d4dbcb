# %% [markdown]
# # A survey: views all over a place, and which of two codes leads home
#
# A built ant world is surveyed on a grid: each view is rendered, described and let go of, so that grids of any size fit
# into memory. Distances to three remembered places come out, and from them catchment areas. Take a world of your own:
# `load_world("my-world.obj")`.
#
#     python examples/survey_a_world.py [FOLDER]

# %%
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, journal_style, name_panel, save_figure
from insectnav.homing import catchment_area, distance_from, grid_positions, random_headings, survey
from insectnav.vision.descriptors import DESCRIPTORS
from insectnav.worlds import load_world, render_panorama

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
folder.mkdir(parents=True, exist_ok=True)

# %% A clearing of 12 m radius, a box of 4 × 4 m in it, views every 20 cm, each at a heading of its own
SPACING, CORNER = 0.2, -2.0
world = load_world("ant-world", seed=4)
grid = grid_positions(4.0, SPACING, (CORNER, CORNER))  # (y, x, 2) [m]
headings = random_headings(grid.shape[:2], seed=1)
nests = np.array([[-1.0, -1.0], [0.0, 0.0], [1.0, 1.0]])

# %% What is measured of each view: how far it is from those remembered at the nests, facing north
remembered = render_panorama(world, nests, 0.0)
measures = {
    "pixels": distance_from(remembered),
    "pixels, best of all turns": distance_from(remembered, "compass"),
    "Zernike amplitudes": distance_from(remembered, DESCRIPTORS["zernike"]),
}
found = survey(world, grid, headings, measures)  # name -> (y, x, nest)

# %% Catchment areas
areas = {}
for name, distance in found.items():
    areas[name] = [
        catchment_area(distance[..., k], SPACING, nest - CORNER, 1.5 * SPACING) for k, nest in enumerate(nests)
    ]
    print(f"{name:28s} " + "  ".join(f"{area.area:5.2f} m²" for area in areas[name]) + " of 16 lead home")

# %% Draw those of the middle nest
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 2.5), layout="constrained")
    middle = grid[0, :-1, 0] + SPACING / 2
    for letter, axes, (name, distance) in zip("abc", figure.subplots(1, 3, sharey=True), found.items(), strict=True):
        surface, (area, is_inside) = distance[..., 1], areas[name][1]
        edges = (CORNER - SPACING / 2, -CORNER + SPACING / 2) * 2
        axes.imshow(surface, origin="lower", cmap="gray", extent=edges)
        axes.contour(middle, middle, is_inside, [0.5], colors=COLOURS["sky"], linewidths=1.0)
        axes.plot(*nests[1], "+", color=COLOURS["red"])
        axes.set(xlabel="x (m)", xticks=[-2, 0, 2], yticks=[-2, 0, 2])
        name_panel(axes, letter, f"{name}\n{area:.1f} m²")
    figure.axes[0].set_ylabel("y (m)")
    save_figure(figure, folder, "survey-a-world")
print(f"figure: {folder / 'survey-a-world.png'}")
