"""Metres east and north: published lengths of a degree, geodesics, the seams of the map. Files by what they hold."""

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geodesics import destination
from insectnav.checks import InputError
from insectnav.datasets.gps import local_plane, read_gps

GPX = """<?xml version="1.0"?>
<gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg>
<trkpt lat="51.5" lon="-1.25"><ele>30.5</ele><time>2014-05-06T12:00:00.5Z</time></trkpt>
</trkseg></trk></gpx>"""
# Sentences of a research ship, NOAA, ATOMIC 2020, raw file gps02001420_raw.txt.
NMEA = """0000030 $GPGGA,195959.00,1541.31258893,N,05130.51204125,W,2,06,1.5,9.2,M,-37.6,M,4.0,0138*7E
0000155 $GPRMC,195959.00,A,1541.31258893,N,05130.51204125,W,0.26,147.44,140120,16.9,W,D*0B
"""


# Kilometres in a degree, latitude and longitude, as tables of WGS84 give them to the metre.
@pytest.mark.parametrize(
    ("latitude", "north_km", "east_km"),
    [
        (0, 110.574, 111.320),
        (15, 110.649, 107.551),
        (30, 110.852, 96.486),
        (45, 111.132, 78.847),
        (60, 111.412, 55.800),
        (75, 111.618, 28.902),
    ],
)
def test_degree_has_its_published_length(latitude: float, north_km: float, east_km: float):
    step = 0.01  # over which neither changes by a metre in a degree
    position, origin = local_plane([latitude, latitude], [7, 7 + step])
    assert origin == (latitude, 7)
    np.testing.assert_allclose(position[0], 0, atol=1e-9)
    northward, _ = local_plane([latitude + step / 2], [7], origin_deg=(latitude - step / 2, 7))
    assert northward[0, 1] / step == pytest.approx(1000 * north_km, abs=1.0)
    assert position[1, 0] / step == pytest.approx(1000 * east_km, abs=1.0)


def test_published_line_of_flinders_peak():
    # Technical manual of the Geocentric Datum of Australia, on GRS80, whose axes are those of WGS84 to 0.1 mm.
    buninyong = -(37 + 39 / 60 + 10.15610 / 3600), 143 + 55 / 60 + 35.38390 / 3600
    flinders = -(37 + 57 / 60 + 3.72030 / 3600), 144 + 25 / 60 + 29.52440 / 3600
    (position,), _ = local_plane([buninyong[0]], [buninyong[1]], origin_deg=flinders)
    assert np.hypot(*position[:2]) == pytest.approx(54972.271, abs=1e-3)
    bearing = np.rad2deg(np.arctan2(position[0], position[1])) % 360
    assert bearing == pytest.approx(306 + 52 / 60 + 5.37 / 3600, abs=0.05 / 3600)


@settings(max_examples=200, deadline=None)
@given(st.floats(-89.0, 89.0), st.floats(-180.0, 180.0), st.floats(0.0, 2 * np.pi), st.floats(1.0, 300_000.0))
def test_plane_agrees_with_geodesics(latitude: float, longitude: float, bearing: float, length: float):
    place = destination(latitude, longitude, bearing, length)
    (position,), _ = local_plane([place[0]], [(place[1] + 180) % 360 - 180], origin_deg=(latitude, longitude))
    wanted = length * np.array([np.sin(bearing), np.cos(bearing)])
    bound = 1e-3 if length <= 30_000 else 0.02 if length <= 100_000 else 0.4  # [m], as the docstring has it
    assert np.hypot(*(position[:2] - wanted)) < bound


# Distance from the origin and greatest error [m] that docs/positions.md gives.
@pytest.mark.parametrize(("length", "error"), [(1e4, 1e-5), (3e4, 4e-4), (1e5, 0.014), (3e5, 0.37)])
def test_errors_are_those_on_the_page(length: float, error: float):
    bearings = np.linspace(0, 2 * np.pi, 25, endpoint=False)
    wanted = length * np.stack([np.sin(bearings), np.cos(bearings)], axis=-1)
    worst = 0.0
    for latitude in np.linspace(-85, 85, 18):
        places = np.array([destination(latitude, 0.0, bearing, length) for bearing in bearings])
        position, _ = local_plane(*places.T, origin_deg=(latitude, 0.0))
        worst = max(worst, np.linalg.norm(position[:, :2] - wanted, axis=-1).max())
    assert worst == pytest.approx(error, rel=0.1, abs=5e-6)


def test_date_line_and_poles_are_no_seams():
    position, _ = local_plane([0, 0], [180, -180], origin_deg=(0, 179.999))
    np.testing.assert_allclose(position[:, 0], 111.31949, atol=1e-3)
    position, _ = local_plane([0], [359.999], origin_deg=(0, 0))
    np.testing.assert_allclose(position[:, 0], -111.31949, atol=1e-3)
    around, _ = local_plane([89.999] * 4, [0, 90, 180, -90], origin_deg=(90, 0))
    np.testing.assert_allclose(np.hypot(*around[:, :2].T), 111.694, atol=1e-3)
    np.testing.assert_allclose(around.sum(axis=0), 0, atol=1e-6)


def test_height_is_taken_as_it_is_and_what_is_not_known_stays_so():
    position, origin = local_plane([np.nan, 51.0, 51.0], [3.0, 1.0, np.nan], [1.0, 2.0, np.nan])
    assert origin == (51.0, 1.0)
    np.testing.assert_array_equal(position[1], [0, 0, 2])
    assert np.isnan(position[0, :2]).all() and np.isnan(position[2]).all()
    assert (local_plane([51.0], [1.0])[0][:, 2] == 0).all()


@pytest.mark.parametrize(
    ("latitude", "longitude", "origin", "says"),
    [
        ([51.0, 0.0], [-1.0, 0.0], None, "beyond|km from the origin"),
        ([513000.0], [181000.0], None, "latitude reaches 513000"),
        ([51.0], [400.0], None, "longitude reaches 400"),
        ([np.nan], [1.0], None, "is known"),
        ([51.0, 52.0], [1.0], None, "shape"),
        ([51.0], [1.0], (91.0, 0.0), "latitude reaches 91"),
    ],
)
def test_places_off_the_earth_are_refused(latitude: list, longitude: list, origin: tuple | None, says: str):
    with pytest.raises(InputError, match=says):
        local_plane(latitude, longitude, origin_deg=origin)


@pytest.mark.parametrize("name", ["a.gpx", "a.nmea", "a.txt", "a.log", "a"])
def test_content_decides_not_the_ending(name: str, tmp_path: Path):
    path = tmp_path / name
    path.write_text(GPX)
    track = read_gps(path)
    assert track.time == datetime(2014, 5, 6, 12, 0, 0, 500_000, UTC).timestamp()
    assert (track.latitude_deg, track.longitude_deg, track.height) == (51.5, -1.25, 30.5)
    path.write_text(NMEA)
    track = read_gps(path)
    assert track.time == datetime(2020, 1, 14, 19, 59, 59, tzinfo=UTC).timestamp()
    assert track.height == 9.2


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "neither GPX nor NMEA"),
        (b"time_s,x_m\n1,2\n", "neither GPX nor NMEA"),
        (b"PK\x03\x04" + bytes(100), "neither GPX nor NMEA"),
        (b"<html><body/></html>", "'html'"),
    ],
)
def test_other_files_are_refused_by_name(data: bytes, says: str, tmp_path: Path):
    path = tmp_path / "track.gpx"
    path.write_bytes(data)
    with pytest.raises(InputError, match=says) as error:
        read_gps(path)
    assert "track.gpx" in str(error.value) and "\n" not in str(error.value)


def test_missing_file_and_folder_are_refused(tmp_path: Path):
    with pytest.raises(InputError, match="no such file"):
        read_gps(tmp_path / "absent.gpx")
    with pytest.raises(InputError, match="this is a folder, expected a GPX file"):
        read_gps(tmp_path)


def test_file_beyond_bounds_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    path = tmp_path / "a.gpx"
    path.write_text(GPX)
    monkeypatch.setattr("insectnav.datasets.gps.MAX_BYTES", 100)
    with pytest.raises(InputError, match="larger"):
        read_gps(path)
