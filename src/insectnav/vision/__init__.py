"""Vision: directions on the sphere, cameras and compound eyes, and what they see."""

from insectnav.vision.cameras import AHEAD, UPWARDS, Camera, fisheye, panorama, parabolic_mirror
from insectnav.vision.eyes import EYES, CompoundEye, both_eyes, desert_ant, honeybee, interommatidial_angles
from insectnav.vision.resampling import Resampler, resampler
from insectnav.vision.sphere import (
    GRIDS,
    SphereGrid,
    azimuth_elevation,
    directions,
    great_circle_angle,
    rotation_matrix,
    to_eye,
    to_world,
)

__all__ = [
    "AHEAD",
    "EYES",
    "GRIDS",
    "UPWARDS",
    "Camera",
    "CompoundEye",
    "Resampler",
    "SphereGrid",
    "azimuth_elevation",
    "both_eyes",
    "desert_ant",
    "directions",
    "fisheye",
    "great_circle_angle",
    "honeybee",
    "interommatidial_angles",
    "panorama",
    "parabolic_mirror",
    "resampler",
    "rotation_matrix",
    "to_eye",
    "to_world",
]
