"""Matching of views with remembered ones: which place, and how turned."""

from insectnav.matching.rotation import RotationIndex, RotationParams, build_rotation_index
from insectnav.matching.rotation_matches import RotationMatches, rotation_angles, rotation_between

__all__ = [
    "RotationIndex",
    "RotationMatches",
    "RotationParams",
    "build_rotation_index",
    "rotation_angles",
    "rotation_between",
]
