"""Where a satellite receiver was, and when."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats
from insectnav.checks import InputError, as_numbers, check_range, check_shape
from insectnav.records import read_only

MAX_FIXES = 5_000_000  # of a track: two months at one a second


@dataclass(frozen=True, kw_only=True, eq=False)
class GpsTrack:
    """Fixes of a receiver, as recorded; arrays are read-only copies.

    Parameters
    ----------
    time : (n,) array [s] since 1970-01-01 UTC without leap seconds, NaN where the file has none
    latitude_deg, longitude_deg : (n,) arrays on WGS84, north and east positive
    height : (n,) array [m], NaN where the file has none; above mean sea level, as receivers write it
    segment : (n,) array of int; nothing is known of the way from one segment to the next
    notes : what the user must be told

    Raises
    ------
    InputError
        If shapes do not agree, there is no fix, or a coordinate is none on Earth.
    """

    time: Floats
    latitude_deg: Floats
    longitude_deg: Floats
    height: Floats
    segment: npt.NDArray[np.int64]
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        latitude = as_numbers("latitude", self.latitude_deg)
        check_shape("latitude", latitude, ("n",))
        if not 0 < latitude.size <= MAX_FIXES:
            raise InputError(f"the track has {latitude.size} fixes, expected 1 to {MAX_FIXES}")
        for name, dtype in {"time": float, "longitude_deg": float, "height": float, "segment": np.int64}.items():
            array = as_numbers(name, getattr(self, name))
            check_shape(name, array, latitude.shape)
            object.__setattr__(self, name, read_only(array, dtype))
        object.__setattr__(self, "latitude_deg", read_only(latitude, float))
        check_degrees(self.latitude_deg, self.longitude_deg)


def check_degrees(latitude_deg: Floats, longitude_deg: Floats) -> None:
    """Refuse coordinates that are none on Earth; longitudes may run to 360°."""
    check_range("latitude", latitude_deg, -90.0, 90.0, "degrees", "latitude and longitude exchanged, or metres?")
    check_range("longitude", longitude_deg, -180.0, 360.0, "degrees", "metres of a map, not degrees?")
