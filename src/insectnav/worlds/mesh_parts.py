"""What a reader finds in a file, before it is checked."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy.typing as npt


@dataclass(frozen=True, kw_only=True)
class MeshParts:
    """Triangles as they stand in a file; the fields are those of `insectnav.records.Mesh`."""

    vertices: npt.NDArray[Any]
    material: npt.NDArray[Any] | None = None
    materials: tuple[str, ...] = ("unnamed",)
    grey: npt.NDArray[Any] | None = None
    notes: tuple[str, ...] = ()


def fan(corners: Sequence[int]) -> list[tuple[int, int, int]]:
    """Triangles of a polygon, all with its first corner; none of fewer than three corners.

    Parameters
    ----------
    corners : indices in order round the polygon
    """
    return [(corners[0], corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)]
