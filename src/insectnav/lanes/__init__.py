"""Sixteen trials side by side: the vector type, functions and random numbers that compiled kernels are written in.

The other modules of this folder import numba: only kernels import them, when a kernel is first called.
"""

import numpy as np
from numpy.typing import DTypeLike, NDArray

LANES = 16
_ALIGNMENT = 64  # [byte] a cache line, and the widest SIMD register there is


def empty_rows(n_rows: int, dtype: DTypeLike) -> NDArray:
    """Uninitialised array (n_rows, LANES) whose rows start on cache lines, so that no load straddles two."""
    dtype = np.dtype(dtype)
    room = np.empty(n_rows * LANES * dtype.itemsize + _ALIGNMENT, np.uint8)
    start = -room.ctypes.data % _ALIGNMENT
    return room[start : start + n_rows * LANES * dtype.itemsize].view(dtype).reshape(n_rows, LANES)
