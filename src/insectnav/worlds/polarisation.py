"""Polarisation of the clear sky by a single Rayleigh scattering: its degree and the direction of its e-vector."""

from typing import Any

import numpy as np
import numpy.typing as npt

from insectnav.angles import wrap

Reals = npt.NDArray[np.floating[Any]]


def maximal_degree(turbidity: npt.ArrayLike) -> Reals:
    """Degree of polarisation at 90° from the sun, less than 1 because of haze and multiple scattering.

    Notes
    -----
    exp(−(T − 0.6) / 4): code of Gkanias et al. 2019, doi 10.1371/journal.pcbi.1007123. It gives 0.70 for the clearest
    sky (T = 2) and 0.33 for T = 5; Kreuter, Emde and Blumthaler 2010 (Atmospheric Research 98:363) measured 0.7 to 0.4
    at 450 nm while the optical depth of the haze rose from 0.05 to 0.5 (here: T = 2 to 5.4). The same in all bands is
    an assumption; real skies are polarised a little less in the ultraviolet.
    """
    return np.exp(-(np.asarray(turbidity, dtype=float) - 0.6) / 4.0)


def rayleigh_degree(directions: npt.ArrayLike, sun: npt.ArrayLike) -> Reals:
    """Degree of polarisation (...) of light scattered once by air: 1 at 90° from the sun, 0 at it and opposite to it.

    Parameters
    ----------
    directions : (..., 3) array of unit vectors
    sun : (3,) unit vector

    Notes
    -----
    sin²γ / (1 + cos²γ) at the angle γ from the sun: Rayleigh 1871; Coulson, Polarization and Intensity of Light in the
    Atmosphere (1988), A. Deepak, Hampton.
    """
    # |d × s|² rather than 1 − cos²γ, which would lose all digits near the sun.
    sine_squared = np.square(np.cross(np.asarray(directions), np.asarray(sun))).sum(axis=-1)
    return sine_squared / (1.0 + np.square(np.asarray(directions) @ np.asarray(sun)))


def e_vector(directions: npt.ArrayLike, sun: npt.ArrayLike) -> Reals:
    """Unit vectors (..., 3) along which the light vibrates: at right angles to the sky point and to the sun.

    Null at the sun and opposite to it, where there is none. The sign means nothing.

    Parameters
    ----------
    directions : (..., 3) array of unit vectors
    sun : (3,) unit vector
    """
    across = np.cross(np.asarray(directions), np.asarray(sun))
    length = np.linalg.norm(across, axis=-1, keepdims=True)
    return np.divide(across, length, out=np.zeros_like(across, dtype=float), where=length > 1e-12)


def e_vector_angle(directions: npt.ArrayLike, sun: npt.ArrayLike) -> Reals:
    """Angle (...) [rad] in [−π/2, π/2) from the vertical plane through a sky point to its e-vector.

    Positive is clockwise for an eye that looks at the point: 0 is a vertical e-vector, ±π/2 a horizontal one. At the
    zenith, where all planes are vertical, that of north and south counts. 0 where there is no polarisation.

    Parameters
    ----------
    directions : (..., 3) array of unit vectors
    sun : (3,) unit vector
    """
    directions = np.asarray(directions, dtype=float)
    vector = e_vector(directions, sun)
    x, y, z = directions[..., 0], directions[..., 1], directions[..., 2]
    level = np.hypot(x, y)
    at_pole = level < 1e-12
    sine = np.divide(x, level, out=np.zeros_like(level), where=~at_pole)
    cosine = np.divide(y, level, out=np.ones_like(level), where=~at_pole)
    rightward = cosine * vector[..., 0] - sine * vector[..., 1]
    upward = level * vector[..., 2] - z * (sine * vector[..., 0] + cosine * vector[..., 1])
    return wrap(2.0 * np.arctan2(rightward, upward)) / 2.0
