"""Times of frames from names, tables, cameras and rates; streams of two rates; clocks that are not the same."""

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from insectnav.checks import InputError
from insectnav.datasets.clocks import check_common_clock, zone_hours
from insectnav.datasets.exif_times import read_exif_time
from insectnav.datasets.frame_times import frame_name, nearest_in_time, times_in_names, times_of_frames
from real_routes import DATA
from uneven_films import uneven_film

NOON = datetime(2014, 5, 6, 12, 0, 0, tzinfo=UTC).timestamp()


@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("a/b/frame_1.png", "frame_1"),
        ("a\\b\\frame_1.JPEG", "frame_1"),
        ("1403636579.763555584", "1403636579.763555584"),
        ("1403636579.763555584.png", "1403636579.763555584"),
        (".png", ".png"),
        ("frame", "frame"),
        (Path("x/DSC_1.NEF"), "DSC_1"),
    ],
)
def test_name_of_a_frame(file: str, name: str):
    assert frame_name(file) == name


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["280353.jpg", "280357.jpg", "280359.jpg"], [280353, 280357, 280359]),  # GNSS seconds of a week
        (["cam0_1403636579.25.png", "cam0_1403636579.5.png"], [1403636579.25, 1403636579.5]),
        (["1403636579763.png", "1403636580763.png"], [1403636579.763, 1403636580.763]),  # ms
        (["1403636579763555584.png"], [1403636579.7635556]),  # ns, as EuRoC has them
        (["f1403636579763555.png"], [1403636579.763555]),  # μs
        (["run 3 at 17.png", "run 3 at 21.png"], [17, 21]),  # the number that differs
        (["IMG_20140506_120000.jpg", "IMG_20140506_120001.jpg"], [NOON, NOON + 1]),
        (["2014-05-06T12-00-00.250.png"], [NOON + 0.25]),
        (["20140506120000500.png"], [NOON + 0.5]),
        (["0.png", "10.png", "30.png"], [0, 10, 30]),  # no even steps: times
    ],
)
def test_times_in_names(names: list, expected: list):
    np.testing.assert_allclose(times_in_names(names), expected, rtol=0, atol=1e-6)


def test_dates_in_names_may_be_ahead_of_utc():
    names = ["20140506_140000.jpg"]
    assert times_in_names(names, utc_offset_h=2.0) == NOON
    assert times_of_frames("names", names=names, utc_offset_h=2.0, offset_s=-5) == NOON - 5


@pytest.mark.parametrize(
    ("name", "ahead_h"),
    [
        ("2014-05-06T12:00:00+02:00.jpg", 2.0),  # as date --iso-8601=seconds writes it
        ("2014-05-06T12:00:00-05:00.jpg", -5.0),
        ("20140506-120000+0530.jpg", 5.5),
        ("20140506T120000.000-0330.jpg", -3.5),
        ("20140506T120000Z.jpg", 0.0),
        ("20140506_120000Zoo.jpg", 3.0),
        ("20140506_120000+7.jpg", 3.0),
    ],
)
def test_zones_in_names_are_followed(name: str, ahead_h: float):
    assert times_in_names([name], utc_offset_h=3.0) == NOON - 3600 * ahead_h


@pytest.mark.parametrize(
    ("text", "hours"),
    [
        *[("Z", 0), ("+00:00", 0), ("-00:00", 0), ("+14:00", 14), ("+0545", 5.75), ("-03:30", -3.5)],
        *[(text, None) for text in ("", "+14:30", "-99:00", "+01:60", "02:00", "+2:00", "+١٢:٠٠", "+02:00 ", "UTC")],
    ],
)
def test_hours_of_a_zone(text: str, hours: float | None):
    assert zone_hours(text) == hours


@pytest.mark.parametrize(
    ("names", "says"),
    [
        ([f"frame_{k:05d}.png" for k in range(5)], "numbers of frames"),
        ([f"frame_{k}.png" for k in (1, 11, 21)], "numbers of frames"),
        (["1403636579_763555584.png", "1403636580_763555599.png"], "2 numbers in the names"),
        (["2_17.png", "3_17.png", "2_18.png"], "2 numbers in the names"),
        (["sky.png", "ground.png"], "no number each"),
        (["17.png", "readme.png"], "such as '17' and 'readme'"),
        ([], "number of frames is 0"),
    ],
)
def test_names_without_a_time_are_refused(names: list, says: str):
    with pytest.raises(InputError, match=says):
        times_in_names(names)


def test_dates_that_are_none_are_numbers():
    with pytest.raises(InputError, match="2 numbers"):
        times_in_names(["20141306_120000.jpg", "20141307_120001.jpg"])  # month 13


@pytest.mark.parametrize("ending", ["jpg", "png", "tif"])
@pytest.mark.parametrize("order", ["<", ">"])
def test_times_that_a_camera_wrote(ending: str, order: str, tmp_path: Path):
    path = tmp_path / f"a.{ending}"
    camera = {0x9003: "2014:05:06 12:00:00", 0x9291: "25"}
    for zone, expected in ({}, None), ({0x9011: "-07:30"}, -7.5):
        exif = Image.Exif()
        exif.endian = order
        exif[0x010F] = "a maker"
        exif[0x8769] = camera | zone
        if ending == "tif":
            path.write_bytes(exif.tobytes().removeprefix(b"Exif\0\0"))  # EXIF is a TIFF, if without a picture
        else:
            Image.new("RGB", (8, 8)).save(path, exif=exif)
        assert read_exif_time(path) == (NOON + 0.25, expected)
    times = times_of_frames("exif", names=[path], utc_offset_h=2.0)
    assert times == NOON + 0.25 + 7.5 * 3600  # what the picture says of its zone counts


def test_pictures_that_say_no_time(tmp_path: Path):
    plain, dated, empty = tmp_path / "plain.jpg", tmp_path / "dated.jpg", tmp_path / "empty.jpg"
    Image.new("L", (4, 4)).save(plain)
    empty.write_bytes(b"")
    exif = Image.Exif()
    exif.get_ifd(0x8769)[0x9003] = "2014:05:06 14:00:00"
    Image.new("L", (4, 4)).save(dated, exif=exif)
    times = times_of_frames("exif", names=[plain, dated, empty], utc_offset_h=2.0)
    np.testing.assert_array_equal(times, [np.nan, NOON, np.nan])
    with pytest.raises(InputError, match="none of 2 pictures"):
        times_of_frames("exif", names=[plain, empty])
    with pytest.raises(InputError, match="cannot be read"):
        times_of_frames("exif", names=[tmp_path / "absent.jpg"])


def test_clock_that_was_never_set_says_no_time(tmp_path: Path):
    exif = Image.Exif()
    exif.get_ifd(0x8769)[0x9003] = "0000:00:00 00:00:00"
    Image.new("L", (4, 4)).save(tmp_path / "a.jpg", exif=exif)
    assert read_exif_time(tmp_path / "a.jpg") is None


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_damaged_picture_says_no_time_or_some_time(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject):
    path = tmp_path_factory.mktemp("exif") / "a.jpg"
    exif = Image.Exif()
    exif.get_ifd(0x8769)[0x9003] = "2014:05:06 12:00:00"
    Image.new("L", (4, 4)).save(path, exif=exif)
    whole = path.read_bytes()
    start = data.draw(st.integers(0, 200))
    path.write_bytes(whole[:start] + data.draw(st.binary(max_size=8)) + whole[start + data.draw(st.integers(0, 8)) :])
    found = read_exif_time(path)
    assert found is None or np.isfinite(found.clock)


def test_frames_at_a_rate():
    np.testing.assert_allclose(times_of_frames(25.0, names=["a", "b", "c"]), [0, 0.04, 0.08])
    np.testing.assert_allclose(times_of_frames(10, numbers=[5, 50], offset_s=100), [100.5, 105])


def test_frames_of_a_video(tmp_path: Path):
    cv2 = pytest.importorskip("cv2")
    path = tmp_path / "a.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 12.5, (32, 16))
    for _ in range(3):
        writer.write(np.zeros((16, 32, 3), np.uint8))
    writer.release()
    np.testing.assert_allclose(times_of_frames(path, numbers=[0, 1, 2]), [0, 0.08, 0.16])
    np.testing.assert_allclose(times_of_frames(path, numbers=[2, 3, -1]), [0.16, np.nan, np.nan])
    for numbers in ([3], [-1], []):
        with pytest.raises(InputError, match=r"'a\.avi' holds 3 frames and none of those numbers"):
            times_of_frames(path, numbers=numbers)


def test_frames_of_a_video_of_uneven_rate(tmp_path: Path):
    seconds = [0.1] * 4 + [0.5] * 4
    path = uneven_film(tmp_path / "a.mp4", np.zeros((8, 48, 64), np.uint8), seconds)
    expected = np.cumsum([0, *seconds[:-1]])
    np.testing.assert_allclose(times_of_frames(path, names=list("abcdefgh")), expected, atol=1e-3)
    np.testing.assert_allclose(times_of_frames(path, numbers=[7, 5], offset_s=2), expected[[7, 5]] + 2, atol=1e-3)
    for names in (list("abcd"), list("abcdefghi")):  # every second frame, or another film's
        with pytest.raises(InputError, match=f"'a.mp4' holds 8 frames and {len(names)} pictures are given"):
            times_of_frames(path, names=names)
    np.testing.assert_allclose(times_of_frames(path, names=list("ab"), numbers=[0, 4]), expected[[0, 4]], atol=1e-3)


def test_table_of_times_by_name_and_by_number(tmp_path: Path):
    path = tmp_path / "times.csv"
    path.write_text("Time [s], Filename\n0.5, outdoor/b_1.png\n1.5, outdoor/b_2.png\n")
    np.testing.assert_array_equal(times_of_frames(path, names=["b_2.jpg", "b_3.jpg"]), [1.5, np.nan])
    path.write_text("frame\ttime_ms\n7\t250\n8\t500\n")
    np.testing.assert_array_equal(times_of_frames(path, numbers=np.array([8, 7, 6]), offset_s=1), [1.5, 1.25, np.nan])


@pytest.mark.parametrize(
    ("text", "key", "says"),
    [
        ("file,x_m\na,1\n", {"names": ["a"]}, "no column of a time"),
        ("file,time\na,1\n", {"names": ["a"]}, "which unit is 'time' in?"),
        ("time_s,x_m\n1,1\n", {"names": ["a"]}, "no column of a file"),
        ("time_s,file\n1,a\n", {"numbers": [1]}, "no column of a frame"),
        ("time_s,file\n1,a\n2,a.png\n", {"names": ["a"]}, "row 3: the frame 'a' is there twice"),
        ("time_s,file\n1,a\n,a.png\n", {"names": ["a"]}, "row 3: the frame 'a' is there twice, at two times"),
        ("time_s,file\n1,a\n", {"names": ["b"]}, "no frame is in the table, such as 'b' here and 'a' there"),
        ("time_s,frame\n1,\n", {"numbers": [1]}, "frame"),
    ],
)
def test_tables_without_times_of_these_frames_are_refused(text: str, key: dict, says: str, tmp_path: Path):
    path = tmp_path / "times.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=says) as error:
        times_of_frames(path, **key)
    assert "times.csv" in str(error.value)


@pytest.mark.parametrize(
    ("source", "key", "says"),
    [
        ("names", {}, "neither names nor numbers"),
        ("exif", {"numbers": [1]}, "no names of frames"),
        (0.0, {"numbers": [1]}, "frames per second"),
        (25.0, {"numbers": [0.5]}, "fractions"),
        ("absent.csv", {"numbers": [1]}, "no such file"),
        ("names", {"names": ["1.png"], "utc_offset_h": 120}, "offset from UTC is 120"),
    ],
)
def test_sources_that_give_no_time_are_refused(source: str | float, key: dict, says: str):
    with pytest.raises(InputError, match=says):
        times_of_frames(source, **key)


def test_streams_of_two_rates_are_joined_by_the_nearest():
    slow, fast = np.array([0.0, 1.0, 2.0, 2.5, np.nan]), np.arange(0, 2.01, 0.4)
    np.testing.assert_array_equal(nearest_in_time(slow, fast, 0.25), [0, 2, 5, -1, -1])  # of two as near the earlier
    np.testing.assert_array_equal(nearest_in_time([0.5, 1.5], [0.0, 1.0, 2.0], 1.0), [0, 1])
    shuffled = [5, 3, 0, 1, 4, 2]
    np.testing.assert_array_equal(nearest_in_time(slow, fast[shuffled], 0.25), [2, 5, 0, -1, -1])


@settings(max_examples=200, deadline=None)
@given(
    st.lists(st.floats(0, 10), min_size=1), st.lists(st.floats(0, 10) | st.just(np.nan), min_size=1), st.floats(0.1, 5)
)
def test_nearest_is_the_nearest(first: list, second: list, max_gap: float):
    one, other = np.array(first), np.array(second)
    try:
        found = nearest_in_time(one, other, max_gap)
    except InputError:
        return
    apart = np.abs(one[:, None] - np.where(np.isnan(other), np.inf, other))
    is_clear = np.abs(apart.min(axis=1) - max_gap) > 1e-12  # else rounding decides
    np.testing.assert_array_equal((found >= 0)[is_clear], (apart.min(axis=1) <= max_gap)[is_clear])
    rows = np.flatnonzero(found >= 0)
    np.testing.assert_array_equal(apart[rows, found[rows]], apart.min(axis=1)[rows])


@pytest.mark.parametrize(
    ("frames", "positions", "says"),
    [
        ((0, 60), (65.0, 61243.0), "seconds against milliseconds"),
        ((0, 60_000), (0, 61), "seconds against milliseconds"),  # ranges overlap, yet one is a thousand times the other
        ((1.4e9, 1.4e9 + 60), (1.4e12, 1.4e12 + 60_000), "milliseconds"),
        ((1.4e18, 1.4e18 + 6e10), (1.4e9, 1.4e9 + 60), "nanoseconds"),
        ((NOON + 7200, NOON + 7300), (NOON, NOON + 100), "two time zones"),
        ((0, 60), (1.4e9, 1.4e9 + 60), "from 1970: which offset"),
        ((NOON - 315_964_800 + 16, NOON - 315_964_700 + 16), (NOON, NOON + 100), "from 1980.*315964782"),
        ((NOON, NOON + 100), (NOON - 1024 * 604_800, NOON + 100 - 1024 * 604_800), "weeks has started anew.*619315200"),
        ((NOON, NOON + 100), (NOON + 5e6, NOON + 5e6 + 100), "two recordings"),
    ],
)
def test_clocks_that_are_not_the_same(frames: tuple, positions: tuple, says: str):
    one, other = np.linspace(*frames, 20), np.linspace(*positions, 20)
    with pytest.raises(InputError, match=says):
        check_common_clock("the frames", one, "the positions", other)
    with pytest.raises(InputError, match=says):
        nearest_in_time(one, other, 0.1)


@pytest.mark.parametrize("start", [0, 1_399_379_412])
def test_nearest_within_just_the_gap_is_found_whatever_the_rounding(start: int):
    time = start + np.arange(0, 100, 2) * 0.1
    np.testing.assert_array_equal(nearest_in_time(time + 0.1, time, 0.1) >= 0, True)
    np.testing.assert_array_equal(nearest_in_time(time + 0.1, time, 0.0999), -1)


def test_clocks_that_may_be_the_same():
    hour = np.linspace(0, 3600, 50)
    check_common_clock("the frames", hour[10:12], "the positions", hour)
    check_common_clock("the frames", hour, "the positions", hour[10:11])
    check_common_clock("the frames", hour + 3601, "the positions", hour, margin_s=1.0)


@pytest.mark.data
def test_names_of_a_walk_are_seconds_of_the_week():
    files = sorted((DATA / "fisheye_sky").glob("*.jpg"))
    if not files:
        pytest.skip("fisheye_sky is missing")
    times = times_in_names(files)
    assert len(times) == 65
    assert times.min() > 0 and times.max() < 604_800
    assert np.diff(np.sort(times)).mean() == pytest.approx(4.4, abs=0.5)  # as its description has it


def test_a_row_without_a_time_is_a_frame_whose_time_is_not_known(tmp_path: Path):
    path = tmp_path / "times.csv"
    path.write_text("file,time_s\na.png,1\nb.png,\nc.png,nan\nc.png,\n")
    np.testing.assert_array_equal(times_of_frames(path, names=list("abcd")), [1, np.nan, np.nan, np.nan])
