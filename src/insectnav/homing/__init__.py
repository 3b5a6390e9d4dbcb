"""Homing by views: comparison with what is remembered, surveys of a place, descent, and how far it leads home."""

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
from insectnav.homing.survey import distance_from, grid_positions, survey

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
    "distance_from",
    "feature_distance",
    "grid_positions",
    "interpolate_surface",
    "landmark_home_vector",
    "random_headings",
    "rms_difference",
    "survey",
    "turn_views",
    "visual_compass",
]
