"""Where two pictures tell most of each other: shifts tried one by one, then descents by SimpleITK."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, check_choice, check_count, check_range, quoted
from insectnav.vision.warping import Reals, mutual_information

if TYPE_CHECKING:
    import SimpleITK

TRANSFORMS = ("translation", "rigid", "similarity", "affine")
LEAST_SIDE = 32  # [pixel] of a picture, and of its smallest version; assumed
COARSE_SIDE = 96  # [pixel] longer side of the version on which shifts are tried one by one; assumed
SEARCH_SIDE = 256  # [pixel] longer side of the largest version on which several places are followed up; assumed
MAX_LEVELS = 7
APART = 2  # [pixel of the small version] between two shifts that are followed up; assumed
OTHER_PLACE = 0.02  # of the longer side, by which two places differ; assumed


@dataclass(frozen=True, kw_only=True)
class RegistrationParams:
    """How a moving picture is laid over a fixed one.

    Raises
    ------
    InputError
        If a name is unknown or a number out of its range.
    """

    transform: str = "rigid"  # what a changed filter does to a camera on a tripod; one of TRANSFORMS
    n_bins: int = 50  # of each picture's brightness; the number that Mattes et al. 2003 use
    n_samples: int = 40_000  # pixels that are looked at, at most; assumed
    largest_shift: float = 0.1  # of width and height, tried in both directions; assumed
    least_overlap: float = 0.5  # share of the fixed picture that the moving one must cover; assumed
    n_starts: int = 6  # best of the tried shifts that are followed up; assumed
    least_fall: float = 0.1  # see `Alignment.fall`; assumed: at least 0.2 in scenes that fit, below 0.05 in others
    least_lead: float = 0.1  # see `Alignment.lead`; assumed: above 0.8 in scenes that fit
    n_iterations: int = 300  # at most, on each size of the picture; assumed
    seed: int = 1  # of the choice of pixels

    def __post_init__(self) -> None:
        check_choice("transform", self.transform, TRANSFORMS)
        check_range("number of bins", self.n_bins, 8, 256)
        check_count("number of samples", self.n_samples, 1000)
        check_range("largest shift", self.largest_shift, 0.0, 0.5)
        check_range("least overlap", self.least_overlap, 0.0, 1.0)
        check_count("number of starts", self.n_starts)
        check_range("least fall", self.least_fall, -1.0, 1.0)
        check_range("least lead", self.least_lead, -1.0, 1.0)
        check_count("number of iterations", self.n_iterations)
        check_count("seed", self.seed)


class Place(NamedTuple):
    """Where the moving picture lies, and by what share its mutual information is above that of the next best place."""

    matrix: Reals
    lead: float


def _simple_itk() -> Any:
    try:
        import SimpleITK
    except ImportError:
        raise InputError("alignment needs SimpleITK, which is missing: pip install 'insectnav[register]'") from None
    return SimpleITK


def _translation(itk: Any, shift: Reals) -> SimpleITK.Transform:
    return itk.TranslationTransform(2, [float(value) for value in shift])


def _started(itk: Any, name: str, before: Any, shape: tuple[int, ...]) -> SimpleITK.Transform:
    """A transform of this kind that does what an earlier one of a simpler kind does, about the picture's middle."""
    middle = [(shape[1] - 1) / 2.0, (shape[0] - 1) / 2.0]
    moved = np.array(before.TransformPoint(middle)) - middle
    if name == "translation":
        return _translation(itk, moved)
    linear = _matrix(before)[:, :2]
    if name == "affine":
        transform = itk.AffineTransform(2)
        transform.SetCenter(middle)
        transform.SetMatrix(linear.ravel().tolist())
    else:
        transform = itk.Euler2DTransform() if name == "rigid" else itk.Similarity2DTransform()
        transform.SetCenter(middle)
        transform.SetAngle(float(np.arctan2(linear[1, 0], linear[0, 0])))
    transform.SetTranslation(moved.tolist())
    return transform


def _method(itk: Any, params: RegistrationParams, n_pixels: int) -> SimpleITK.ImageRegistrationMethod:
    """Metric and interpolation that all searches share."""
    method = itk.ImageRegistrationMethod()
    method.SetNumberOfThreads(1)
    method.SetNumberOfWorkUnits(1)
    method.SetMetricAsMattesMutualInformation(params.n_bins)
    method.SetMetricSamplingStrategy(method.RANDOM)  # off the centres of pixels, where interpolation blurs nothing
    method.SetMetricSamplingPercentage(min(1.0, params.n_samples / n_pixels), params.seed)
    method.SetInterpolator(itk.sitkLinear)
    method.MetricUseFixedImageGradientFilterOff()  # slopes are taken where they are needed, not everywhere
    method.MetricUseMovingImageGradientFilterOff()
    return method


def _shrunk(itk: Any, grey: NDArray[np.float32], factor: int) -> SimpleITK.Image:
    image = itk.GetImageFromArray(grey)
    return itk.BinShrink(image, [factor, factor]) if factor > 1 else image


def find_place(fixed: Reals, moving: Reals, params: RegistrationParams) -> Place:
    """The best place that descents from several shifts lead to: walls of windows look alike a storey further.

    Parameters
    ----------
    fixed, moving : (rows, columns) arrays of float32 in 0…1
    params : RegistrationParams

    Raises
    ------
    InputError
        If SimpleITK is missing, the pictures do not overlap or the search does not come to rest.
    """
    itk = _simple_itk()
    side = min(fixed.shape + moving.shape)
    factors = [2**k for k in range(MAX_LEVELS) if side // 2**k >= LEAST_SIDE][::-1]
    sizes = {factor: (_shrunk(itk, fixed, factor), _shrunk(itk, moving, factor)) for factor in factors}
    small = [factor for factor in factors if max(fixed.shape) / factor <= SEARCH_SIDE] or factors[:1]
    first, last = ("rigid" if params.transform in ("similarity", "affine") else params.transform), params.transform
    found: list[tuple[float, int, Any]] = []
    for shift in _best_shifts(itk, fixed, moving, params):
        transform = _started(itk, first, _translation(itk, shift), fixed.shape)
        for factor in small:
            _descend(itk, *sizes[factor], factor, transform, params)
        found.append((mutual_information(fixed, moving, _matrix(transform), params.n_bins), len(found), transform))
    transform = _started(itk, last, max(found)[2], fixed.shape)
    best = max(found)[0]
    for factor in factors if last != first else factors[len(small) - 1 :]:
        trial = transform.__class__(transform)
        is_at_rest = _descend(itk, *sizes[factor], factor, trial, params, first_step=0.5)
        value = mutual_information(fixed, moving, _matrix(trial), params.n_bins)
        if value >= best:  # on a small version, freer transforms may run away
            transform, best = trial, value
    if not is_at_rest:
        raise InputError(
            f"alignment has not come to rest after {params.n_iterations} iterations: a simpler transform than "
            f"{params.transform}, or more iterations?"
        )
    others = [value for value, _, other in found if _are_apart(_matrix(other), _matrix(transform), fixed.shape)]
    return Place(matrix=_matrix(transform), lead=1.0 - max(others, default=0.0) / max(best, 1e-12))


def _are_apart(matrix: Reals, other: Reals, shape: tuple[int, ...]) -> bool:
    """Whether two places are not the same one, found twice."""
    middle = np.array([shape[1] / 2.0, shape[0] / 2.0, 1.0])
    return bool(np.hypot(*((matrix - other) @ middle)) > max(4.0, OTHER_PLACE * max(shape)))


def _best_shifts(itk: Any, fixed: Reals, moving: Reals, params: RegistrationParams) -> list[Reals]:
    """Shifts (columns, rows) on a small version that are better than those around them, the best first."""
    rows, columns = fixed.shape
    offset = np.array([moving.shape[1] - columns, moving.shape[0] - rows]) / 2.0  # of pictures of other sizes
    factor = max(1, min(int(max(rows, columns) / COARSE_SIDE), min(fixed.shape + moving.shape) // LEAST_SIDE))
    reach = [int(np.ceil(params.largest_shift * side / factor)) for side in (columns, rows)]
    small_fixed, small_moving = _shrunk(itk, fixed, factor), _shrunk(itk, moving, factor)
    method = _method(itk, params, small_fixed.GetNumberOfPixels())
    method.SetOptimizerAsExhaustive(reach, float(factor))
    method.SetInitialTransform(_translation(itk, offset), inPlace=True)
    tried: list[tuple[float, tuple[float, ...]]] = []
    method.AddCommand(
        itk.sitkIterationEvent, lambda: tried.append((method.GetMetricValue(), method.GetOptimizerPosition()))
    )
    _run(method, small_fixed, small_moving)
    best: list[Reals] = []
    for _, position in sorted(tried):
        shift = np.array(position)
        if all(np.abs(shift - other).max() > APART * factor for other in best):
            best.append(shift)
        if len(best) == params.n_starts:
            break
    return best


def _descend(
    itk: Any,
    fixed: Any,
    moving: Any,
    factor: int,
    transform: Any,
    params: RegistrationParams,
    first_step: float = 1.0,
) -> bool:
    """Change the transform to the next maximum of mutual information; whether it came to rest there.

    The first step is given in pixels of these versions, of which each is ``factor`` pixels wide.
    """
    method = _method(itk, params, fixed.GetNumberOfPixels())
    method.SetOptimizerAsRegularStepGradientDescent(
        learningRate=first_step * factor,
        minStep=0.002 * factor,
        numberOfIterations=params.n_iterations,
        gradientMagnitudeTolerance=1e-9,
    )
    method.SetOptimizerScalesFromPhysicalShift()
    method.SetInitialTransform(transform, inPlace=True)
    _run(method, fixed, moving)
    return bool(method.GetOptimizerIteration() < params.n_iterations)


def _run(method: SimpleITK.ImageRegistrationMethod, fixed: Any, moving: Any) -> None:
    try:
        method.Execute(fixed, moving)
    except RuntimeError as error:  # ITK says much; the first thing that goes wrong is that nothing overlaps
        words = str(error).strip().splitlines()[-1]
        raise InputError(f"alignment failed, the pictures may share too little ({quoted(words, 120)})") from None


def _matrix(transform: Any) -> Reals:
    """(2, 3), for pixels whose first centre is at (0.5, 0.5)."""
    origin, right, down = (np.array(transform.TransformPoint(point)) for point in ((0, 0), (1, 0), (0, 1)))
    linear = np.stack([right - origin, down - origin], axis=1)
    return np.hstack([linear, (origin + 0.5 - linear @ [0.5, 0.5])[:, None]])
