# %% [markdown]
# # A map of places that stays on disk
#
# Two drives become a map; a third is found on it, by comparing with all places and by an index, all at once and on the
# move. Descriptors are made up: smooth functions of where the eye is, other light on another day.
#
#     python examples/place_map.py [FOLDER]

# %%
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, journal_style, name_panel, save_figure
from insectnav.matching import MapAbout, PlaceMap, merge_maps

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
folder.mkdir(parents=True, exist_ok=True)
rng = np.random.default_rng(4)
FEATURES, WAVE = 60, 8.0  # [m] over which a feature changes


# %% A way through the plane, a frame every 2 m, and what is seen from any place
def way(n):
    """Places (n, 3) [m] of a drive that turns at random."""
    heading = np.cumsum(0.08 * rng.normal(size=n))
    step = 2.0 * np.stack([np.sin(heading), np.cos(heading), np.zeros(n)], axis=-1)
    return np.cumsum(step, axis=0)


slopes, phases = rng.normal(size=(2, FEATURES)) / WAVE, rng.uniform(0, 2 * np.pi, FEATURES)


def seen_from(place, noise):
    """Descriptors (n, FEATURES), with noise of this standard deviation for each feature."""
    features = np.cos(place[:, :2] @ slopes + phases)
    return (features + noise * rng.normal(size=features.shape)).astype(np.float32)


# %% Two days of driving, each put on disk a hundred frames at a time: what has been added stays, whatever happens then
about = MapAbout(descriptor="made up", metric="euclidean", n_features=FEATURES, camera="none")
main_road = way(1200)
side_road = main_road[500] + way(500)
with tempfile.TemporaryDirectory() as name:
    maps = Path(name)
    days = []
    for day, road in (("monday", main_road), ("tuesday", side_road)):
        made = PlaceMap.create(maps / day, about)
        for first in range(0, len(road), 100):
            part = road[first : first + 100]
            names = [f"{day}-{first + i:04d}.png" for i in range(len(part))]
            made.add(seen_from(part, 0.3), positions=part, names=names)
        days.append(made)
    both = merge_maps(maps / "both", days)
    both.freeze()  # side by side, with an index
    both = PlaceMap.open(maps / "both")
    print(both.n_places, "places on", both.routes.max() + 1, "routes")

    # %% A third drive: along the main road, into the side road, 10 % faster and a metre or so aside
    there = np.concatenate([main_road[200:500], side_road[:400]])
    along = np.arange(0, len(there) - 1, 1.1)
    drive = np.stack([np.interp(along, np.arange(len(there)), there[:, k]) for k in range(3)], axis=1)
    drive[:, :2] += 0.7 * rng.normal(size=(len(drive), 2))
    noises, share = np.linspace(0.2, 1.6, 8), {"exact": [], "index": []}
    for noise in noises:
        queries = seen_from(drive, noise)
        for search in share:
            matches = both.locate(queries, about=about, search=search)
            is_matched = matches.reference >= 0
            apart = np.linalg.norm(drive - both.positions[matches.reference], axis=1)
            is_right = is_matched & (apart < 10.0)
            share[search].append(is_right.sum() / is_matched.sum())
            if np.isclose(noise, 1.0):
                print(f"{search}: {is_right.sum()} of {is_matched.sum()} within 10 m, median {np.median(apart):.1f} m")
                shown = (is_right, is_matched & ~is_right, queries)

    # %% The same on the move: a frame in, where its line has led to by now out
    stream = both.stream(search="index")
    for frame in shown[2][:100]:
        stream, match = stream.locate_next(frame)
    now, then = both.names[match.reference_now], both.names[match.reference]
    print(f"frame 99 is near {now}, frame {match.query} was at {then}")

    # %% How long a query takes on larger and larger maps
    sizes, seconds = np.array([2000, 10_000, 50_000, 200_000]), {"exact": [], "index": []}
    for n in sizes:
        large = PlaceMap.build(maps / str(n), seen_from(way(n), 0.3), about)
        large.freeze()
        asked = large.descriptors[n // 2 : n // 2 + 100] + rng.normal(size=(100, FEATURES)).astype(np.float32)
        for search, times in seconds.items():
            large.locate(asked[:11], search=search)  # loads the index
            started = time.process_time()
            large.locate(asked, search=search, workers=1)
            times.append((time.process_time() - started) / len(asked))

# %% Draw
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 2.5), layout="constrained")
    axes = figure.subplot_mosaic("aabbcc")
    for road, label in ((main_road, "on the map"), (side_road, None)):
        axes["a"].plot(*road[:, :2].T, color=COLOURS["grey"], linewidth=0.7, label=label)
    for kind, colour, label in zip(shown[:2], ("blue", "red"), ("within 10 m", "farther off"), strict=True):
        axes["a"].plot(*drive[kind, :2].T, ".", color=COLOURS[colour], markersize=2, label=label)
    axes["a"].set(xlabel="x (m)", ylabel="y (m)")
    axes["a"].set_aspect("equal", adjustable="datalim")
    axes["a"].legend(loc="best")
    name_panel(axes["a"], "a", "third drive, noise 1, index")
    for search, colour, label in (("exact", "black", "all places"), ("index", "orange", "index")):
        axes["b"].plot(noises, share[search], "o-", color=COLOURS[colour], markersize=3, label=label)
        axes["c"].loglog(sizes, 1e3 * np.array(seconds[search]), "o-", color=COLOURS[colour], markersize=3, label=label)
    axes["b"].set(xlabel="noise of a feature (s.d.)", ylabel="matches within 10 m", ylim=(0, 1.02))
    axes["b"].legend(loc="lower left")
    name_panel(axes["b"], "b", "what is found")
    axes["c"].set(xlabel="places on the map", ylabel="time of a query (ms)")
    axes["c"].legend(loc="upper left")
    name_panel(axes["c"], "c", "cost on one core")
    save_figure(figure, folder, "place-map")
print(f"figure: {folder / 'place-map.png'}")
