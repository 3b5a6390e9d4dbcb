"""Tracks of satellite receivers, and their places in metres east and north of an origin."""

from datetime import date
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from insectnav.angles import Floats
from insectnav.checks import InputError, as_numbers, check_shape, quoted
from insectnav.datasets import gpx_files, nmea_logs
from insectnav.datasets.gps_track import GpsTrack, check_degrees
from insectnav.datasets.text_tables import read_bytes

SEMI_MAJOR_AXIS = 6_378_137.0  # [m] WGS84, NIMA TR8350.2 (2000), table 3.1
FLATTENING = 1 / 298.257223563  # WGS84, the same table
ECCENTRICITY_SQUARED = FLATTENING * (2 - FLATTENING)
MAX_BYTES = 512 * 2**20  # of a file
SNIFFED = 65_536  # bytes, of which some sentence must be whole
MAX_REACH = 1_000_000.0  # [m] from the origin; beyond, a fix is off or the plane is the wrong picture


def read_gps(path: str | PathLike[str], *, first_day: date | None = None) -> GpsTrack:
    """The track in a GPX file, or in the log of a receiver (NMEA 0183).

    Parameters
    ----------
    path : a file; what it holds decides, not its ending
    first_day : date of the first fix [UTC], for logs that give times of day alone (no RMC and no ZDA)

    Raises
    ------
    InputError
        One sentence that names the file and the likely slip.
    """
    path = Path(path)
    try:
        data = read_bytes(path, "a GPX file or a log of NMEA sentences", MAX_BYTES)
        kind = gps_kind(data)
        if kind == "gpx":
            return gpx_files.parse_gpx(data)
        if kind == "nmea":
            # A damaged byte spoils its own sentence alone, whose checksum tells.
            return nmea_logs.parse_nmea(data.decode("ascii", "replace"), first_day)
        raise InputError("neither GPX nor NMEA sentences, expected one of them: a table, or another format of tracks?")
    except InputError as error:
        raise InputError(f"{quoted(path, limit=200)}: {error}") from None


def gps_kind(data: bytes) -> str | None:
    """What a file is by its first bytes: "gpx", "nmea" or None."""
    start = data[:SNIFFED].removeprefix(b"\xef\xbb\xbf").lstrip()
    if start.startswith((b"<", b"\xff\xfe<", b"\xfe\xff\0<")):  # the last two in UTF-16
        return "gpx"
    return "nmea" if nmea_logs.SENTENCE.search(start) else None


def local_plane(
    latitude_deg: ArrayLike,
    longitude_deg: ArrayLike,
    height: ArrayLike | None = None,
    origin_deg: tuple[float, float] | None = None,
) -> tuple[Floats, tuple[float, float]]:
    """Positions (n, 3) [m] east, north and up, and the latitude and longitude of their origin.

    Parameters
    ----------
    latitude_deg, longitude_deg : (n,) arrays on WGS84, NaN where not known
    height : (n,) array [m], NaN where not known; it is the third coordinate as it is. None gives zeros
    origin_deg : latitude and longitude of (0, 0); None takes the first that is known. What is to be compared needs one
        origin

    Raises
    ------
    InputError
        If shapes do not agree, nothing is known, a coordinate is none on Earth, or one is beyond 1000 km.

    Notes
    -----
    Azimuthal equidistant: distance and bearing from the origin are those on the ellipsoid. The direction and the chord
    to a place are found in the plane that touches the ellipsoid at the origin, and the chord is bent to an arc of the
    radius that the ellipsoid has in this direction (Euler's formula). Against geodesics a place is so off by less than
    1 mm within 30 km, 2 cm at 100 km, 40 cm at 300 km and 14 m at 1000 km. Between two places at a distance d from the
    origin, lengths across are too long by d²/6R²: 4 parts in 10 million at 10 km, 4 in 100 000 at 100 km. Lengths are
    those on the ellipsoid; at a height h they are h/R longer, 16 cm in a kilometre at 1000 m.
    """
    latitude, longitude = as_numbers("latitude", latitude_deg), as_numbers("longitude", longitude_deg)
    check_shape("latitude", latitude, ("n",))
    check_shape("longitude", longitude, latitude.shape)
    up = np.zeros(latitude.shape) if height is None else as_numbers("height", height).astype(float)
    check_shape("height", up, latitude.shape)
    is_known = np.isfinite(latitude) & np.isfinite(longitude)
    if not is_known.any():
        raise InputError("no latitude and longitude is known, expected one at least")
    check_degrees(latitude[is_known], longitude[is_known])
    first = int(np.argmax(is_known))
    origin = (float(latitude[first]), float(longitude[first])) if origin_deg is None else _origin(origin_deg)
    position = np.column_stack([*_east_north(np.deg2rad(latitude), np.deg2rad(longitude), origin), up])
    reach = np.hypot(position[is_known, 0], position[is_known, 1]).max()
    if reach > MAX_REACH:
        raise InputError(
            f"a place is {reach / 1000:.0f} km from the origin {origin[0]:.4f}, {origin[1]:.4f}, expected at most "
            f"{MAX_REACH / 1000:.0f} km: a fix that is off, or the origin of another track?"
        )
    return position, origin


def _origin(origin_deg: tuple[float, float]) -> tuple[float, float]:
    pair = as_numbers("origin_deg", origin_deg).astype(float)
    check_shape("origin_deg", pair, (2,))
    check_degrees(pair[:1], pair[1:])
    return float(pair[0]), float(pair[1])


def _east_north(latitude: Floats, longitude: Floats, origin_deg: tuple[float, float]) -> tuple[Floats, Floats]:
    """Metres east and north on the ellipsoid, of angles in radians."""
    sin_origin, cos_origin = np.sin(np.deg2rad(origin_deg[0])), np.cos(np.deg2rad(origin_deg[0]))
    turn = longitude - np.deg2rad(origin_deg[1])
    # Earth-centred, turned so that the origin is at longitude 0.
    across = SEMI_MAJOR_AXIS / np.sqrt(1 - ECCENTRICITY_SQUARED * np.sin(latitude) ** 2)  # radius of the prime vertical
    outward = across * np.cos(latitude)
    polar = across * (1 - ECCENTRICITY_SQUARED) * np.sin(latitude)
    across_origin = SEMI_MAJOR_AXIS / np.sqrt(1 - ECCENTRICITY_SQUARED * sin_origin**2)
    outward_step = outward * np.cos(turn) - across_origin * cos_origin
    polar_step = polar - across_origin * (1 - ECCENTRICITY_SQUARED) * sin_origin
    east = outward * np.sin(turn)
    north = polar_step * cos_origin - outward_step * sin_origin
    down = -(outward_step * cos_origin + polar_step * sin_origin)
    along_origin = across_origin * (1 - ECCENTRICITY_SQUARED) / (1 - ECCENTRICITY_SQUARED * sin_origin**2)
    flat = np.hypot(east, north)
    share = np.divide(north, flat, out=np.ones_like(flat), where=flat > 0) ** 2  # cos² of the bearing
    radius = 1 / (share / along_origin + (1 - share) / across_origin)
    angle = np.arctan2(flat, radius - down)  # seen from the centre of the circle that touches at the origin
    stretch = np.divide(radius * angle, flat, out=np.ones_like(flat), where=flat > 0)
    return east * stretch, north * stretch
