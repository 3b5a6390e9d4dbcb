"""Fig. 5e: how straight the way home is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.central_complex import PRESETS, circuit_params
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2017_path_integration.trips import N_STEPS, PRESET_NAMES, random_trips, ways_home
from insectnav.metrics.statistics import bootstrap_error
from insectnav.metrics.straightness import distance_left, distance_left_along, tortuosity

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "Fig. 5e"
TITLE = "distance to the nest against path walked on the way home"
NOISE = 0.1  # Fig. 5e
SHARES = np.linspace(0.0, 1.5, 151)  # of the straight way home
PERCENTILES = (10, 25, 50, 75, 90)
PRESET_COLOURS = {"thesis": "blue", "code-2017": "orange"}


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One set of constants."""

    preset: str
    n_trials: int = 4000  # Fig. 5e has 1000; more make the error of ours small beside that of the published number


def grid(scale: str) -> Sequence[Cell]:
    """Both sets of constants."""
    n_trials = 4000 if scale == "full" else 500
    return [Cell(preset=preset, n_trials=n_trials) for preset in PRESETS]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Share of the way left of each trial, its straight distance, and the curve over all trials."""
    arrays = random_trips(cell.n_trials, circuit_params(preset=cell.preset), noise=NOISE, seed=seed)
    path = ways_home(arrays, N_STEPS)
    curves = distance_left_along(path, SHARES)
    return {
        "distance_left": (("trial",), distance_left(path)),
        "end_distance_left": (("trial",), distance_left_along(path, [1.0], nearest_so_far=False)[:, 0]),
        "straight_distance": (("trial",), np.linalg.norm(path[:, 0], axis=-1), {"units": "steps"}),
        "share": (("share",), SHARES),
        "curve_mean": (("share",), np.nanmean(curves, axis=0)),
        "curve_percentile": (("percentile", "share"), np.nanpercentile(curves, PERCENTILES, axis=0)),
    }


def summarise(results: Results) -> Table:
    """Tortuosity as it is plotted, and as the formula of the text has it, for each set of constants."""
    rows = []
    for cell, arrays in results:
        left, straight = arrays["distance_left"], arrays["straight_distance"]
        end = straight * arrays["end_distance_left"]
        rows.append(
            {
                "preset": cell.preset,
                "tortuosity": tortuosity(left),
                "tortuosity_standard_error": bootstrap_error(left, _tortuosity),
                "mean_way_over_mean_gain": _way_over_gain(straight, end),
                "mean_way_over_mean_gain_standard_error": _ratio_error(straight, end),
                "median_of_way_over_gain": float(np.nanmedian(straight / (straight - end))),
                "median_distance_left": float(np.nanmedian(left)),
                "mean_straight_distance": float(np.mean(straight)),
                "n": int(np.isfinite(left).sum()),
                "n_too_short": int(np.isnan(left).sum()),
            }
        )
    return rows


def _tortuosity(left: NDArray[Any], axis: int) -> NDArray[Any]:
    """`insectnav.metrics.straightness.tortuosity` along an axis."""
    return 1.0 / (1.0 - np.mean(left, axis=axis))


def _way_over_gain(straight: NDArray[Any], end: NDArray[Any]) -> float:
    """Mean L over mean C = L − d_L, of trials whose path is long enough."""
    is_long = np.isfinite(end)
    return float(straight[is_long].sum() / (straight - end)[is_long].sum())


def _ratio_error(straight: NDArray[Any], end: NDArray[Any]) -> float:
    """Standard error of the ratio of two means: that of the mean residual (L − ratio · C) over the mean C."""
    is_long = np.isfinite(end)
    straight, gain = straight[is_long], (straight - end)[is_long]
    residual = straight - straight.sum() / gain.sum() * gain
    return float(np.std(residual, ddof=1) / np.sqrt(residual.size) / gain.mean())


def draw(results: Results) -> Figure:
    """Distance left against path walked, a panel for each set of constants; the straight line for comparison."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 2.7), layout="constrained")
    panels = figure.subplots(1, len(results.cells), sharex=True, sharey=True, squeeze=False)[0]
    for axes, (cell, arrays), row in zip(panels, results, summarise(results), strict=True):
        colour = COLOURS[PRESET_COLOURS[cell.preset]]
        walked, bands = 100.0 * arrays["share"], 100.0 * arrays["curve_percentile"]
        axes.fill_between(walked, bands[0], bands[-1], color=colour, alpha=0.18, linewidth=0.0, label="10 to 90 %")
        axes.fill_between(walked, bands[1], bands[-2], color=colour, alpha=0.3, linewidth=0.0, label="25 to 75 %")
        axes.plot(walked, 100.0 * arrays["curve_mean"], color=colour, linewidth=1.4, label="mean")
        axes.plot(walked, bands[2], color=colour, linewidth=0.9, linestyle=(0, (3, 1.5)), label="median")
        axes.plot([0.0, 100.0, 150.0], [100.0, 0.0, 0.0], color="black", linewidth=0.7, label="straight line")
        axes.axvline(100.0, color=COLOURS["grey"], linewidth=0.6, linestyle=":")
        axes.set_title(f"{PRESET_NAMES[cell.preset]}: L/C = {row['tortuosity']:.3f}", loc="left")
        axes.set_xlabel("path walked (% of the straight way L)")
        axes.set_xlim(0.0, 150.0)
        axes.set_ylim(0.0, 100.0)
        axes.legend(loc="upper right")
    panels[0].set_ylabel("distance to the nest (% of L)")
    return figure


def caption(results: Results) -> str:
    """What is shown, and of how many trials."""
    rows = summarise(results)
    values = ", ".join(f"{row['tortuosity']:.3f} with {PRESET_NAMES[row['preset']]}" for row in rows)
    return (
        "Nearest distance to the nest so far, against the path walked since the turning point, both in per cent of "
        f"the straight way home L; random trips of {N_STEPS} steps, noise {NOISE:g}, n = "
        f"{results.cells[0].n_trials} trials, the same routes in both panels. Bands: percentiles over trials. "
        f"Tortuosity L/C is 1 / (1 − mean share left after a path of length L, dotted line): {values}."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Tortuosity under both sets of constants, and the formula of the text."""
    thesis, code = (next(row for row in table if row["preset"] == preset) for preset in ("thesis", "code-2017"))
    ours = {
        "tortuosity": (thesis["tortuosity"], thesis["tortuosity_standard_error"]),
        "tortuosity, 2017 code's constants": (code["tortuosity"], code["tortuosity_standard_error"]),
        "mean way over mean gain": (
            thesis["mean_way_over_mean_gain"],
            thesis["mean_way_over_mean_gain_standard_error"],
        ),
    }
    why = f"with the other constants it is {{:.3f}}; the median share left is {thesis['median_distance_left']:.3f}"
    others = {
        "tortuosity": why.format(code["tortuosity"]),
        "tortuosity, 2017 code's constants": why.format(thesis["tortuosity"]),
        "mean way over mean gain": why.format(code["mean_way_over_mean_gain"]),
    }
    return [judge(value, *ours[name], why=others[name]) for name, value in published.items()]
