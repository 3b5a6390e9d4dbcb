"""Step the path integration circuit by hand: around a square, looking into its memory after each step.

    python examples/step_by_step.py [FOLDER]

leaves step-by-step.png in FOLDER, out/examples by default.
"""

# %% What we need
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from insectnav.angles import unit_vector
from insectnav.central_complex import THESIS, Senses, decode_home_vector, initial_state, step
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, RATES, journal_style, save_figure

N_CIRCUITS, NOISE = 100, 0.1  # the circuits differ by their noise only
SPEED, SIDE = 0.5, 120  # [steps per time step], [time steps]

# %% The walk: north, east, south, west, and so back to the nest. Headings are clockwise from +y.
heading = np.repeat(np.deg2rad([0.0, 90.0, 180.0, -90.0]), SIDE)
velocity = SPEED * unit_vector(heading)
position = np.cumsum(velocity, axis=0)
time = np.arange(1, len(heading) + 1)

# %% Every time step: tell all circuits where they look and how they move, keep their state, read their memory
state = initial_state(THESIS, shape=(N_CIRCUITS,), seed=0)
quiet = initial_state(THESIS)  # one more circuit, without noise
home_vectors, quiet_vectors, memories = [], [], []
for theta, v in zip(heading, velocity, strict=True):
    senses = Senses(heading=np.full(N_CIRCUITS, theta), velocity=np.tile(v, (N_CIRCUITS, 1)))
    state, rates = step(state, senses, THESIS, noise=NOISE)
    quiet, quiet_rates = step(quiet, Senses(heading=theta, velocity=v), THESIS)
    home_vectors.append(decode_home_vector(state.memory, THESIS))
    quiet_vectors.append(decode_home_vector(quiet.memory, THESIS))
    memories.append(quiet_rates.memory)
home_vector, quiet_vector, memory = np.array(home_vectors), np.array(quiet_vectors), np.array(memories)

# %% At the end of each side, the true home vector and the decoded one, both from the agent to the nest
print("time step   true home vector   decoded, no noise   decoded, noise 0.1: mean (SD), n = 100   [steps]")
for t in range(SIDE - 1, len(heading), SIDE):
    (x, y), (u, v), mean, sd = -position[t], quiet_vector[t], home_vector[t].mean(axis=0), home_vector[t].std(axis=0)
    noisy = f"{mean[0]:8.1f} ({sd[0]:.1f}), {mean[1]:8.1f} ({sd[1]:.1f})"
    print(f"{time[t]:9d}   {x:7.1f}, {y:7.1f}   {u:8.1f}, {v:8.1f}   {noisy}")

# %% Draw the walk with its home vectors, their length over time, and the memory
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 2.9))
    left = figure.add_axes((0.065, 0.145, 0.33, 0.76))
    left.plot(*np.vstack([np.zeros(2), position]).T, color="0.25", label="path")
    shown = np.arange(SIDE // 3 - 1, len(heading) - 1, SIDE // 3)
    arrows = {"angles": "xy", "scale_units": "xy", "scale": 1.0, "width": 0.006, "zorder": 3}
    left.quiver(*position[shown].T, *quiet_vector[shown].T, color=COLOURS["red"], **arrows)
    left.plot([], [], color=COLOURS["red"], label="decoded home vector")
    nest = {"marker": "o", "color": "white", "markeredgecolor": "black", "linestyle": "none", "zorder": 4}
    left.plot(0.0, 0.0, markersize=4.5, label="nest", **nest)
    left.set_aspect("equal")
    left.set(xlabel="x (steps)", ylabel="y (steps)", xlim=(-21, 81), ylim=(-14, 80))
    left.set_title("home vectors without noise", loc="left")
    left.legend(loc="upper center", ncols=3, handlelength=1.4, columnspacing=1.0)

    top = figure.add_axes((0.49, 0.6, 0.42, 0.305))
    length = np.linalg.norm(home_vector, axis=-1)
    low, high = np.percentile(length, [5.0, 95.0], axis=1)
    top.fill_between(time, low, high, color=COLOURS["sky"], alpha=0.5, linewidth=0.0, label="noise 0.1, 5 to 95 %")
    top.plot(time, np.linalg.norm(quiet_vector, axis=-1), color=COLOURS["red"], label="decoded, no noise")
    top.plot(time, np.linalg.norm(position, axis=-1), color="0.25", linestyle="--", label="true")
    top.set(ylabel="distance (steps)", xlim=(0, len(time)), xticks=np.arange(0, len(time) + 1, SIDE), ylim=(0.0, None))
    top.set_title("distance to the nest", loc="left")
    top.legend(loc="lower center", bbox_to_anchor=(0.5, 0.0))

    bottom = figure.add_axes((0.49, 0.145, 0.42, 0.305))
    extent = (0, len(time), 15.5, -0.5)
    image = bottom.imshow(memory.T, aspect="auto", interpolation="none", cmap=RATES, extent=extent)
    bottom.set(xlabel="time (steps)", ylabel="memory cell (index)", yticks=[0, 4, 8, 12], xticks=top.get_xticks())
    bottom.set_title("memory without noise", loc="left")
    bar = figure.colorbar(image, cax=figure.add_axes((0.925, 0.145, 0.012, 0.305)))
    bar.set_label("charge")

    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(figure, folder, "step-by-step")
print(f"figure: {folder / 'step-by-step.png'}")
