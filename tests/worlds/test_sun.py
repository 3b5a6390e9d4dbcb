"""The sun against published positions, the ephemeris of astropy, and closed forms."""

from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest
from astropy import units
from astropy.coordinates import AltAz, EarthLocation, get_body
from astropy.time import Time
from astropy.utils import iers
from hypothesis import given, settings
from hypothesis import strategies as st

from insectnav.angles import wrap
from insectnav.checks import InputError
from insectnav.worlds.sun import declination_and_equation_of_time, refraction_of, sun_direction, sun_position, utc

seeds = st.integers(0, 2**32 - 1)


def test_published_example():
    # Reda and Andreas 2004 (doi 10.1016/j.solener.2003.12.003), Table A5.1: zenith 50.11162°, azimuth 194.34024°.
    time = datetime(2003, 10, 17, 12, 30, 30, tzinfo=timezone(timedelta(hours=-7)))
    sun = sun_position(time, 39.742476, -105.1786)
    assert 90.0 - np.rad2deg(sun.elevation) == pytest.approx(50.11162, abs=0.03)
    assert np.rad2deg(sun.azimuth) % 360.0 == pytest.approx(194.34024, abs=0.03)


def test_published_declination_and_equation_of_time():
    # Meeus 1991, examples 24.a and 27.b: 1992 October 13, 0h; −7.78507° and 13 min 42.7 s.
    declination, equation = declination_and_equation_of_time(-0.072183436)
    assert np.rad2deg(declination) == pytest.approx(-7.78507, abs=2e-4)
    assert np.rad2deg(equation) * 240.0 == pytest.approx(13 * 60 + 42.7, abs=0.1)


def test_agrees_with_ephemeris_in_all_places_and_seasons():
    rng, n = np.random.default_rng(0), 300
    time = np.datetime64("1975-01-01") + rng.integers(0, 50 * 365 * 86400, n).astype("timedelta64[s]")
    latitude, longitude = rng.uniform(-90, 90, n), rng.uniform(-180, 180, n)
    with iers.conf.set_temp("auto_download", False):
        place = EarthLocation(lon=longitude * units.deg, lat=latitude * units.deg)
        moment = Time(time, scale="utc")
        true = get_body("sun", moment, place).transform_to(AltAz(obstime=moment, location=place))
    sun = sun_position(time, latitude, longitude, refraction=False)
    distance = sun_direction(sun.azimuth, sun.elevation) - sun_direction(true.az.rad, true.alt.rad)
    assert np.rad2deg(np.linalg.norm(distance, axis=-1)).max() < 0.03


@pytest.mark.parametrize(
    ("time", "declination"),
    [("2024-03-20T03:06", 0.0), ("2024-06-20T20:51", 23.436), ("2024-12-21T09:20", -23.436)],
)
def test_equinox_and_solstices(time, declination):
    # The moments are those of the Astronomical Almanac; at the pole the sun stands as high as its declination.
    sun = sun_position(np.datetime64(time), 90.0, 0.0, refraction=False)
    assert np.rad2deg(sun.elevation) == pytest.approx(declination, abs=0.01)


@given(st.floats(-89, 89), st.floats(-180, 180), st.integers(0, 36500))
@settings(max_examples=30)
def test_noon_elevation_and_meridian(latitude, longitude, day):
    start = np.datetime64("1950-01-01") + np.timedelta64(day, "D") - np.timedelta64(round(longitude * 240), "s")
    times = start + np.arange(-6 * 60, 6 * 60).astype("timedelta64[m]") + np.timedelta64(12, "h")
    sun = sun_position(times, latitude, longitude, refraction=False)
    noon = int(np.argmax(sun.elevation))
    century = (times[noon] - np.datetime64("2000-01-01T12:00")) / np.timedelta64(1, "D") / 36525
    declination, equation = declination_and_equation_of_time(century)
    from_zenith = abs(latitude - np.rad2deg(declination))
    missed = np.hypot(from_zenith, 0.125) - from_zenith  # [°] at most, for half a minute beside the top
    assert -0.02 - missed < np.rad2deg(sun.elevation[noon]) - (90.0 - from_zenith) < 0.02
    minutes = noon - 6 * 60 + np.rad2deg(equation) * 4.0
    assert abs(minutes) < 3.0 + 0.5 / np.cos(np.deg2rad(latitude)) ** 2  # the declination moves the top a little


@given(st.floats(-80, 80), st.floats(-150, 150), seeds)
def test_an_hour_is_fifteen_degrees_of_longitude(latitude, longitude, seed):
    time = np.datetime64("1990-01-01") + np.timedelta64(seed % (20 * 365 * 86400), "s")
    later = sun_position(time + np.timedelta64(1, "h"), latitude, longitude, refraction=False)
    east = sun_position(time, latitude, longitude + 15.0, refraction=False)
    distance = np.linalg.norm(sun_direction(*later) - sun_direction(*east))
    assert np.rad2deg(distance) < 0.025  # the declination moves by 0.016° and the equation of time by 0.005° an hour


def test_sun_rises_in_the_east_and_stands_in_the_south():
    times = np.array(["2024-03-20T06:10", "2024-03-20T12:07", "2024-03-20T18:05"], "datetime64[m]")
    sun = sun_position(times, 50.0, 0.0)
    assert np.abs(wrap(sun.azimuth - np.deg2rad([90.0, 180.0, -90.0]))).max() < np.deg2rad(1.5)
    assert np.deg2rad(39.5) < sun.elevation[1] < np.deg2rad(40.5)


@given(st.floats(-0.5, 89.5))
def test_refraction_agrees_with_another_formula(elevation):
    # Saemundsson 1986, Sky and Telescope 72:70, for the true elevation, in minutes of arc.
    minutes = 1.02 / np.tan(np.deg2rad(elevation + 10.3 / (elevation + 5.11)))
    assert np.rad2deg(refraction_of(np.deg2rad(elevation))) * 60.0 == pytest.approx(minutes, abs=1.0)


def test_refraction_of_the_setting_sun_is_34_minutes():
    assert np.rad2deg(refraction_of(np.deg2rad(-34 / 60))) * 60 == pytest.approx(34.0, abs=1.0)


def test_batch_is_loop():
    rng = np.random.default_rng(1)
    times = np.datetime64("2020-01-01") + rng.integers(0, 10**7, 7).astype("timedelta64[s]")
    latitudes = rng.uniform(-90, 90, (3, 1))
    batch = sun_position(times, latitudes, 10.0)
    assert batch.azimuth.shape == batch.elevation.shape == (3, 7)
    for i, j in np.ndindex(3, 7):
        one = sun_position(times[j], latitudes[i, 0], 10.0)
        assert one.elevation == pytest.approx(batch.elevation[i, j], abs=1e-12)
        assert one.azimuth == pytest.approx(batch.azimuth[i, j], abs=1e-12)


def test_zone_of_a_datetime_counts():
    aware = datetime(2020, 6, 1, 14, 0, tzinfo=timezone(timedelta(hours=2)))
    assert utc(aware) == utc(datetime(2020, 6, 1, 12, 0, tzinfo=UTC)) == np.datetime64("2020-06-01T12:00")


@pytest.mark.parametrize(
    ("time", "latitude", "longitude", "words"),
    [
        (datetime(2020, 1, 1), 0.0, 0.0, "has no time zone"),
        ("2020-01-01", 0.0, 0.0, "expected an aware datetime"),
        (np.datetime64("NaT"), 0.0, 0.0, "NaT, expected the years"),
        (np.datetime64("1700-01-01"), 0.0, 0.0, "1901 to 2099"),
        (np.datetime64("2020-01-01"), 151.2, -33.9, "swapped"),
        (np.datetime64("2020-01-01"), np.nan, 0.0, "latitude_deg is nan"),
        (np.datetime64("2020-01-01"), 0.0, 1e6, "longitude_deg is 1e"),
    ],
)
def test_bad_input(time, latitude, longitude, words):
    with pytest.raises(InputError, match=words):
        sun_position(time, latitude, longitude)
