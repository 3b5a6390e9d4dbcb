"""Analyse spike times of compass and flow cells as Stone et al. 2017 did: from the recording to the tuning.

    python examples/physiology.py [FOLDER]

leaves physiology.png in FOLDER, out/examples by default. The spike times are made up here, Poisson spikes of known
tuning, so that you see what should come out: put your own in their place.
"""

# %% What we need
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from insectnav.angles import wrap
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, journal_style, save_figure
from insectnav.metrics.physiology import background_rate, population_tuning, preferred_expansion_point, tuning_curve
from insectnav.metrics.polarisation_tuning import polarisation_tuning
from insectnav.metrics.receptive_fields import receptive_fields

rng = np.random.default_rng(1)


def made_up_spikes(rate, step):
    """Poisson spikes [s] for a rate [impulses/s] given every `step` seconds."""
    interval = np.repeat(np.arange(len(rate)), rng.poisson(np.maximum(rate, 0.0) * step))
    return np.sort((interval + rng.uniform(size=len(interval))) * step)


# %% A polariser over the animal: four turns clockwise, four anticlockwise, at 60°/s, its angle recorded at 100 Hz
time = np.arange(0.0, 48.0, 0.01)
angle = np.deg2rad(60.0) * np.minimum(time, 48.0 - time)
ahead = np.deg2rad(20.0) * np.where(time < 24.0, 1.0, -1.0)  # this cell anticipates the turn, by 20°
rate = 10.0 + 50.0 * np.exp(2.0 * (np.cos(2.0 * (angle + ahead - np.deg2rad(35.0))) - 1.0))
spike_times = made_up_spikes(rate, 0.01)

cell = polarisation_tuning(spike_times, time, wrap(angle))
true_width = np.rad2deg(np.arccos(1.0 + np.log((1.0 + np.exp(-4.0)) / 2.0) / 2.0))
print(f"a compass cell; made up: prefers 35°, anticipates by 20°, so that the shift is 40°, width {true_width:.1f}°")
for name, turn in (("clockwise", cell.clockwise), ("anticlockwise", cell.anticlockwise)):
    test, preferred, width = turn.test, np.rad2deg(turn.test.mean_angle), np.rad2deg(turn.width)
    print(f"  {name:13s}: {test.n} spikes, {preferred:.1f}°, Rayleigh p = {test.p_value:.1g}, width {width:.1f}°")
print(f"  shift between the two {np.rad2deg(cell.shift):.1f}°")

# %% Optic flow: 5 s of darkness, then bouts of 0.5 s still, 3 s moving, 3 s dark; five cells, each velocity twice
velocity = np.tile(np.arange(-90.0, 91.0, 30.0), 2)  # [°/s]
start = 5.5 + 6.5 * np.arange(len(velocity))
clock = np.arange(0.0, start[-1] + 6.0, 0.01)
curves = []
for _ in range(5):
    rate = np.full(len(clock), 20.0)  # background
    for begin, v in zip(start, velocity, strict=True):
        rate[(clock >= begin) & (clock < begin + 3.0)] += 1.2 * v if v > 0 else 0.2 * v
    spikes = made_up_spikes(rate, 0.01)
    background = background_rate(spikes, first_onset=5.0)
    curves.append(tuning_curve(spikes, start, start + 3.0, velocity, background=background))
speed_tuning = population_tuning(curves)
print("a speed cell; made up: 20 impulses/s, and 1.2 more for each °/s forwards")
print("  °/s forwards", *(f"{v:6.0f}" for v in speed_tuning.condition))
print(
    "  normalised  ",
    *(f"{mean:6.2f}" for mean in speed_tuning.mean),
    f"  background {speed_tuning.background_mean:.2f}",
)

# %% Flow that expands from twelve azimuths
azimuth = np.deg2rad(np.arange(-180.0, 180.0, 30.0))
expansion_rate = rng.poisson(2.0 * (30.0 + 25.0 * np.cos(azimuth - np.deg2rad(45.0)))) / 2.0  # of 2 s each
point = preferred_expansion_point(azimuth, expansion_rate)
print(f"its preferred expansion point {np.rad2deg(point.azimuth):.0f}°; made up: 45°")

# %% A bar that goes round in 192 frames and 6 s: twice clockwise, twice anticlockwise
bar = np.tile(np.linspace(-np.pi, np.pi, 192, endpoint=False), (4, 1))
bar[2:] = bar[2:, ::-1]
edges = np.linspace(0.0, 6.0, 193) + 8.0 * np.arange(4)[:, None]
preferred_side = np.array([1.0, 1.0, -1.0, -1.0])[:, None] * np.sin(bar - np.deg2rad(-60.0))
bar_rate = 30.0 + 25.0 * preferred_side  # motion away from −60° excites, on either side of it
spikes = np.concatenate([t[0] + made_up_spikes(r, 6.0 / 192) for t, r in zip(edges, bar_rate, strict=True)])
fields = receptive_fields(spikes, edges, bar)

# %% Draw all four
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 2.3), layout="constrained")
    places = figure.add_gridspec(1, 4)
    compass, flow, field = (figure.add_subplot(places[0, k]) for k in (0, 1, 3))
    expansion = figure.add_subplot(places[0, 2], projection="polar", theta_offset=np.pi / 2.0, theta_direction=-1)
    for name, turn, colour in (("clockwise", cell.clockwise, "blue"), ("anticlockwise", cell.anticlockwise, "orange")):
        compass.stairs(turn.histogram.rate, np.linspace(-90.0, 90.0, 19), color=COLOURS[colour], label=name)
        compass.axvline(np.rad2deg(turn.test.mean_angle), color=COLOURS[colour], ymax=0.78, ls="--", linewidth=0.8)
    compass.set(xlabel="angle of polariser (deg)", ylabel="rate (impulses/s)", xticks=[-90, 0, 90], ylim=(0.0, 90.0))
    compass.legend(loc="upper left", ncols=1)
    flow.axhspan(*(speed_tuning.background_mean + speed_tuning.background_sd * np.array([-1, 1])), color="0.85")
    flow.errorbar(speed_tuning.condition, speed_tuning.mean, speed_tuning.sd, fmt="o", markersize=3.0, color="black")
    flow.set(xlabel="velocity of flow (deg/s)", ylabel="normalised rate", xticks=[-90, 0, 90], ylim=(0.0, 1.1))
    expansion.plot(np.append(azimuth, azimuth[0]), np.append(expansion_rate, expansion_rate[0]), "k.-")
    expansion.annotate("", (point.azimuth, 60.0), (0.0, 0.0), arrowprops={"arrowstyle": "->", "color": COLOURS["red"]})
    expansion.set(ylim=(0.0, 70.0), yticks=[30.0, 60.0], xticks=np.deg2rad([0.0, 90.0, 180.0, 270.0]))
    expansion.set_xticklabels(["0°", "90°", "180°", "-90°"])
    expansion.set_rlabel_position(225.0)  # where there is least to hide
    titles = ("compass cell", "speed cell", "expansion (impulses/s)", "receptive field")
    for axes, title in zip((compass, flow, expansion, field), titles, strict=True):
        axes.set_title(title, fontsize=7.0)
    for found, colour in zip(fields, ("blue", "orange"), strict=True):
        field.plot(np.rad2deg(found.azimuth), found.normalised, color=COLOURS[colour])
    field.set(xlabel="azimuth of bar (deg)", ylabel="normalised rate", xticks=[-180, 0, 180], ylim=(0.0, 1.05))

    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(figure, folder, "physiology")
print(f"figure: {folder / 'physiology.png'}")
