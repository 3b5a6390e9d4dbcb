"""How fast strokes grow to a mask: one line each, with the ratio to the automaton on NumPy arrays in the same run.

The picture is made here: a bright sky above a ragged ground, both with noise, and two strokes. Wall time drifts on
shared machines, so each fast measurement stands between two plain ones, and the median of the ratios is what to quote.
"""

import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from growcut_oracle import array_automaton  # the plain way
from insectnav.vision.growcut import StrokeGrower, grow_cut

SMALL, LARGE = (403, 604), (3000, 4000)
N_RUNS = 5


def seconds(function: Callable[[], object]) -> float:
    started = time.perf_counter()
    function()
    return time.perf_counter() - started


def made_picture(rows: int, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """Colours (rows, columns, 3) as bytes and strokes."""
    rng = np.random.default_rng(0)
    skyline = rows * (0.55 + 0.1 * np.sin(np.arange(columns) * 40.0 / columns)) + rng.normal(0.0, rows / 60, columns)
    is_sky = np.arange(rows)[:, None] < skyline
    shade = np.where(is_sky, 190.0 - 60.0 * np.arange(rows)[:, None] / rows, 70.0)
    noise = rng.normal(0.0, 1.0, (rows, columns, 3)) * np.where(is_sky, 3.0, 20.0)[..., None]
    picture = np.clip(shade[..., None] * [0.8, 0.9, 1.0] + noise, 0, 255).astype(np.uint8)
    strokes = np.zeros((rows, columns), np.uint8)
    strokes[rows // 8 : rows // 8 + 6, columns // 4 : -columns // 4] = 2
    strokes[-rows // 8 : -rows // 8 + 6, columns // 4 : -columns // 4] = 1
    return picture, strokes


def main() -> None:
    picture, strokes = made_picture(*SMALL)
    plain = array_automaton(picture, strokes)
    grown = grow_cut(picture, strokes)
    apart = (grown.labels != plain[0]).sum()
    print(f"{SMALL[1]} × {SMALL[0]} pixels in colour; the automaton takes {plain[2]} steps; {apart} labels differ")
    times, ratios = [], []
    before = seconds(lambda: array_automaton(picture, strokes))
    for _ in range(N_RUNS):
        times.append(statistics.median(seconds(lambda: grow_cut(picture, strokes)) for _ in range(5)))
        after = seconds(lambda: array_automaton(picture, strokes))
        ratios.append((before + after) / 2.0 / times[-1])
        before = after
    print(f"{'automaton on arrays':32s} {1e3 * before:8.0f} ms")
    print(
        f"{'grow_cut':32s} {1e3 * statistics.median(times):8.0f} ms   1/{statistics.median(ratios):.0f} of plain "
        f"(1/{min(ratios):.0f} … 1/{max(ratios):.0f})"
    )
    for shape in (SMALL, LARGE):
        picture, strokes = made_picture(*shape)
        grower = StrokeGrower(picture)
        first = seconds(lambda grower=grower, strokes=strokes: grower.grow(strokes))
        more = strokes.copy()
        more[shape[0] // 3 : shape[0] // 3 + 6, : shape[1] // 6] = 2
        then = seconds(lambda grower=grower, more=more: grower.grow(more))
        name = f"{shape[1]} × {shape[0]}"
        print(f"{name + ', first strokes':32s} {1e3 * first:8.0f} ms")
        print(f"{name + ', one stroke more':32s} {1e3 * then:8.0f} ms")


if __name__ == "__main__":
    main()
