"""GPX: tracks and segments in order of time, zones, what is not a recording, and files that mean harm."""

from datetime import UTC, datetime

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from insectnav.checks import InputError
from insectnav.datasets.gps_track import GpsTrack
from insectnav.datasets.gpx_files import parse_gpx

START = datetime(2014, 5, 6, 12, 0, 0, tzinfo=UTC)


def point(latitude: float = 51.0, longitude: float = 1.0, time: str = "", height: str = "") -> str:
    inside = (f"<ele>{height}</ele>" if height else "") + (f"<time>{time}</time>" if time else "")
    return f'<trkpt lat="{latitude}" lon="{longitude}">{inside}</trkpt>'


def gpx(*tracks: str, start: str = "") -> bytes:
    inside = "".join(f"<trk><name>a</name>{track}</trk>" for track in tracks)
    return f'{start}<gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1">{inside}</gpx>'.encode()


def segment(*points: str) -> str:
    return f"<trkseg>{''.join(points)}</trkseg>"


def test_tracks_come_in_order_of_time_and_segments_apart():
    late = segment(point(time="2014-05-06T13:00:00Z"), point(time="2014-05-06T13:00:01Z"))
    early = segment(point(time="2014-05-06T12:00:00Z")) + segment(point(time="2014-05-06T12:10:00Z"))
    track = parse_gpx(gpx(late, early))
    np.testing.assert_array_equal(track.time - START.timestamp(), [0, 600, 3600, 3601])
    np.testing.assert_array_equal(track.segment, [0, 1, 2, 2])
    assert np.isnan(track.height).all()
    assert track.notes == ()


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("2014-05-06T12:00:00Z", 0),
        ("2014-05-06T12:00:00.25Z", 0.25),
        ("2014-05-06T14:00:00+02:00", 0),
        ("2014-05-06T05:00:00-07:00", 0),
        (" 2014-05-06T12:00:01 ", 1),
    ],
)
def test_zones_and_fractions_of_seconds(text: str, seconds: float):
    track = parse_gpx(gpx(segment(point(time=text))))
    assert track.time[0] - START.timestamp() == seconds
    assert bool(track.notes) == ("Z" not in text and "+" not in text and "-07" not in text)


def test_points_without_time_are_kept():
    track = parse_gpx(gpx(segment(point(height="12.5"), point(52.0), point(53.0, height=" ", time=" "))))
    assert np.isnan(track.time).all()
    np.testing.assert_array_equal(track.height, [12.5, np.nan, np.nan])
    np.testing.assert_array_equal(track.latitude_deg, [51, 52, 53])


def test_heights_and_times_of_other_elements_are_not_those_of_points():
    inside = "<extensions><x><ele>99</ele><time>1999-01-01T00:00:00Z</time></x></extensions>"
    track = parse_gpx(
        gpx(segment(f'<trkpt lat="1" lon="2">{inside}</trkpt>')).replace(b"<trk>", b"<time>1998</time><trk>")
    )
    assert np.isnan(track.time[0]) and np.isnan(track.height[0])


def test_other_encodings_and_prefixes_of_names():
    text = gpx(segment(point())).decode()
    assert parse_gpx(b"\xef\xbb\xbf" + text.encode()).latitude_deg == 51
    assert parse_gpx(text.encode("utf-16")).latitude_deg == 51
    prefixed = text.replace("xmlns=", "xmlns:g=").replace("</", "</g:").replace("<", "<g:").replace("<g:/g:", "</g:")
    assert parse_gpx(prefixed.encode()).latitude_deg == 51


def test_file_of_another_program_is_read_alike():
    gpxpy = pytest.importorskip("gpxpy")
    file = gpxpy.gpx.GPX()
    file.tracks.append(gpxpy.gpx.GPXTrack())
    file.tracks[0].segments += [gpxpy.gpx.GPXTrackSegment(), gpxpy.gpx.GPXTrackSegment()]
    rng = np.random.default_rng(0)
    for k, (latitude, longitude, height) in enumerate(rng.uniform(-80, 80, (20, 3))):
        when = datetime.fromtimestamp(1.4e9 + k / 4, UTC)
        part = file.tracks[0].segments[k // 10]
        part.points.append(gpxpy.gpx.GPXTrackPoint(latitude, longitude, height, when))
    track = parse_gpx(file.to_xml().encode())
    again = [one for part in gpxpy.parse(file.to_xml()).tracks[0].segments for one in part.points]
    np.testing.assert_array_equal(track.latitude_deg, [one.latitude for one in again])
    np.testing.assert_array_equal(track.longitude_deg, [one.longitude for one in again])
    np.testing.assert_array_equal(track.height, [one.elevation for one in again])
    np.testing.assert_array_equal(track.time, [one.time.timestamp() for one in again])
    np.testing.assert_array_equal(track.segment, np.repeat([0, 1], 10))


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (gpx(segment(point()))[:-10], "no sound XML"),
        (b"<gpx></gpx>", "holds nothing, expected trk"),
        (b'<gpx><rte><rtept lat="1" lon="2"/></rte></gpx>', "planned route"),
        (b'<gpx><wpt lat="1" lon="2"/></gpx>', "waypoints"),
        (gpx(segment()), "no track with points"),
        (b"<kml><trk/></kml>", "'kml'"),
        (gpx(segment('<trkpt lat="1"/>')), "lon ''"),
        (gpx(segment(point(latitude=float("nan")))), "finite"),
        (gpx(segment(point(latitude=95.0))), "latitude reaches 95"),
        (gpx(segment(point(height="high"))), "ele 'high'"),
        (gpx(segment(point(time="noon"))), "'noon' is no time"),
        (gpx(segment(point(time="2014-13-06T12:00:00Z"))), "is no time"),
        (gpx(segment("<extensions>" + "<a>" * 300_000)), "deep"),
    ],
)
def test_what_is_no_recording_is_refused_in_a_sentence(data: bytes, says: str):
    with pytest.raises(InputError, match=says) as error:
        parse_gpx(data)
    assert "\n" not in str(error.value)


LAUGHS = '<!DOCTYPE gpx [<!ENTITY a "ha">' + "".join(
    f'<!ENTITY {after} "{f"&{before};" * 10}">' for before, after in zip("abcdefghi", "bcdefghij", strict=True)
) + "]>"  # fmt: skip


@pytest.mark.parametrize(
    "start",
    [
        LAUGHS,
        "<!DOCTYPE gpx>",
        '<!DOCTYPE gpx SYSTEM "file:///etc/passwd">',
        '<?xml version="1.0"?><!-- a -->' + LAUGHS,
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_document_types_are_refused_before_they_are_followed(start: str, encoding: str):
    data = gpx(segment(point(time="&j;")), start=start).decode().encode(encoding)
    with pytest.raises(InputError, match="document type"):
        parse_gpx(data)


def test_entities_cannot_be_declared_otherwise():
    with pytest.raises(InputError, match="undefined entity"):
        parse_gpx(gpx(segment(point(time="&j;"))))


WHOLE = gpx(segment(point(time="2014-05-06T12:00:00Z", height="3"), point(52.0)))


@settings(max_examples=300, deadline=None)
@given(st.integers(0, len(WHOLE) - 1), st.integers(0, len(WHOLE) - 1), st.binary(max_size=6))
def test_damaged_file_is_read_or_refused_but_never_fails_otherwise(start: int, stop: int, other: bytes):
    try:
        assert isinstance(parse_gpx(WHOLE[: min(start, stop)] + other + WHOLE[max(start, stop) :]), GpsTrack)
    except InputError as error:
        assert "\n" not in str(error)
