"""GrowCut: from a few strokes of paint to a label for every pixel.

Each painted pixel attacks its neighbours, and these theirs. An attack is weaker the more the colours differ, and a
pixel takes the label of whoever attacks it with more than its own strength, until nothing changes any more.
"""

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, as_numbers, check_choice, check_finite, check_range

BESIDE, ACROSS = ((0, -1), (0, 1), (-1, 0), (1, 0)), ((-1, -1), (-1, 1), (1, -1), (1, 1))  # rows, columns
NEIGHBOURHOODS = {"moore": BESIDE + ACROSS, "von-neumann": BESIDE}
MAX_PIXELS = 2**28
MAX_LABEL = 2**31 - 1
LEAST_SEED_STRENGTH = 1e-9  # of a soft stroke


class GrowCut(NamedTuple):
    """What strokes grow to.

    Parameters
    ----------
    labels : (rows, columns) array of the type of the strokes; 0 where no stroke reaches
    strength : (rows, columns) array, 1 on the strokes and less the more colours were crossed; 0 where none reaches
    """

    labels: NDArray[Any]
    strength: NDArray[np.float64]


def grow_cut(
    image: ArrayLike, strokes: ArrayLike, *, neighbourhood: str = "moore", seed_strength: ArrayLike = 1.0
) -> GrowCut:
    """Labels and strengths (rows, columns) at which the GrowCut automaton comes to rest.

    Parameters
    ----------
    image : (rows, columns) or (rows, columns, band) array
        Of any real type and scale; differences of colour are Euclidean over the bands as they are.
    strokes : (rows, columns) array of whole numbers
        0 where nothing is painted, else a label from 1.
    neighbourhood : str
        "moore", 8 neighbours, or "von-neumann", 4.
    seed_strength : number or (rows, columns) array
        Of the painted pixels: 1 for strokes that are kept, less for those that a stronger neighbour may take.

    Returns
    -------
    GrowCut

    Raises
    ------
    InputError
        If the strokes do not fit the image, nothing is painted, or values make no sense.

    Notes
    -----
    Vezhnevets & Konouchine 2005, "GrowCut: Interactive multi-label N-D image segmentation by cellular automata",
    GraphiCon: cell q attacks its neighbour p with g(‖C_p − C_q‖₂) · θ_q, where g(x) = 1 − x / max‖C‖₂ over the image,
    and wins where that exceeds θ_p; all cells at once, until nothing changes. There θ_p is the greatest product of g
    along any path from a stroke, and that is what is computed, see `insectnav.vision.growcut_kernel`. Two strokes that
    reach a pixel equally strong are told apart as the automaton does, by who comes first; then the lower label wins,
    on which the paper is silent. Negative g, possible where values are negative, counts as 0: no attack.
    """
    return StrokeGrower(image, neighbourhood=neighbourhood).grow(strokes, seed_strength)


class StrokeGrower:
    """An image on which strokes grow again and again, as somebody paints.

    Where strokes were only added since the last time, growth goes on from there: the result is the same and is there
    sooner.

    Parameters
    ----------
    image, neighbourhood
        As of `grow_cut`.
    """

    def __init__(self, image: ArrayLike, *, neighbourhood: str = "moore") -> None:
        check_choice("neighbourhood", neighbourhood, tuple(NEIGHBOURHOODS))
        self._steps = np.array(NEIGHBOURHOODS[neighbourhood])
        array = as_numbers("image", image)
        if array.ndim not in (2, 3) or array.size == 0:
            raise InputError(f"image has shape {array.shape}, expected (rows, columns) or (rows, columns, bands)")
        check_range("number of pixels of the image", array.shape[0] * array.shape[1], 1, MAX_PIXELS)
        if array.dtype.kind == "f":
            check_finite("image", array)
        self.shape: tuple[int, int] = array.shape[:2]
        exact = np.float32 if np.can_cast(array.dtype, np.float32) else np.float64
        kept = np.uint8 if array.dtype == np.uint8 else exact
        self._pixels = np.ascontiguousarray(array.reshape(self.shape[0] * self.shape[1], -1), kept)
        self._painted: NDArray[Any] | None = None  # strokes of the last time
        self._length = np.empty(0, np.int64)
        self._order = np.empty(0, np.int64)

    @cached_property
    def _greatest(self) -> float:
        """max‖C‖₂, or 1 for a black image."""
        squares = np.zeros(len(self._pixels))
        for band in self._pixels.T:
            squares += band.astype(np.float64) ** 2
        return float(np.sqrt(squares.max())) or 1.0

    def grow(self, strokes: ArrayLike, seed_strength: ArrayLike = 1.0) -> GrowCut:
        """Labels and strengths for these strokes.

        Parameters
        ----------
        strokes, seed_strength
            As of `grow_cut`.
        """
        from insectnav.vision.growcut_kernel import UNITS, UNREACHED, grow

        painted, strength = self._checked(strokes, seed_strength)
        flat = painted.ravel()
        goes_on = self._painted is not None and strength is None and _only_adds(flat, self._painted)
        if goes_on:
            seeds = np.flatnonzero(flat != self._painted)
        else:
            seeds = np.flatnonzero(flat)
            self._length = np.full(flat.size, UNREACHED)
            self._order = np.full(flat.size, UNREACHED)
        self._length[seeds] = 0 if strength is None else np.rint(-UNITS * np.log(strength.ravel()[seeds]))
        self._order[seeds] = flat[seeds]
        self._painted = None  # until all is well again
        grow(self._pixels, self.shape[1], self._greatest, self._steps, seeds, self._length, self._order)
        self._painted = flat.copy() if strength is None else None
        return self._result(painted.dtype)

    def _checked(self, strokes: ArrayLike, seed_strength: ArrayLike) -> tuple[NDArray[Any], NDArray[Any] | None]:
        """Strokes, and the strengths of the seeds if they are not all 1."""
        painted = as_numbers("strokes", strokes)
        if painted.dtype.kind not in "iu":
            raise InputError(
                f"strokes hold {painted.dtype.name} values, expected whole numbers: 0 for none, labels from 1"
            )
        if painted.shape != self.shape:
            raise InputError(
                f"strokes have shape {painted.shape}, the image has {self.shape} pixels: strokes of another image?"
            )
        check_range("strokes", painted, 0, MAX_LABEL)
        if not painted.any():
            raise InputError("strokes are 0 everywhere, expected at least one painted pixel")
        strength = as_numbers("seed strength", seed_strength)
        if strength.shape not in ((), self.shape):
            raise InputError(f"seed strength has shape {strength.shape}, expected one number or {self.shape}")
        strength = np.broadcast_to(strength, self.shape)
        check_range("seed strength", strength[painted > 0], LEAST_SEED_STRENGTH, 1.0)
        return painted, None if np.all(strength[painted > 0] == 1.0) else strength

    def _result(self, dtype: np.dtype[Any]) -> GrowCut:
        from insectnav.vision.growcut_kernel import STEP, UNITS, UNREACHED

        is_reached = self._length < UNREACHED
        labels = np.where(is_reached, self._order % STEP, 0).astype(dtype)
        strength = np.where(is_reached, np.exp(self._length / -UNITS), 0.0)
        return GrowCut(labels.reshape(self.shape), strength.reshape(self.shape))


def _only_adds(painted: NDArray[Any], before: NDArray[Any]) -> bool:
    """Whether all that was painted before still is, in the same label."""
    return bool(np.all((painted == before) | (before == 0)))
