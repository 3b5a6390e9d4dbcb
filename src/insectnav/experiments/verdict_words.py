"""Verdicts, numbers with their errors and durations, as people read them."""

import math
from collections.abc import Sequence

from insectnav.experiments.published import AGREES, DIFFERS, NOT_COMPARABLE, Verdict

VERDICTS = (AGREES, DIFFERS, NOT_COMPARABLE)
MISSING = "–"
AS_PRINTED = 6  # significant digits of published numbers


def verdict_counts(verdicts: Sequence[Verdict]) -> dict[str, int]:
    """Number of each kind of verdict."""
    given = [verdict.verdict for verdict in verdicts]
    return {kind: given.count(kind) for kind in VERDICTS}


def counts_text(verdicts: Sequence[Verdict]) -> str:
    """The same in words: ``4 agree, 1 differs, 2 not comparable``."""
    if not verdicts:
        return "no published number"
    counts = verdict_counts(verdicts)
    verbs = {kind: kind if counts[kind] == 1 else kind.removesuffix("s") for kind in (AGREES, DIFFERS)}
    shown = [f"{counts[kind]} {verbs.get(kind, kind)}" for kind in VERDICTS]
    return ", ".join(shown if counts[NOT_COMPARABLE] else shown[:2])


def number_text(value: float, digits: int = 4) -> str:
    """A number with so many significant digits; a dash where there is none."""
    if not math.isfinite(value):
        return MISSING if math.isnan(value) else ("∞" if value > 0 else "−∞")
    return f"{value:.{digits}g}".replace("-", "−")


def published_text(verdict: Verdict) -> str:
    """The published number, its unit, and in brackets the range that it stands for."""
    unit = _after_number(verdict.unit)
    span = f"{number_text(verdict.low, AS_PRINTED)} to {number_text(verdict.high, AS_PRINTED)}"
    if not math.isfinite(verdict.published):
        return f"{span}{unit}"
    value = f"{number_text(verdict.published, AS_PRINTED)}{unit}"
    return value if verdict.low == verdict.high == verdict.published else f"{value} ({span})"


def _after_number(unit: str) -> str:
    return f" {unit}" if unit not in {"", "1"} else ""


def ours_text(verdict: Verdict) -> str:
    """Our number, its standard error with two digits where it has one, and the unit."""
    value, error = verdict.ours, verdict.uncertainty
    unit = _after_number(verdict.unit) if math.isfinite(value) else ""
    if not (math.isfinite(value) and math.isfinite(error) and error > 0.0):
        return f"{number_text(value)}{unit}"
    decimals = 1 - math.floor(math.log10(error))
    if not 0 <= decimals <= 6 or abs(value) >= 1e6:
        return f"{number_text(value)} ± {error:.2g}{unit}"
    return f"{value:.{decimals}f} ± {error:.{decimals}f}{unit}".replace("-", "−")


def duration_text(seconds: float) -> str:
    """A time with the units that suit it: ``4.2 s``, ``3 min 20 s``, ``1 h 5 min``."""
    if seconds < 59.95:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest} s"
    return f"{minutes // 60} h {minutes % 60} min"
