"""What an image costs FAB-MAP: its features and words, and its likelihood at every place, beside the plain way.

Bags are made up, a few words frequent and most of them rare; times do not depend on what they show. The plain way is
tests/fabmap_oracle.py, one word and place at a time, for few of the pairs. Seconds are those of processors. Run it by
``make bench``.
"""

import statistics
import time
from collections.abc import Callable

import numpy as np

import fabmap_oracle
from insectnav.matching import build_vocabulary, chow_liu_tree, fabmap

N_RUNS = 5


def seconds(function: Callable[[], object]) -> float:
    started = time.process_time()
    function()
    return time.process_time() - started


def made_bags(n: int, n_words: int, per_image: int, rng: np.random.Generator) -> np.ndarray:
    share = np.random.default_rng(0).pareto(1.5, n_words) + 0.1
    return rng.random((n, n_words)) < np.minimum(per_image * share / share.sum(), 0.8)


def likelihoods(n_words: int, n_places: int, per_image: int) -> None:
    rng = np.random.default_rng(1)
    training, places, queries = (made_bags(n, n_words, per_image, rng) for n in (1000, n_places, 100))
    planting = seconds(lambda: chow_liu_tree(training))
    tree = chow_liu_tree(training)
    plain = {
        "parent": {q: None if tree.root == q else int(p) for q, p in enumerate(tree.parent)},
        "p": dict(enumerate(tree.marginal.tolist())),
        "given": dict(enumerate(zip(tree.given_absent.tolist(), tree.given_present.tolist(), strict=True))),
    }
    fabmap(places[:2], queries[:2], tree)
    ratios, times = [], []
    for _ in range(N_RUNS):
        times.append(seconds(lambda: fabmap(places, queries, tree)) / len(queries))
        one = min(seconds(lambda k=k: fabmap_oracle.likelihood(places[k], queries[k], plain)) for k in range(3))
        ratios.append(one * (n_places + len(training)) / times[-1])  # places, and images as samples of new ones
    name = f"{n_words} words, {n_places} places"
    print(
        f"{name:44s} {1e3 * statistics.median(times):8.2f} ms a query, {statistics.median(ratios):6.0f} times faster "
        f"({min(ratios):.0f} … {max(ratios):.0f}); tree {planting:.1f} s",
        flush=True,
    )


def pictures(n: int, shape: tuple[int, int]) -> np.ndarray:
    """Boxes of all sizes, bytes."""
    rng = np.random.default_rng(2)
    out = np.full((n, *shape), 120, np.uint8)
    for picture in out:
        for row, column, height, width, value in rng.integers((*shape, 60, 60, 256), size=(200, 5)):
            picture[row : row + height, column : column + width] = value
    return out


def features() -> None:
    images = pictures(8, (270, 480))
    for detector in ("sift", "orb"):
        vocabulary = build_vocabulary(images, n_words=500, detector=detector)
        run = min(seconds(lambda v=vocabulary: v.bags(images)) for _ in range(3)) / len(images)
        print(f"{f'words of 480 × 270 pixels, {detector}':44s} {1e3 * run:8.2f} ms an image", flush=True)


def main() -> None:
    features()
    for n_words, n_places, per_image in ((1000, 1000, 150), (1000, 10_000, 150), (10_000, 1000, 300)):
        likelihoods(n_words, n_places, per_image)


if __name__ == "__main__":
    main()
