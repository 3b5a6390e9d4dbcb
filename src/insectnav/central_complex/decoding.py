"""Reading the home vector out of the memory, as a vector and as a dance."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.angles import unit_vector, wrap
from insectnav.central_complex.parameters import CircuitParams
from insectnav.checks import check_shape


class WaggleDance(NamedTuple):
    """A place told in polar form, as a honeybee dances it."""

    bearing: NDArray[np.floating]  # (...) [rad] of the flight out, clockwise from +y
    distance: NDArray[np.floating]  # (...) [steps]


def decode_waggle_dance(memory: ArrayLike, params: CircuitParams) -> WaggleDance:
    """Bearing and distance from the nest to where the agent is, as the memory holds them.

    Parameters
    ----------
    memory : (..., 16) array
        Charge of the CPU4 cells.
    params : CircuitParams
        Of the circuit that charged it.

    Raises
    ------
    InputError
        If the last axis is not 16 long.

    Notes
    -----
    Both halves of the memory are turned back by the 45° at which their noduli cells look, and added; F is the first
    Fourier coefficient of the eight sums. Bearing out is −arg F (the 2017 code returns arg F, its mirror image).
    Distance is |F| / 2h where flow is inhibited by direction, and |F| / h where flow and direction are multiplied:
    the latter is exact for linear cells, since Σ cos² = 4 over eight columns, each charged by h · flow / 4 per step.
    In the rate models TB1 is steeper than a cosine: without noise both come out 1.05 to 1.2 times too long; noise makes
    them shorter again, to about the true length at 0.1.
    """
    memory = np.asarray(memory)
    check_shape("memory", memory, (..., 16))
    columns = np.roll(memory[..., :8], 1, axis=-1) + np.roll(memory[..., 8:], -1, axis=-1)
    amplitude = np.fft.fft(columns, axis=-1)[..., 1]
    gain = params.memory_gain * (2.0 if params.memory_rule == "inhibited-flow" else 1.0)
    return WaggleDance(wrap(-np.angle(amplitude)), np.abs(amplitude) / gain)


def decode_home_vector(memory: ArrayLike, params: CircuitParams) -> NDArray[np.floating]:
    """Vector from the agent to the nest, (..., 2) [steps], as the memory (..., 16) holds it.

    See `decode_waggle_dance` for the method; this is its place, seen from the other end.
    """
    dance = decode_waggle_dance(memory, params)
    return -dance.distance[..., None] * unit_vector(dance.bearing)
