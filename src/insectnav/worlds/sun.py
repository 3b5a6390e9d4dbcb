"""Where the sun stands, from time and place."""

from datetime import UTC, datetime
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from insectnav.angles import wrap
from insectnav.checks import InputError, check_range, quoted

Reals = npt.NDArray[np.floating[Any]]
Time = datetime | np.datetime64 | npt.NDArray[np.datetime64]

SUN_DIAMETER = float(np.deg2rad(0.53))  # [rad] mean, as Preetham et al. 1999 have it for 6.8e-5 sr
J2000 = np.datetime64("2000-01-01T12:00:00")
FIRST, LAST = np.datetime64("1901-01-01"), np.datetime64("2100-01-01")  # the years for which NOAA vouches
DAYS_PER_CENTURY = 36525.0


class SunPosition(NamedTuple):
    """Direction of the sun's centre; both arrays have the shape of time and place broadcast."""

    azimuth: Reals  # [rad] clockwise from north, in [−π, π)
    elevation: Reals  # [rad] above the horizon, lifted by refraction unless that was refused


def sun_position(
    time: Time, latitude_deg: npt.ArrayLike, longitude_deg: npt.ArrayLike, *, refraction: bool = True
) -> SunPosition:
    """Azimuth and elevation of the sun, within 0.03° of an ephemeris.

    Parameters
    ----------
    time : aware datetime, or (...) array of datetime64
        A datetime64 is UTC.
    latitude_deg, longitude_deg : (...) arrays [°]
        North and east are positive.
    refraction : bool
        Whether to add the refraction of the air, 0.5° at the horizon.

    Raises
    ------
    InputError
        If the time has no time zone or lies outside the years 1901 to 2099, or the place is none on Earth.

    Notes
    -----
    NOAA Global Monitoring Laboratory, Solar Calculation Details (https://gml.noaa.gov/grad/solcalc/calcdetails.html),
    after Meeus, Astronomical Algorithms (1991), chapters 24 and 27; refraction: the same, in three pieces. Meeus counts
    in dynamical time, NOAA in UTC: the minute between them moves the sun by 0.001°.
    """
    moment = utc(time)
    check_range("latitude_deg", latitude_deg, -90.0, 90.0, "degrees", "latitude and longitude swapped?")
    check_range("longitude_deg", longitude_deg, -360.0, 360.0, "degrees")
    days = (moment - J2000) / np.timedelta64(1, "D")
    declination, equation_of_time = declination_and_equation_of_time(days / DAYS_PER_CENTURY)
    day_fraction = np.mod(days + 0.5, 1.0)
    hour_angle = 2 * np.pi * (day_fraction - 0.5) + equation_of_time + np.deg2rad(longitude_deg)
    latitude = np.deg2rad(latitude_deg)
    up = np.sin(latitude) * np.sin(declination) + np.cos(latitude) * np.cos(declination) * np.cos(hour_angle)
    east = -np.cos(declination) * np.sin(hour_angle)
    north = np.cos(latitude) * np.sin(declination) - np.sin(latitude) * np.cos(declination) * np.cos(hour_angle)
    elevation = np.arctan2(up, np.hypot(east, north))
    if refraction:
        elevation = elevation + refraction_of(elevation)
    return SunPosition(wrap(np.arctan2(east, north)), elevation)


def utc(time: Time) -> npt.NDArray[np.datetime64]:
    """Time as datetime64 in UTC, to the microsecond.

    Raises
    ------
    InputError
        If it has no time zone, is no time, or lies outside 1901 to 2099.
    """
    if isinstance(time, datetime):
        if time.tzinfo is None:
            raise InputError(
                f"time {time.isoformat()} has no time zone, expected an aware datetime, or datetime64 in UTC"
            )
        time = np.datetime64(time.astimezone(UTC).replace(tzinfo=None))
    array = np.asarray(time)
    if array.dtype.kind != "M":
        raise InputError(f"time is {quoted(time)}, expected an aware datetime, or datetime64 in UTC")
    if not ((array >= FIRST) & (array < LAST)).all():
        worst = array[~((array >= FIRST) & (array < LAST))].ravel()[0]
        raise InputError(f"time is {worst}, expected the years 1901 to 2099")
    return array.astype("datetime64[us]")


def declination_and_equation_of_time(century: npt.ArrayLike) -> tuple[Reals, Reals]:
    """Declination [rad] of the sun and apparent minus mean solar time as an angle [rad].

    Parameters
    ----------
    century : (...) array
        Julian centuries since 2000-01-01 12:00.

    Notes
    -----
    NOAA, as in `sun_position`; Meeus 1991, Eqs 24.2 to 24.8 and 27.3 (Smart's equation of time).
    """
    t = np.asarray(century, dtype=float)
    mean_longitude = np.deg2rad(280.46646 + t * (36000.76983 + 0.0003032 * t))
    anomaly = np.deg2rad(357.52911 + t * (35999.05029 - 0.0001537 * t))
    eccentricity = 0.016708634 - t * (0.000042037 + 0.0000001267 * t)
    centre = np.deg2rad(
        (1.914602 - t * (0.004817 + 0.000014 * t)) * np.sin(anomaly)
        + (0.019993 - 0.000101 * t) * np.sin(2 * anomaly)
        + 0.000289 * np.sin(3 * anomaly)
    )
    node = np.deg2rad(125.04 - 1934.136 * t)
    longitude = mean_longitude + centre - np.deg2rad(0.00569 + 0.00478 * np.sin(node))
    seconds = 21.448 - t * (46.815 + t * (0.00059 - 0.001813 * t))
    obliquity = np.deg2rad(23.0 + (26.0 + seconds / 60.0) / 60.0 + 0.00256 * np.cos(node))
    declination = np.arcsin(np.sin(obliquity) * np.sin(longitude))
    y = np.tan(obliquity / 2) ** 2
    equation_of_time = (
        y * np.sin(2 * mean_longitude)
        - 2 * eccentricity * np.sin(anomaly)
        + 4 * eccentricity * y * np.sin(anomaly) * np.cos(2 * mean_longitude)
        - 0.5 * y**2 * np.sin(4 * mean_longitude)
        - 1.25 * eccentricity**2 * np.sin(2 * anomaly)
    )
    return declination, equation_of_time


def refraction_of(elevation: npt.ArrayLike) -> Reals:
    """By how much [rad] the air at sea level lifts a body that stands at the true elevation [rad]; 0 at the zenith.

    Notes
    -----
    NOAA, as in `sun_position`.
    """
    degrees = np.rad2deg(np.asarray(elevation, dtype=float))
    # Each piece is taken where it holds, and held at its end beyond, where it could divide by nothing.
    tangent = np.tan(np.deg2rad(np.clip(degrees, 5.0, 85.0)))
    high = 58.1 / tangent - 0.07 / tangent**3 + 0.000086 / tangent**5
    low = 1735.0 + degrees * (-518.2 + degrees * (103.4 + degrees * (-12.79 + 0.711 * degrees)))
    below = -20.772 / np.tan(np.deg2rad(np.clip(degrees, -89.99, -0.575)))
    arcseconds = np.select([degrees > 85.0, degrees > 5.0, degrees > -0.575], [0.0, high, low], below)
    return np.deg2rad(arcseconds / 3600.0)


def sun_direction(azimuth: npt.ArrayLike, elevation: npt.ArrayLike) -> Reals:
    """Unit vector (..., 3) to the sun: +x east, +y north, +z up.

    Parameters
    ----------
    azimuth, elevation : (...) arrays [rad], clockwise from north and up from the horizon
    """
    azimuth, elevation = np.broadcast_arrays(azimuth, elevation)
    level = np.cos(elevation)
    return np.stack([np.sin(azimuth) * level, np.cos(azimuth) * level, np.sin(elevation)], axis=-1)
