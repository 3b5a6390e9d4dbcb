"""What a search over rotations finds: a reference for each query, and how the query was turned against it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import as_numbers, check_finite, check_shape
from insectnav.vision.sphere import Reals


@dataclass(frozen=True, kw_only=True, eq=False)
class RotationMatches:
    """Best reference of each query and their relative rotation, in the leading axes of the queries.

    Parameters
    ----------
    reference : (...) array of int, the reference whose score is best
    rotation : (..., 3, 3) array, reference ← query: what the query sees along d, the reference sees along rotation @ d
    score : (...) array, at most 1; see `RotationParams`
    runner_up : (...) array of int, the reference whose score is second best; −1 if there is only one
    ratio : (...) array, (1 − score) / (1 − score of the runner-up), at most 1: the lower, the more distinct is the
        match; NaN if there is no runner-up
    overlap : (...) array, solid angle that both saw, as a share of what the one saw that saw less
    """

    reference: NDArray[np.int64]
    rotation: Reals
    score: Reals
    runner_up: NDArray[np.int64]
    ratio: Reals
    overlap: Reals

    @property
    def heading(self) -> Reals:
        """Heading of the query in the frame of its reference [rad], clockwise."""
        return rotation_angles(self.rotation)[0]

    @property
    def pitch(self) -> Reals:
        """Pitch of the query in the frame of its reference [rad], nose up."""
        return rotation_angles(self.rotation)[1]

    @property
    def roll(self) -> Reals:
        """Roll of the query in the frame of its reference [rad], right side down."""
        return rotation_angles(self.rotation)[2]

    @property
    def tilt(self) -> Reals:
        """Angle between the upward axes of the query and its reference [rad], 0 to π."""
        upward = self.rotation[..., :, 2]
        angle: Reals = np.arctan2(np.hypot(upward[..., 0], upward[..., 1]), upward[..., 2])
        return angle


def rotation_angles(rotation: ArrayLike) -> tuple[Reals, Reals, Reals]:
    """Heading, pitch and roll of rotations, each (...) [rad]: the inverse of `sphere.rotation_matrix`.

    Parameters
    ----------
    rotation : (..., 3, 3) array

    Returns
    -------
    heading, pitch, roll : (...) arrays [rad]
        Heading and roll in [−π, π], pitch in [−π/2, π/2]; where the eye looks straight up or down only the sum or the
        difference of heading and roll is determined.

    Raises
    ------
    InputError
        If the last axes are not 3 × 3, or a number is not finite.

    Notes
    -----
    Of Rz(−h) Rx(p) Ry(r) the middle column is (sin h cos p, cos h cos p, sin p), and the last row (−cos p sin r, sin p,
    cos p cos r).
    """
    matrix = as_numbers("rotation", rotation)
    check_shape("rotation", matrix, (..., 3, 3))
    check_finite("rotation", matrix)
    heading = np.arctan2(matrix[..., 0, 1], matrix[..., 1, 1])
    pitch = np.arctan2(matrix[..., 2, 1], np.hypot(matrix[..., 0, 1], matrix[..., 1, 1]))
    roll = np.arctan2(-matrix[..., 2, 0], matrix[..., 2, 2])
    return heading, pitch, roll


def rotation_between(first: ArrayLike, second: ArrayLike) -> Reals:
    """Angle by which one rotation differs from another, (...) [rad] in [0, π].

    Parameters
    ----------
    first, second : (..., 3, 3) arrays; leading axes are broadcast

    Notes
    -----
    The Frobenius norm of the difference of two rotations that are an angle θ apart is √8 sin(θ/2); unlike the arccosine
    of the trace it is exact for small angles.
    """
    a, b = as_numbers("first", first), as_numbers("second", second)
    for name, matrix in (("first", a), ("second", b)):
        check_shape(name, matrix, (..., 3, 3))
    half = np.linalg.norm(a - b, axis=(-2, -1)) / np.sqrt(8.0)
    angle: Reals = 2.0 * np.arcsin(np.minimum(half, 1.0))
    return angle
