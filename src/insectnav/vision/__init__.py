"""Vision: directions on the sphere, cameras and compound eyes, and what they see."""

from insectnav.vision.cameras import AHEAD, UPWARDS, Camera, fisheye, panorama, parabolic_mirror
from insectnav.vision.eyes import EYES, CompoundEye, both_eyes, desert_ant, honeybee, interommatidial_angles
from insectnav.vision.lens_flare import NO_FLARE, Ghost, LensFlare, add_lens_flare, halo_radiance, pixel_solid_angles
from insectnav.vision.resampling import Resampler, resampler
from insectnav.vision.sensor import (
    HIGHLIGHTS,
    MID_GREY,
    Meter,
    Sensor,
    auto_exposure,
    expose,
    ideal_sensor,
    srgb_encoded,
    white_balance,
)
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
    "HIGHLIGHTS",
    "MID_GREY",
    "NO_FLARE",
    "UPWARDS",
    "Camera",
    "CompoundEye",
    "Ghost",
    "LensFlare",
    "Meter",
    "Resampler",
    "Sensor",
    "SphereGrid",
    "add_lens_flare",
    "auto_exposure",
    "azimuth_elevation",
    "both_eyes",
    "desert_ant",
    "directions",
    "expose",
    "fisheye",
    "great_circle_angle",
    "halo_radiance",
    "honeybee",
    "ideal_sensor",
    "interommatidial_angles",
    "panorama",
    "parabolic_mirror",
    "pixel_solid_angles",
    "resampler",
    "rotation_matrix",
    "srgb_encoded",
    "to_eye",
    "to_world",
    "white_balance",
]
