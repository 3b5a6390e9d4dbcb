"""Projections of lenses and mirrors: how far from the centre of the picture a direction lies, and back.

Each is a pair of functions of the angle θ from the optical axis [rad] and the radius ρ, in focal lengths.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError

Reals = NDArray[np.floating[Any]]
Coefficients = tuple[float, ...]

_NEWTON_STEPS = 60


@dataclass(frozen=True, kw_only=True)
class Projection:
    """A projection that is the same all round the optical axis.

    Parameters
    ----------
    radius : function of θ (...) [rad] and the coefficients, to ρ (...) [focal lengths]
    angle : its inverse: function of ρ (...), the coefficients and the largest θ [rad], to θ (...) [rad]
    max_angle : [rad] what the formula can show; the limit itself only if `includes_max`
    includes_max : whether the radius at the limit is finite and the formula still invertible
    is_mirrored : whether left and right are exchanged, as in a mirror that the camera looks into
    n_coefficients : how many coefficients it may have
    """

    radius: Callable[[Reals, Coefficients], Reals]
    angle: Callable[[Reals, Coefficients, float], Reals]
    max_angle: float
    includes_max: bool = True
    is_mirrored: bool = False
    n_coefficients: int = 0


def kannala_brandt_radius(theta: Reals, coefficients: Coefficients) -> Reals:
    """Radius ``θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸)``.

    Parameters
    ----------
    theta : (...) array [rad]
    coefficients : up to four, k1 first

    Returns
    -------
    (...) array [focal lengths]

    Notes
    -----
    Kannala & Brandt, IEEE Trans. Pattern Anal. Mach. Intell. 28, 1335 (2006), doi 10.1109/TPAMI.2006.153, Eq. 6, with
    the first coefficient taken into the focal length, as OpenCV's fisheye module does.
    """
    square = theta * theta
    factor = np.zeros_like(theta)
    for coefficient in reversed(coefficients):
        factor = (factor + coefficient) * square
    return theta * (1.0 + factor)


def kannala_brandt_slope(theta: Reals, coefficients: Coefficients) -> Reals:
    """Derivative of `kannala_brandt_radius` with respect to θ, (...)."""
    square = theta * theta
    slope = np.zeros_like(theta)
    for power, coefficient in reversed(list(enumerate(coefficients, 1))):
        slope = (slope + (2 * power + 1) * coefficient) * square
    return 1.0 + slope


def kannala_brandt_angle(radius: Reals, coefficients: Coefficients, max_angle: float) -> Reals:
    """Angle θ of a radius: Newton's method, kept inside an interval that always holds the solution.

    Parameters
    ----------
    radius : (...) array [focal lengths]
    coefficients : up to four, k1 first; the radius must increase up to the largest angle
    max_angle : [rad]

    Returns
    -------
    (...) array [rad]; infinite beyond the radius of the largest angle
    """
    edge = float(kannala_brandt_radius(np.asarray(max_angle), coefficients))
    is_inside = radius <= edge * (1.0 + 1e-12)
    wanted = np.where(is_inside, radius, 0.0)
    low, high = np.zeros_like(wanted), np.full_like(wanted, max_angle * (1.0 + 1e-9))
    theta = np.clip(wanted, low, high)
    for _ in range(_NEWTON_STEPS):
        miss = kannala_brandt_radius(theta, coefficients) - wanted
        low, high = np.where(miss < 0.0, theta, low), np.where(miss > 0.0, theta, high)
        step = theta - miss / kannala_brandt_slope(theta, coefficients)
        # A step that leaves the interval is replaced by halving it.
        following = np.where((step >= low) & (step <= high), step, (low + high) / 2)
        if np.all(np.abs(following - theta) <= 1e-15):
            break
        theta = following
    return np.where(is_inside, theta, np.inf)


def check_increases(coefficients: Coefficients, max_angle: float) -> None:
    """Refuse coefficients with which two angles fall on one radius within the field."""
    theta = np.linspace(0.0, max_angle, 2001)
    folded = kannala_brandt_slope(theta, coefficients) <= 0.0
    if folded.any():
        turn = np.rad2deg(theta[np.argmax(folded)])
        raise InputError(
            f"coefficients make the radius in the picture fall beyond {turn:.3g}° from the axis, expected it to grow "
            "over the whole field: too wide a field, or coefficients of another model?"
        )


def _inverse_sine(x: Reals) -> Reals:
    """Arc sine; infinite beyond 1, which no angle reaches."""
    return np.where(np.abs(x) <= 1.0 + 1e-12, np.arcsin(np.clip(x, -1.0, 1.0)), np.inf)


PROJECTIONS: dict[str, Projection] = {
    "equidistant": Projection(radius=lambda t, k: t, angle=lambda r, k, m: r, max_angle=np.pi),
    "equisolid": Projection(
        radius=lambda t, k: 2.0 * np.sin(t / 2), angle=lambda r, k, m: 2.0 * _inverse_sine(r / 2), max_angle=np.pi
    ),
    "stereographic": Projection(
        radius=lambda t, k: 2.0 * np.tan(t / 2),
        angle=lambda r, k, m: 2.0 * np.arctan(r / 2),
        max_angle=np.pi,
        includes_max=False,
    ),
    "orthographic": Projection(
        radius=lambda t, k: np.sin(t), angle=lambda r, k, m: _inverse_sine(r), max_angle=np.pi / 2
    ),
    "pinhole": Projection(
        radius=lambda t, k: np.tan(t), angle=lambda r, k, m: np.arctan(r), max_angle=np.pi / 2, includes_max=False
    ),
    "kannala-brandt": Projection(
        radius=kannala_brandt_radius, angle=kannala_brandt_angle, max_angle=np.pi, n_coefficients=4
    ),
    # A paraboloid with its focus as the single viewpoint, seen from afar: z = (h² − r²)/2h, so that a ray at θ from
    # its axis meets it at r = h tan(θ/2), h the focal length here. Nayar (1997), doi 10.1109/CVPR.1997.609369.
    "parabolic-mirror": Projection(
        radius=lambda t, k: np.tan(t / 2),
        angle=lambda r, k, m: 2.0 * np.arctan(r),
        max_angle=np.pi,
        includes_max=False,
        is_mirrored=True,
    ),
}
