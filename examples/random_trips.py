# %% [markdown]
# # Eight foraging trips and the ways home
#
# Random outbound routes, the circuit's way home from each, and how close 1000 such trips come to the nest at five
# levels of noise. After Stone et al. 2017, Extended Data Fig. 8 and Fig. 5c, doi 10.1016/j.cub.2017.08.052.

# %%
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from insectnav.agents import random_routes, run_trials
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, journal_style, save_figure

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
folder.mkdir(parents=True, exist_ok=True)

# %% Eight trips: 1500 steps out, 1500 home, 10 % noise on every cell.
trips = run_trials(random_routes(8, 1500, seed=4), n_inbound=1500, noise=0.1, seed=4)

# %% A thousand trips at each level of noise; trial k has the same route and the same random numbers at every level.
noises = [0.0, 0.1, 0.2, 0.3, 0.4]
routes = random_routes(1000, 1500, seed=1)
closest = [run_trials(routes, n_inbound=1500, noise=noise, seed=1)["closest_distance"].values for noise in noises]
for noise, distances in zip(noises, closest, strict=True):
    middle, high = np.percentile(distances, [50, 90])
    print(
        f"noise {noise}: closest distance median {middle:.1f}, 90th percentile {high:.1f} steps (n = {len(distances)})"
    )

# %%
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 3.6), layout="constrained")
    axes = figure.subplot_mosaic("abcd++;efgh++".replace("+", "z"), empty_sentinel=".")
    for trial, name in enumerate("abcdefgh"):
        panel, trip = axes[name], trips.isel(trial=trial)
        for leg, colour in (("out", "0.25"), ("home", COLOURS["blue"])):
            panel.plot(*trip["position"].values[trip["leg"].values == leg].T, color=colour, linewidth=0.6)
        panel.add_patch(Circle((0, 0), 20, fill=False, linestyle="--", linewidth=0.6, color=COLOURS["red"], zorder=3))
        panel.set_aspect("equal", adjustable="datalim")
        panel.tick_params(labelsize=5)
    axes["e"].set_xlabel("x (steps)")
    axes["e"].set_ylabel("y (steps)")
    boxes = axes["z"].boxplot(closest, widths=0.6, whis=(5, 95), showfliers=False, patch_artist=True)
    for box in boxes["boxes"]:
        box.set(facecolor=COLOURS["sky"], linewidth=0.6)
    axes["z"].axhline(20, color=COLOURS["red"], linestyle="--", linewidth=0.8)
    axes["z"].set_yscale("log")
    axes["z"].set_xticks(range(1, len(noises) + 1), [f"{noise:g}" for noise in noises])
    axes["z"].set_xlabel("noise σ$_r$ (SD of each rate)")
    axes["z"].set_ylabel("closest distance to the nest (steps)")
    axes["z"].set_title("n = 1000, whiskers 5–95 %", loc="right", fontsize=6)
    save_figure(figure, folder, "random-trips")
print(f"figure: {folder / 'random-trips.png'}")
