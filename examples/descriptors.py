# %% [markdown]
# # What each descriptor costs, how large it is, and what it does not see
#
# Places in a rendered city, each looked at again by an eye that has turned, tilted or moved. A descriptor is of use if
# a place stays more like itself than like any other. Descriptors of your own, of a network or another program, come as
# arrays (frame, feature) from .npy files and are compared the same way.
#
#     python examples/descriptors.py [FOLDER]

# %%
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.ndimage import convolve

from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, journal_style, name_panel, save_figure
from insectnav.matching import difference_matrix
from insectnav.vision import panorama
from insectnav.vision.descriptors import DESCRIPTORS
from insectnav.worlds import light_world, render
from insectnav.worlds.builders import build_world
from insectnav.worlds.sky import Sky

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
folder.mkdir(parents=True, exist_ok=True)
GREY = ("retinotopic", "frequency-strip", "patch-normalised", "patch-normalised-v1")  # the others look at the sky alone

# %% Thirty places along a walk, and the same after a turn, a tilt or a step aside
world = build_world("city", seed=1)
city = light_world(world, Sky(sun_azimuth=np.deg2rad(140.0), sun_elevation=np.deg2rad(45.0)))
place = world.route[:: len(world.route) // 30][:30]


def look(turn_deg=0.0, tilt_deg=0.0, aside=0.0):
    """Green light and the mask of the sky, (30, 35, 120) each, of an eye 2 m above the ground."""
    eye = np.column_stack([place + np.array([aside, 0.0]), np.full(len(place), 2.0)])
    turn, tilt = np.deg2rad(turn_deg), np.deg2rad(tilt_deg)
    return render(city, eye, turn, tilt, camera=panorama(3.0), layers=("green", "sky"), supersampling=2)


def seconds(describe, views):
    """Seconds of processors that it takes to describe the views."""
    started = time.process_time()
    describe(views)
    return time.process_time() - started


tilts = [10, 20, 30]
changes = {"turn of 90°": (90.0, 0.0), "turn of 37°": (37.0, 0.0), "1 m aside": (0.0, 0.0, 1.0)}
changes |= {f"tilt of {tilt}°": (0.0, tilt) for tilt in tilts}
level, changed = look(), {name: look(*pose) for name, pose in changes.items()}

# %% How many of the thirty are nearest to themselves afterwards, and what a view costs
found, cost, size = {}, {}, {}
for name, describe in DESCRIPTORS.items():
    layer = "green" if name in GREY else "sky"
    remembered = describe(level[layer])
    cost[name] = 1e3 * min(seconds(describe, level[layer]) for _ in range(5)) / len(place)
    size[name] = remembered.shape[-1]
    found[name] = [
        np.mean(difference_matrix(remembered, describe(views[layer]), describe.metric).argmin(axis=0) == range(30))
        for views in changed.values()
    ]

# %% Bring your own: whatever wrote these files, one row a view. Here filters drawn at random stand for a network
OWN = "own, from .npy"
filters = np.random.default_rng(0).normal(size=(16, 5, 5))


def own(views):
    """Sixteen random filters, rectified, means of 7 × 12 pixels: (view, 16 × 5 × 10)."""
    grey = views / views.mean(axis=(1, 2), keepdims=True)
    maps = [np.maximum(convolve(view, kernel, mode="wrap"), 0) for view in grey for kernel in filters - filters.mean()]
    return np.reshape(maps, (len(views), 16, 5, 7, 10, 12)).mean(axis=(3, 5)).reshape(len(views), -1)


with tempfile.TemporaryDirectory() as files:
    for name, views in {"remembered": level, **changed}.items():
        np.save(Path(files) / f"{name}.npy", own(views["green"]).astype(np.float32))
    remembered = np.load(Path(files) / "remembered.npy", allow_pickle=False)
    cost[OWN] = 1e3 * seconds(own, level["green"]) / len(place)
    size[OWN] = remembered.shape[-1]
    found[OWN] = [
        np.mean(
            difference_matrix(remembered, np.load(Path(files) / f"{name}.npy", allow_pickle=False), "cosine").argmin(
                axis=0
            )
            == range(30)
        )
        for name in changed
    ]

print(f"{'':22s}{'features':>9s}{'ms':>7s}  " + "  ".join(changes))
for name, shares in found.items():
    row = "  ".join(f"{100 * share:{len(change) - 1}.0f}%" for change, share in zip(changes, shares, strict=True))
    print(f"{name:22s}{size[name]:9d}{cost[name]:7.2f}  {row}")

# %% Draw
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 2.6), layout="constrained")
    left, middle, right = figure.subplots(1, 3, sharey=True, width_ratios=(1.0, 1.5, 1.0))
    row = np.arange(len(found))[::-1]
    colours = [COLOURS["orange" if name == OWN else "grey" if name in GREY else "blue"] for name in found]
    left.barh(row, list(cost.values()), color=colours, height=0.6)
    left.set(yticks=row, yticklabels=list(found), xscale="log", xlabel="time a view (ms)")
    name_panel(left, "a", "cost")
    middle.imshow(
        100 * np.array(list(found.values())), cmap="cividis", vmin=0, vmax=100, aspect="auto",
        extent=(-0.5, len(changes) - 0.5, -0.5, len(found) - 0.5),
    )  # fmt: skip
    for y, shares in zip(row, found.values(), strict=True):
        for x, share in enumerate(shares):
            middle.text(
                x,
                y,
                f"{100 * share:.0f}",
                ha="center",
                va="center",
                fontsize=6,
                color="black" if share > 0.5 else "white",
            )
    middle.set_xticks(
        range(len(changes)), [name.replace(" of ", "\n").replace(" aside", "\naside") for name in changes]
    )
    name_panel(middle, "b", "found again (%)")
    right.barh(row, list(size.values()), color=colours, height=0.6)
    right.set(xscale="log", xlabel="features")
    name_panel(right, "c", "size")
    save_figure(figure, folder, "descriptors")
print(f"figure: {folder / 'descriptors.png'}")
