"""Places side by side: descriptors, times, positions, names and routes, checked and in the form that is stored."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, as_numbers, check_shape
from insectnav.matching.difference import checked_vectors
from insectnav.matching.place_about import MapAbout, check_text
from insectnav.matching.place_store import Arrays, DamagedError, read_arrays, shown

Reals = NDArray[np.floating[Any]]
Integers = NDArray[np.int64]
DIMENSIONS = {
    "times": ("place",),
    "positions": ("place", "axis"),
    "routes": ("place",),
    "name_ends": ("place",),
    "name_bytes": ("name_byte",),
}
KINDS = ("uint8", "float32", "float64")  # of descriptors that are not bits


@dataclass(frozen=True, kw_only=True, eq=False)
class PlaceArrays:
    """Places in order, as they are stored.

    Parameters
    ----------
    stored : (place, feature) array of uint8, float32 or float64, or (place, byte) of bits, eight in a byte
    n_features : of a descriptor
    is_bits : whether the descriptors are truth values
    times : (place,) array [s], NaN unknown
    positions : (place, 3) array [m], x east, y north, z up, NaN unknown
    routes : (place,) number of the traverse, from 0 in steps of at most 1
    name_ends : (place,) where the name of each ends within the bytes of all of them
    name_bytes : (byte,) UTF-8 of all names, one after the other
    """

    stored: NDArray[Any]
    n_features: int
    is_bits: bool
    times: Reals
    positions: Reals
    routes: Integers
    name_ends: Integers
    name_bytes: NDArray[np.uint8]

    @property
    def kind(self) -> str:
        """Type of the descriptors, as NumPy calls it."""
        return "bool" if self.is_bits else str(self.stored.dtype.name)

    def descriptors(self, which: slice | Integers = slice(None)) -> NDArray[Any]:
        """Descriptors of some of the places, (place, feature)."""
        piece = self.stored[which]
        if not self.is_bits:
            return piece
        return np.unpackbits(piece, axis=1, count=self.n_features).view(bool)

    def names(self) -> tuple[str, ...]:
        """Name of each place."""
        text, ends = self.name_bytes.tobytes(), self.name_ends.tolist()
        try:
            return tuple(text[a:b].decode() for a, b in pairwise([0, *ends]))
        except UnicodeDecodeError:
            raise DamagedError("the names of the places are no text: damaged?") from None

    def as_arrays(self) -> Arrays:
        """Arrays by name, with their dimensions."""
        values = {name: getattr(self, name) for name in DIMENSIONS}
        descriptors = ("bits", ("place", "feature_byte")) if self.is_bits else ("descriptors", ("place", "feature"))
        return {descriptors[0]: (descriptors[1], self.stored)} | {
            name: (DIMENSIONS[name], array) for name, array in values.items()
        }


def new_places(
    about: MapAbout,
    descriptors: ArrayLike,
    times: ArrayLike | None = None,
    positions: ArrayLike | None = None,
    names: Sequence[str] | None = None,
) -> PlaceArrays:
    """Places of one traverse, number 0, as they will be stored.

    Raises
    ------
    InputError
        If an array is not one value for each place, or the descriptors are not what the map is about.
    """
    vectors = _checked_descriptors(about, descriptors)
    n, is_bits = len(vectors), vectors.dtype == bool
    if times is None:
        time = np.full(n, np.nan)
    else:
        time = as_numbers("times", times).astype(np.float64)
        check_shape("times", time, (n,))
    if positions is None:
        position = np.full((n, 3), np.nan)
    else:
        position = as_numbers("positions", positions).astype(np.float64)
        check_shape("positions", position, (n, 3))
    if np.isinf(time).any() or np.isinf(position).any():
        raise InputError("times or positions are infinite, expected finite numbers, or NaN where they are unknown")
    texts = _encoded(names, n)
    return PlaceArrays(
        stored=np.packbits(vectors, axis=1) if is_bits else vectors,
        n_features=about.n_features,
        is_bits=bool(is_bits),
        times=time,
        positions=position,
        routes=np.zeros(n, np.int64),
        name_ends=np.cumsum([len(text) for text in texts], dtype=np.int64),
        name_bytes=np.frombuffer(b"".join(texts), np.uint8),
    )


def _checked_descriptors(about: MapAbout, descriptors: ArrayLike) -> NDArray[Any]:
    vectors = np.asarray(descriptors)
    checked_vectors("descriptors", vectors)
    if vectors.shape[1] != about.n_features:
        raise InputError(
            f"descriptors have {vectors.shape[1]} features, expected {about.n_features} as the map: "
            "the same descriptor?"
        )
    if about.metric == "hamming":
        if vectors.dtype != bool and not ((vectors == 0) | (vectors == 1)).all():
            raise InputError("descriptors hold values other than 0 and 1, expected bits for the metric 'hamming'")
        vectors = vectors.astype(bool)
    elif vectors.dtype == bool:
        vectors = vectors.astype(np.uint8)
    if vectors.dtype != bool and vectors.dtype.name not in KINDS:
        raise InputError(
            f"descriptors hold {vectors.dtype.name} values, expected truth values or one of {', '.join(KINDS)}: "
            "descriptors.astype(numpy.float32)?"
        )
    return np.ascontiguousarray(vectors)


def _encoded(names: Sequence[str] | None, n: int) -> list[bytes]:
    if names is None:
        return [b""] * n
    if isinstance(names, str) or len(names) != n:
        raise InputError(f"there are {len(names)} names, expected one for each of {n} places")
    for i, name in enumerate(names):
        check_text(f"name {i}", name)
    return [name.encode() for name in names]


def no_places(about: MapAbout) -> PlaceArrays:
    """Those of a map that is still empty."""
    return PlaceArrays(
        stored=np.empty((0, about.n_features), np.float32),
        n_features=about.n_features,
        is_bits=False,
        times=np.empty(0),
        positions=np.empty((0, 3)),
        routes=np.empty(0, np.int64),
        name_ends=np.empty(0, np.int64),
        name_bytes=np.empty(0, np.uint8),
    )


def joined(parts: Sequence[PlaceArrays]) -> PlaceArrays:
    """Places of all parts, one after the other; a single part stays as it is, on disk if it is there."""
    if len(parts) == 1:
        return parts[0]
    starts = np.cumsum([0, *(len(part.name_bytes) for part in parts)])
    return PlaceArrays(
        stored=np.concatenate([part.stored for part in parts]),
        n_features=parts[0].n_features,
        is_bits=parts[0].is_bits,
        times=np.concatenate([part.times for part in parts]),
        positions=np.concatenate([part.positions for part in parts]),
        routes=np.concatenate([part.routes for part in parts]),
        name_ends=np.concatenate([start + part.name_ends for start, part in zip(starts, parts, strict=False)]),
        name_bytes=np.concatenate([part.name_bytes for part in parts]),
    )


def read_places(folder: Path, about: MapAbout) -> PlaceArrays:
    """Places from a folder of arrays, large ones mapped from disk.

    Raises
    ------
    DamagedError
        If they are not as they were written.
    """
    is_bits = about.metric == "hamming"
    name, dimensions = ("bits", ("place", "feature_byte")) if is_bits else ("descriptors", ("place", "feature"))
    arrays = read_arrays(folder, {name: dimensions, **DIMENSIONS})
    stored = arrays.pop(name)
    places = PlaceArrays(stored=stored, n_features=about.n_features, is_bits=is_bits, **arrays)
    ends = places.name_ends
    kinds = [stored.dtype.name, *(arrays[name].dtype.name for name in DIMENSIONS)]
    is_right = (
        kinds[0] in (("uint8",) if is_bits else KINDS)
        and kinds[1:] == ["float64", "float64", "int64", "int64", "uint8"]
        and len(stored) > 0
        and stored.shape[1] == (-(-about.n_features // 8) if is_bits else about.n_features)
        and places.positions.shape[1] == 3
        and bool((np.diff(ends, prepend=0) >= 0).all())
        and ends[-1] == len(places.name_bytes)
        and places.routes[0] >= 0
        and bool(np.isin(np.diff(places.routes), (0, 1)).all())
    )
    if not is_right:
        raise DamagedError(f"the arrays in {shown(folder)} do not fit what the map is about: damaged?")
    return places
