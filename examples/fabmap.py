# %% [markdown]
# # FAB-MAP: places by the words that they hold
#
# Panoramas along the streets of a rendered city are told from one another by the features in them: which of some
# hundred visual words each holds, learnt in another city. From these, FAB-MAP tells the probability that a picture was
# taken at each known place, or at none of them. After Cummins & Newman, IJRR 2008 and 2011, with the numbers of
# OpenFABMAP, against which Stone et al., ICRA 2016, compared the sky.
#
#     python examples/fabmap.py [FOLDER]

# %%
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from insectnav.angles import bearing
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, RATES, journal_style, name_panel, save_figure
from insectnav.matching import build_vocabulary, chow_liu_tree, fabmap
from insectnav.metrics.retrieval import precision_recall, recall_at_full_precision, right_matches
from insectnav.vision import panorama
from insectnav.worlds import light_world, render
from insectnav.worlds.builders import build_world
from insectnav.worlds.sky import Sky

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
folder.mkdir(parents=True, exist_ok=True)
camera = panorama(1.0, (-15.0, 60.0))  # 75 × 360 pixels
noon = Sky(sun_azimuth=np.deg2rad(140.0), sun_elevation=np.deg2rad(45.0))
evening = Sky(sun_azimuth=np.deg2rad(220.0), sun_elevation=np.deg2rad(12.0))


# %% Pictures along a route: green light, bright enough that one pixel in fifty is white, in bytes
def pictures(lit, route, start, end, spacing, aside=0.0):
    reached = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(route, axis=0), axis=1))])
    along = np.arange(start, end, spacing)
    here, before, after = (
        np.stack([np.interp(along + shift, reached, route[:, k]) for k in (0, 1)], axis=-1) for shift in (0, -1, 1)
    )
    heading = bearing(after - before)
    here = here + aside * np.stack([np.cos(heading), -np.sin(heading)], axis=-1)
    eye = np.column_stack([here, np.full(len(here), 2.0)])
    green = render(lit, eye, heading, camera=camera, layers=("green",), supersampling=2)["green"]
    white = np.quantile(green, 0.98, axis=(1, 2), keepdims=True)
    return (255 * np.clip(green / white, 0, 1) ** 0.45).astype(np.uint8), along


# %% Words and how they depend on each other, learnt in another city
another = build_world("city", seed=2)
training, _ = pictures(light_world(another, noon), another.route, 0.0, 960.0, 12.0)
vocabulary = build_vocabulary(training, n_words=300)
tree = chow_liu_tree(vocabulary.bags(training))
print(f"{len(training)} training images, {vocabulary.n_words} words, {tree.training.sum(axis=1).mean():.0f} an image")

# %% A map, and the same way again, half a metre aside, at the same hour and in the evening; and streets not in the map
city = build_world("city", seed=1)
at_noon, in_the_evening = light_world(city, noon), light_world(city, evening)
known, place = pictures(at_noon, city.route, 0.0, 480.0, 6.0)
elsewhere, _ = pictures(at_noon, city.route, 700.0, 1000.0, 6.0)
drives = {
    "same hour": pictures(at_noon, city.route, 2.0, 470.0, 7.0, aside=0.5),
    "evening": pictures(in_the_evening, city.route, 2.0, 470.0, 7.0, aside=0.5),
}
bags = vocabulary.bags(known)
found, curves, right = {}, {}, {}
for name, (seen, along) in drives.items():
    found[name] = fabmap(bags, vocabulary.bags(seen), tree)
    right[name] = right_matches(found[name].reference, along / 6.0, tolerance=2)
    curves[name] = precision_recall(right[name], found[name].score)
    print(
        f"{name:10s} {right[name].mean():.2f} of {len(seen)} within two places (12 m), recall without error "
        f"{recall_at_full_precision(curves[name]):.2f}"
    )
found["not in the map"] = fabmap(bags, vocabulary.bags(elsewhere), tree)
for name, matches in found.items():
    print(f"{name:14s} median probability of the match {np.median(matches.probability):.2f}")

# %% Draw
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 3.6), layout="constrained")
    axes = figure.subplot_mosaic("aaabbb;ccddee", height_ratios=[1.0, 1.9])
    shown, matches, is_right = 33, found["same hour"], right["same hour"]
    for letter, picture, title in (
        ("a", drives["same hour"][0][shown], "rendered view at noon"),
        ("b", drives["evening"][0][shown], "the same place in the evening"),
    ):
        axes[letter].imshow(picture, cmap="gray", vmin=0, vmax=255, extent=(-180, 180, -15, 60), aspect="auto")
        axes[letter].set(xticks=range(-180, 181, 90), yticks=[0, 30, 60], xlabel="azimuth (deg)")
        name_panel(axes[letter], letter, title)
    axes["a"].set_ylabel("elevation (deg)")
    below = matches.log_likelihood - matches.log_likelihood.max(axis=0)
    axes["c"].imshow(below, vmin=-40, cmap=RATES, aspect="auto", origin="lower", interpolation="nearest")
    query = np.arange(len(is_right))
    for kind, colour in ((is_right, "white"), (~is_right, COLOURS["red"])):
        axes["c"].plot(query[kind], matches.reference[kind], ".", color=colour, markersize=2.5)
    axes["c"].set(xlabel="view at the same hour", ylabel="place in the map")
    name_panel(axes["c"], "c", "likelihoods, matches")
    for (name, curve), colour in zip(curves.items(), ("blue", "orange"), strict=True):
        axes["d"].plot(curve.recall, curve.precision, drawstyle="steps-pre", color=COLOURS[colour], label=name)
    axes["d"].set(xlabel="recall", ylabel="precision", xlim=(0, 1.02), ylim=(0, 1.02))
    axes["d"].legend(loc="center")
    name_panel(axes["d"], "d", "within 12 m")
    edges = np.linspace(0, 1, 21)
    for (name, matches), colour in zip(found.items(), ("blue", "orange", "grey"), strict=True):
        share = np.mean(matches.probability[:, None] <= edges, axis=0)
        axes["e"].plot(edges, share, color=COLOURS[colour], label=name)
    axes["e"].set(xlabel="probability of the match", ylabel="share of views up to it", xlim=(0, 1), ylim=(0, 1.02))
    axes["e"].legend(loc="upper left")
    name_panel(axes["e"], "e", "how sure")
    save_figure(figure, folder, "fabmap")
print(f"figure: {folder / 'fabmap.png'}")
