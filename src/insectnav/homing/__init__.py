"""Homing by views: comparison with what is remembered, descent on the distances, and how far they reach."""

from insectnav.homing.catchment import Catchment, catchment_area, cell_centres
from insectnav.homing.descent import OUTCOMES, Descent, descend, interpolate_surface
from insectnav.homing.landmarks import average_landmark_vector, landmark_home_vector
from insectnav.homing.snapshots import (
    COMPARISONS,
    Compass,
    difference_by_turn,
    difference_surface,
    feature_distance,
    random_headings,
    rms_difference,
    turn_views,
    visual_compass,
)

__all__ = [
    "COMPARISONS",
    "OUTCOMES",
    "Catchment",
    "Compass",
    "Descent",
    "average_landmark_vector",
    "catchment_area",
    "cell_centres",
    "descend",
    "difference_by_turn",
    "difference_surface",
    "feature_distance",
    "interpolate_surface",
    "landmark_home_vector",
    "random_headings",
    "rms_difference",
    "turn_views",
    "visual_compass",
]
