"""Pictures of one scene through different filters, laid over each other by mutual information.

A camera moves when its filter is changed, and what is bright in green may be dark in ultraviolet, so that differences
of brightness say nothing. Mutual information asks only how well the one picture tells the other.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, as_numbers, check_choice, check_finite, quoted
from insectnav.vision.registration_search import LEAST_SIDE, RegistrationParams, find_place
from insectnav.vision.warping import Reals, mutual_information, warp

BANDS = ("mean", "red", "green", "blue")
MOST_STRETCH = 1.5  # of a length; assumed


class Alignment(NamedTuple):
    """How the moving picture lies to the fixed one, and how well.

    Parameters
    ----------
    matrix : (2, 3) array
        From (column, row, 1) in the fixed picture to (column, row) in the moving one; the first pixel's centre is at
        (0.5, 0.5).
    shift_px : (2,) array of columns and rows, of the middle of the fixed picture
    rotation : clockwise as one looks at the picture [rad]
    scale : square root of the ratio of areas; above 1 the moving picture shows things larger
    aligned : the moving picture on the pixels of the fixed one, in its own type; 0 where it shows nothing
    valid : (rows, columns) array, True where it shows something
    mutual_information : of the two where both are valid [nat]
    mutual_information_before : the same, as they were given
    fall : share of it that is lost, on average, two pixels or 0.5 % of the longer side away from there: how sharply
        the two fit
    lead : share by which it is above that of the next best of the places that were followed up
    """

    matrix: Reals
    shift_px: Reals
    rotation: float
    scale: float
    aligned: NDArray[Any]
    valid: NDArray[np.bool_]
    mutual_information: float
    mutual_information_before: float
    fall: float
    lead: float


def align(
    fixed: ArrayLike,
    moving: ArrayLike,
    params: RegistrationParams | None = None,
    *,
    fixed_band: str = "mean",
    moving_band: str = "mean",
) -> Alignment:
    """The moving picture laid over the fixed one.

    Parameters
    ----------
    fixed, moving : (rows, columns) or (rows, columns, 3) arrays of any real type, of the same scene
    params : RegistrationParams
    fixed_band, moving_band : "mean", "red", "green" or "blue"
        By which colour they are laid over each other; all of them are moved.

    Raises
    ------
    InputError
        If SimpleITK is missing, a picture cannot be used, the search does not come to rest, nothing stands out, or the
        pictures share too little.

    Notes
    -----
    Mutual information from a joint histogram smoothed by cubic B-splines: Mattes, Haynor, Vesselle, Lewellen & Eubank
    2003, IEEE Trans. Medical Imaging 22(1):120, doi 10.1109/TMI.2003.809072, as SimpleITK has it. First, shifts are
    tried one by one on a small version; from the best of them a gradient descent leads to the place, on versions of
    growing size. One thread and a seeded choice of pixels: the same bits each time, however many cores there are.
    """
    chosen = params or RegistrationParams()
    fixed_array, moving_array = _checked("fixed picture", fixed), _checked("moving picture", moving)
    fixed_grey = _stretched("fixed picture", fixed_array, fixed_band)
    moving_grey = _stretched("moving picture", moving_array, moving_band)
    matrix, lead = find_place(fixed_grey, moving_grey, chosen)
    aligned, valid = warp(moving_array, matrix, fixed_grey.shape)
    information = mutual_information(fixed_grey, moving_grey, matrix, chosen.n_bins)
    around = [
        mutual_information(fixed_grey, moving_grey, off, chosen.n_bins) for off in _just_off(matrix, fixed_grey.shape)
    ]
    fall = 1.0 - float(np.mean(around)) / max(information, 1e-12)
    _check_found(matrix, float(valid.mean()), fall, lead, chosen)
    middle = np.array(fixed_grey.shape)[::-1] / 2.0
    return Alignment(
        matrix=matrix,
        shift_px=matrix[:, :2] @ middle + matrix[:, 2] - middle,
        rotation=float(np.arctan2(matrix[1, 0] - matrix[0, 1], matrix[0, 0] + matrix[1, 1])),
        scale=float(np.sqrt(np.linalg.det(matrix[:, :2]))),
        aligned=aligned,
        valid=valid,
        mutual_information=information,
        mutual_information_before=mutual_information(fixed_grey, moving_grey, np.eye(2, 3), chosen.n_bins),
        fall=fall,
        lead=lead,
    )


def _checked(name: str, picture: ArrayLike) -> NDArray[Any]:
    array = as_numbers(name, picture)
    if array.ndim not in (2, 3) or (array.ndim == 3 and array.shape[2] != 3):
        raise InputError(f"{name} has shape {array.shape}, expected (rows, columns) or (rows, columns, 3)")
    if min(array.shape[:2]) < LEAST_SIDE:
        raise InputError(
            f"{name} has {array.shape[1]} × {array.shape[0]} pixels, expected at least {LEAST_SIDE} a side"
        )
    check_finite(name, array)
    return array


def _stretched(name: str, picture: NDArray[Any], band: str) -> NDArray[np.float32]:
    """One band in 0…1; the brightest and darkest thousandth are cut off, or a few hot pixels would fill the bins."""
    check_choice(f"band of the {name}", band, BANDS)
    grey = picture.astype(np.float64)
    if picture.ndim == 3:
        grey = grey.mean(axis=2) if band == "mean" else grey[..., BANDS.index(band) - 1]
    elif band != "mean":
        raise InputError(f"{name} has no colours, but its band {quoted(band)} is asked for")
    low, high = np.quantile(grey, (0.001, 0.999))
    if high <= low:
        low, high = grey.min(), grey.max()
    if high <= low:
        raise InputError(f"{name} has the same brightness everywhere, so there is nothing to align it by")
    return np.clip((grey - low) / (high - low), 0.0, 1.0).astype(np.float32)


def _check_found(matrix: Reals, share: float, fall: float, lead: float, params: RegistrationParams) -> None:
    """Refuse what cannot be meant."""
    if share < params.least_overlap:
        raise InputError(
            f"the moving picture covers {100 * share:.0f} % of the fixed one where they fit best, expected at least "
            f"{100 * params.least_overlap:.0f} %: another scene, or moved too far?"
        )
    stretch = np.linalg.svd(matrix[:, :2], compute_uv=False)
    if np.linalg.det(matrix[:, :2]) <= 0 or stretch.max() > MOST_STRETCH or stretch.min() < 1 / MOST_STRETCH:
        raise InputError(
            "the pictures fit best when stretched by more than half, which is no alignment: another scene?"
        )
    if fall < params.least_fall:
        raise InputError(
            f"no place stands out: next to the best, mutual information is only {100 * fall:.0f} % lower, expected "
            f"{100 * params.least_fall:.0f} %: another scene, moved by more than the largest shift, or out of focus?"
        )
    if lead < params.least_lead:
        raise InputError(
            f"another place fits almost as well, mutual information is only {100 * lead:.0f} % lower there, expected "
            f"{100 * params.least_lead:.0f} %: a pattern that repeats itself, or another scene?"
        )


def _just_off(matrix: Reals, shape: tuple[int, ...]) -> list[Reals]:
    """The same, shifted a little to eight sides."""
    distance = max(2.0, 0.005 * max(shape))
    angles = np.arange(8) * np.pi / 4.0
    return [matrix + distance * np.array([[0, 0, np.cos(angle)], [0, 0, np.sin(angle)]]) for angle in angles]
