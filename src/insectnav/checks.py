"""Checks of what a user gives, and the error they raise: one sentence that guesses the slip."""

import difflib
import numbers
from collections.abc import Callable, Sequence
from types import EllipsisType
from typing import Any

import numpy as np
import numpy.typing as npt

FULL_TURN = 2 * np.pi  # [rad]


class InputError(ValueError):
    """An input that cannot be used.

    The message is one sentence on one line, without a final stop: it names the input, what was
    expected, what came, and the likely slip.
    """


def quoted(value: object, limit: int = 40) -> str:
    """Text from outside, safe inside a sentence: quoted, escaped to one line, shortened."""
    text = str(value)
    return repr(text if len(text) <= limit else text[: limit - 1] + "…")


def counted(number: int, one: str, many: str = "") -> str:
    """A number and what is counted, as a person writes it: 1 frame, 2 frames, 1 query.

    Parameters
    ----------
    number : int
    one : word, or words, for one of them
    many : the same for another number; "" adds an s
    """
    return f"{number} {one if number == 1 else many or one + 's'}"


def as_numbers(name: str, values: npt.ArrayLike) -> npt.NDArray[Any]:
    """Array of integers or floats, as given; refuses text, booleans and ragged lists."""
    try:
        array = np.asarray(values)
    except ValueError:
        raise InputError(f"{name} is ragged, expected rows of equal length") from None
    if array.dtype.kind not in "iuf":
        raise InputError(f"{name} holds {array.dtype.name} values, expected real numbers")
    return array


def check_choice(name: str, value: object, choices: Sequence[str]) -> None:
    """Refuse a value that is none of the choices; suggests the nearest."""
    if isinstance(value, str) and value in choices:
        return
    hint = did_you_mean(str(value).lower(), choices)
    raise InputError(f"{name} {quoted(value)} is unknown: expected one of {', '.join(choices)}{hint}")


def did_you_mean(word: str, choices: Sequence[str], show: Callable[[str], str] = str) -> str:
    """The nearest of the choices as the end of a sentence; nothing if none is near.

    Parameters
    ----------
    word : what came
    choices : what is there
    show : how a choice is written, `quoted` where it is from outside
    """
    near = difflib.get_close_matches(word[:100], choices, n=1)
    return f" (did you mean {show(near[0])}?)" if near else ""


def check_count(name: str, value: object, minimum: int = 1) -> None:
    """Refuse anything but a whole number of at least `minimum`."""
    if isinstance(value, numbers.Integral) and not isinstance(value, bool) and int(value) >= minimum:
        return
    shown = value if isinstance(value, numbers.Real) else quoted(value)
    raise InputError(f"{name} is {shown}, expected a whole number of at least {minimum}")


def check_precision(name: str, dtype: npt.DTypeLike) -> np.dtype[Any]:
    """Single or double precision, as a dtype; refuses any other."""
    try:
        spelling = np.dtype(dtype).name
    except TypeError:
        spelling = str(dtype)
    check_choice(name, spelling, ("float32", "float64"))
    return np.dtype(spelling)


def check_finite(name: str, values: npt.ArrayLike) -> None:
    """Refuse NaN and infinity; names the first."""
    array = as_numbers(name, values)
    bad = ~np.isfinite(array)
    if not bad.any():
        return
    index = tuple(int(i) for i in np.argwhere(bad)[0])
    where = f" at index {', '.join(map(str, index))}" if index else ""
    count = f" ({bad.sum()} of {bad.size} values)" if bad.size > 1 else ""
    raise InputError(f"{name} is {array[index]:g}{where}{count}, expected finite numbers")


def check_range(name: str, values: npt.ArrayLike, low: float, high: float, unit: str = "", slip: str = "") -> None:
    """Refuse values outside low ≤ value ≤ high, and NaN; names the worst.

    Parameters
    ----------
    values : number or array [unit]
    slip : the likely mistake, as the end of the sentence
    """
    array = as_numbers(name, values)
    bad = array[~((array >= low) & (array <= high))].astype(float)
    if not bad.size:
        return
    excess = np.where(np.isnan(bad), np.inf, np.maximum(low - bad, bad - high))
    worst, verb = bad[np.argmax(excess)], "reaches" if array.ndim else "is"
    expected = f"at least {low:g}" if high == np.inf else f"{low:g} to {high:g}"
    unit, slip = f" {unit}" if unit else "", f": {slip}" if slip else ""
    raise InputError(f"{name} {verb} {worst:g}, expected {expected}{unit}{slip}")


def check_radians(name: str, values: npt.ArrayLike) -> None:
    """Refuse angles beyond ±2π, which are degrees more likely than radians; NaN passes."""
    array = np.abs(as_numbers(name, values))
    beyond = array > FULL_TURN + 1e-6
    if beyond.any():
        worst = np.asarray(values)[np.unravel_index(np.argmax(np.where(beyond, array, 0)), array.shape)]
        verb = "reaches" if array.ndim else "is"
        raise InputError(f"{name} {verb} {worst:g}, expected radians within ±2π: degrees?")


def check_shape(name: str, array: npt.NDArray[Any], pattern: tuple[int | str | EllipsisType, ...]) -> None:
    """Refuse an array of another shape.

    Parameters
    ----------
    pattern : a length per axis; a word stands for any length, a leading ``...`` for any axes:
        ``("n", 2)``, ``(..., "directions")``
    """
    if _fits(array.shape, pattern):
        return
    words = ", ".join("..." if size is ... else str(size) for size in pattern)
    expected = f"({words},)" if len(pattern) == 1 else f"({words})"
    slip = ": transposed?" if array.ndim > 1 and _fits(array.shape[::-1], pattern) else ""
    raise InputError(f"{name} has shape {array.shape}, expected {expected}{slip}")


def _fits(shape: tuple[int, ...], pattern: tuple[int | str | EllipsisType, ...]) -> bool:
    if pattern[:1] == (...,):
        pattern = pattern[1:]
        if len(shape) < len(pattern):
            return False
        shape = shape[len(shape) - len(pattern) :]
    return len(shape) == len(pattern) and all(
        isinstance(size, str) or size == length for length, size in zip(shape, pattern, strict=True)
    )
