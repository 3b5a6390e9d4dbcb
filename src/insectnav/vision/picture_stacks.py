"""Pictures in any number of leading axes, with or without a last axis of bands, as one plain stack."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, as_numbers, check_finite, check_range, check_shape

Reals = NDArray[np.floating[Any]]


class Stack(NamedTuple):
    """Pictures one after the other, and how they came."""

    pictures: Reals  # (n, rows, columns, band)
    shape: tuple[int, ...]  # as given
    batch: tuple[int, ...]  # the leading axes

    def values_of_each(self, name: str, values: ArrayLike, has_bands: bool) -> Reals:
        """One value a picture and band, (n, band), from a number or an array that goes with the leading axes.

        Parameters
        ----------
        values : (...) array, or (..., band) if there are bands; axes of length 1 and missing ones are repeated

        Raises
        ------
        InputError
            If the array does not go with the pictures.
        """
        array = as_numbers(name, values).astype(np.float64)
        check_finite(name, array)
        n_bands = self.pictures.shape[-1]
        wanted = (*self.batch, n_bands) if has_bands else self.batch
        try:
            spread = np.broadcast_to(array, wanted)
        except ValueError:
            axes = "leading axes and bands" if has_bands else "leading axes"
            raise InputError(
                f"{name} has shape {array.shape}, expected one value or an array that goes with the {axes} {wanted}"
            ) from None
        return spread.reshape(len(self.pictures), n_bands if has_bands else 1)

    def restored(self, pictures: NDArray[Any]) -> NDArray[Any]:
        """Pictures (n, rows, columns, band) in the shape in which they came."""
        return pictures.reshape(self.shape)


def radiance_stack(radiance: ArrayLike, has_bands: bool) -> Stack:
    """Pictures of radiance as a stack.

    Parameters
    ----------
    radiance : (..., rows, columns) array, or (..., rows, columns, band) if `has_bands`; not negative

    Raises
    ------
    InputError
        If it is no picture, or a value is negative or not finite.
    """
    array = as_numbers("radiance", radiance)
    check_shape("radiance", array, (..., "rows", "columns", "band") if has_bands else (..., "rows", "columns"))
    check_finite("radiance", array)
    check_range("radiance", array, 0.0, np.inf)
    if array.dtype.kind != "f":
        array = array.astype(np.float64)
    picture = array.shape[-3:] if has_bands else (*array.shape[-2:], 1)
    batch = array.shape[: -3 if has_bands else -2]
    n = int(np.prod(batch))
    return Stack(array.reshape(n, *picture), array.shape, batch)
