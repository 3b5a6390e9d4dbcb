"""Change a neuron, a synapse or a whole population of the circuit, and compare the ways home.

    python examples/change_a_neuron.py [FOLDER]

leaves change-a-neuron.png in FOLDER, out/examples by default.
"""

# %% What we need
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from insectnav.agents import ClampCells, random_routes, run_trials
from insectnav.central_complex import THESIS
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, journal_style, save_figure

N_ROUTES, N_STEPS, N_SHOWN, HOME_RANGE = 200, 1500, 30, 20.0
SETTINGS = {"n_inbound": N_STEPS, "noise": 0.1, "seed": 2}  # the seed gives trial k the same noise in every circuit

# %% Four circuits. Cells are counted from 0.
cut = THESIS.connectivity.cpu4_to_cpu1.copy()  # rows receive, columns send
cut[3, 10] = 0.0
one_synapse_less = replace(THESIS, connectivity=replace(THESIS.connectivity, cpu4_to_cpu1=cut))
silent_pontine = ClampCells(population="pontine", rate=0.0)
driven_cpu1 = ClampCells(population="cpu1", cells=(3,), rate=1.0, first_step=N_STEPS)  # on the way home only
CIRCUITS = {  # title: (circuit, clamps, colour)
    "intact": (THESIS, (), "blue"),
    "CPU4 10 → CPU1 3 cut": (one_synapse_less, (), "purple"),
    "pontine cells silenced": (THESIS, (silent_pontine,), "green"),
    "CPU1 3 held at rate 1": (THESIS, (driven_cpu1,), "red"),
}

# %% Closest distance to the nest over many routes; and many ways home from the end of the first of them
routes = random_routes(N_ROUTES, N_STEPS, seed=0)
first = tuple(np.repeat(routes[name].values[:1], N_SHOWN, axis=0) for name in ("heading", "velocity"))
closest, ways_home = {}, {}
print(f"closest distance to the nest in steps, {N_ROUTES} routes of {N_STEPS} steps out and as many home")
print(f"{'':30s} median   90th percentile   trials within {HOME_RANGE:g} steps   farther than intact")
for title, (circuit, clamps, _) in CIRCUITS.items():
    closest[title] = run_trials(routes, circuit, perturbations=clamps, **SETTINGS)["closest_distance"].values
    trials = run_trials(first, circuit, perturbations=clamps, **SETTINGS)
    ways_home[title] = trials["position"].values[:, N_STEPS - 1 :]
    middle, high = np.percentile(closest[title], [50.0, 90.0])
    found, worse = np.mean(closest[title] <= HOME_RANGE), np.mean(closest[title] > closest["intact"])
    print(f"{title:30s} {middle:6.1f}   {high:15.1f}   {100 * found:20.0f} %   {100 * worse:17.0f} %")

# %% Draw the ways home, on one scale, and how often each circuit comes how close
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 3.5))
    outbound = trials["position"].values[0, :N_STEPS]
    everything = np.concatenate([outbound, *(way.reshape(-1, 2) for way in ways_home.values())])
    low, high = everything.min(axis=0) - 10.0, everything.max(axis=0) + 10.0
    maps = figure.add_gridspec(1, 4, left=0.075, right=0.99, bottom=0.565, top=0.945, wspace=0.1)
    for cell, (title, (_, _, colour)) in zip(maps, CIRCUITS.items(), strict=True):
        axes = figure.add_subplot(cell)
        axes.plot(*outbound.T, color="0.6", linewidth=0.6)
        axes.add_collection(LineCollection(ways_home[title], colors=COLOURS[colour], linewidths=0.35, alpha=0.45))
        axes.add_patch(Circle((0.0, 0.0), HOME_RANGE, fill=False, linestyle="--", linewidth=0.7, zorder=3))
        axes.plot(*outbound[-1], marker="s", color=COLOURS["orange"], markersize=3.0, zorder=4)
        axes.plot(0.0, 0.0, marker="o", color="white", markeredgecolor="black", markersize=3.0, zorder=4)
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel="x (steps)")
        axes.set_title(title, loc="left", fontsize=7.0)
        axes.tick_params(labelleft=cell.is_first_col())
        axes.set_ylabel("y (steps)" if cell.is_first_col() else "")

    axes = figure.add_axes((0.075, 0.12, 0.655, 0.28))
    share = np.arange(1, N_ROUTES + 1) / N_ROUTES
    for title, (_, _, colour) in CIRCUITS.items():
        axes.plot(np.sort(closest[title]), share, drawstyle="steps-post", color=COLOURS[colour], label=title)
    axes.axvline(HOME_RANGE, color="black", linestyle="--", linewidth=0.7, label=f"{HOME_RANGE:g} steps")
    axes.set(xscale="log", xlabel="closest distance to the nest (steps)", ylabel="share of routes", ylim=(0.0, 1.02))
    axes.plot([], [], color="0.6", linewidth=0.6, label="outbound, the first route")
    square = {"marker": "s", "color": COLOURS["orange"], "markersize": 3.0, "linestyle": "none"}
    axes.plot([], [], label="turning point", **square)
    nest = {"marker": "o", "color": "white", "markeredgecolor": "black", "markersize": 3.0, "linestyle": "none"}
    axes.plot([], [], label="nest", **nest)
    axes.legend(loc="center left", bbox_to_anchor=(1.03, 0.5))

    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(figure, folder, "change-a-neuron")
print(f"figure: {folder / 'change-a-neuron.png'}")
