# %% [markdown]
# # What may befall an animal on its trip
#
# The ways home from one foraging trip: undisturbed, with a wall in between, carried aside, with the body turned on the
# way out, to the feeder by a stored vector, and with a frozen memory. After Stone et al. 2017, Fig. 5a, Extended Data
# Fig. 10d-f, Supplementary Notes and Discussion, doi 10.1016/j.cub.2017.08.052.
#
#     python examples/perturbations.py [FOLDER]
#
# leaves perturbations.png and perturbations.pdf in FOLDER, out/examples by default.

# %%
import sys
from pathlib import Path

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from insectnav.agents import Displace, FreezeMemory, SetMemory, TurnBody, Wall, random_routes, run_trials
from insectnav.central_complex import THESIS, circuit_params
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, journal_style, save_figure

N_OUT, N_HOME, N_TRIALS, N_SHOWN, RANGE = 1500, 800, 100, 10, 20.0
CARRIED = (100.0, 0.0)  # [steps]
WALL = Wall(start=(-40.0, 70.0), end=(70.0, 70.0))
VARIANTS = {"non-holonomic": "red", "partially-holonomic": "blue", "fully-holonomic": "green"}

# %% One trip out, a hundred times: the route is the same in all of them, the noise is not
trip = random_routes(7, N_OUT, seed=5).isel(trial=6)
route = tuple(np.repeat(trip[name].values[None], N_TRIALS, axis=0) for name in ("heading", "velocity"))
at_nest = np.zeros((N_TRIALS, 1)), np.zeros((N_TRIALS, 1, 2))  # one step out, in which nothing moves


def ways_home(*perturbations, circuit=THESIS, out=route):
    """Paths (trial, step, 2) from where the way home begins, and the memory there (trial, 16)."""
    trials = run_trials(out, circuit, n_inbound=N_HOME, noise=0.1, seed=1, perturbations=perturbations)
    return trials["position"].values[:, out[0].shape[1] - 1 :], trials["memory_at_turn"].values


# %% Each panel: title, goal, and the paths that are drawn, by colour
home, stored = ways_home()
outbound = trip["velocity"].values.cumsum(axis=0)
nest, feeder = np.zeros(2), outbound[-1]
carried, _ = ways_home(Displace(step=N_OUT, by=CARRIED))
to_feeder, _ = ways_home(SetMemory(memory=stored, mode="subtract"), out=at_nest)
body = TurnBody(offset=np.pi / 2)
turned = {name: ways_home(body, circuit=circuit_params(name))[0] for name in VARIANTS}
PANELS = {
    "undisturbed": (nest, {"": home}),
    "a wall in the way": (nest, {"": ways_home(WALL)[0]}),
    "carried 100 steps aside": (np.array(CARRIED), {"": carried}),
    "body turned by 90° on the way out": (nest, turned),
    "stored vector loaded at the nest": (feeder, {"": to_feeder}),
    "memory frozen at the turning point": (nest, {"": ways_home(FreezeMemory(first_step=N_OUT))[0]}),
}

# %% How near they come to the nest and to where they should end up, and how far from the latter they are at the end
print(f"medians in steps over {N_TRIALS} ways of {N_HOME} steps; found: came within {RANGE:g} steps of the goal")
print(f"{'':56s} nest: closest   goal: closest   found   at the end")
for title, (goal, paths) in PANELS.items():
    for name, path in paths.items():
        to_nest, to_goal = np.linalg.norm(path, axis=-1), np.linalg.norm(path - goal, axis=-1)
        nearest, found = np.median(to_goal.min(axis=1)), 100.0 * np.mean(to_goal.min(axis=1) <= RANGE)
        label = f"{title}, {name}" if name else title
        print(f"{label:56s} {np.median(to_nest.min(axis=1)):13.1f} {nearest:15.1f} {found:6.0f} % "
              f"{np.median(to_goal[:, -1]):10.1f}")  # fmt: skip

# %% Draw them on one scale
LOW, HIGH = (-140.0, -110.0), (160.0, 190.0)
DOT = {"marker": "o", "color": "white", "markeredgecolor": "black", "markersize": 3.5, "linestyle": "none", "zorder": 4}
SQUARE = {"marker": "s", "color": COLOURS["orange"], "markersize": 3.5, "linestyle": "none", "zorder": 4}
ARROW = {"arrowstyle": "->", "linewidth": 0.8, "shrinkA": 0.0, "shrinkB": 0.0}
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 5.1))
    grid = figure.add_gridspec(2, 3, left=0.07, right=0.99, bottom=0.13, top=0.96, wspace=0.08, hspace=0.16)
    for letter, cell, (title, (goal, paths)) in zip("abcdef", grid, PANELS.items(), strict=True):
        axes = figure.add_subplot(cell)
        axes.plot(*outbound.T, color="0.75", linewidth=0.6)
        for name, path in paths.items():
            colour = COLOURS[VARIANTS.get(name, "blue")]
            axes.add_collection(LineCollection(path[:N_SHOWN], colors=colour, linewidths=0.5, alpha=0.6))
        axes.add_patch(Circle(goal, RANGE, fill=False, linestyle="--", linewidth=0.8, zorder=3))
        axes.plot(*feeder, **SQUARE)
        axes.plot(*nest, **DOT)
        axes.set(xlim=(LOW[0], HIGH[0]), ylim=(LOW[1], HIGH[1]), aspect="equal")
        axes.set_title(f"{letter}  {title}", loc="left", fontsize=7.0)
        axes.tick_params(labelleft=cell.is_first_col(), labelbottom=cell.is_last_row())
        axes.set_xlabel("x (steps)" if cell.is_last_row() else "")
        axes.set_ylabel("y (steps)" if cell.is_first_col() else "")
        if letter == "b":
            axes.plot(*zip(WALL.start, WALL.end, strict=True), color="black", linewidth=2.0, solid_capstyle="butt")
        if letter == "c":
            axes.annotate("", feeder + CARRIED, feeder, arrowprops=ARROW)
    axes.plot([], [], color="0.75", linewidth=0.6, label="trip out")
    axes.plot([], [], label="turning point, feeder", **SQUARE)
    axes.plot([], [], label="nest", **DOT)
    axes.plot([], [], color="black", linestyle="--", linewidth=0.8, label=f"{RANGE:g} steps round the goal")
    for name, colour in VARIANTS.items():
        axes.plot([], [], color=COLOURS[colour], linewidth=0.8, label=name)
    figure.legend(*axes.get_legend_handles_labels(), loc="lower center", ncols=7, columnspacing=1.2, handlelength=1.6)
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(figure, folder, "perturbations")
print(f"figure: {folder / 'perturbations.png'}")
