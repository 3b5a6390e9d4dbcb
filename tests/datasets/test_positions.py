"""Positions of frames: interpolated only where something is known, and never across a gap or to another recording."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from insectnav.checks import InputError
from insectnav.datasets.frame_times import times_of_frames
from insectnav.datasets.positions import Positions, positions_of_frames, read_positions
from real_routes import DATA


def written(folder: Path, text: str, name: str = "positions.csv") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def at_times(*rows: tuple[float, float, float], **more) -> Positions:
    """Positions of rows of time, x and y."""
    time, x, y = np.array(rows, float).T
    return Positions(time=time, position=np.stack([x, y, 0 * x], axis=-1), **more)


def test_times_are_interpolated_linearly_and_not_beyond_the_ends():
    found = positions_of_frames(at_times((10, 0, 0), (11, 2, -4), (13, 2, 0)), times=[9.9, 10, 10.25, 11, 12, 13, 13.1])
    np.testing.assert_allclose(found[1:-1, :2], [(0, 0), (0.5, -1), (2, -4), (2, -2), (2, 0)])
    assert np.isnan(found[[0, -1]]).all()


def test_gaps_are_not_bridged_but_their_ends_are_known():
    positions = at_times((0, 0, 0), (3, 3, 0), (6.5, 6.5, 0))
    found = positions_of_frames(positions, times=[1.5, 3, 5, 6.5], max_gap_s=3)
    np.testing.assert_array_equal(found[:, 0], [1.5, 3, np.nan, 6.5])
    np.testing.assert_array_equal(positions_of_frames(positions, times=[5], max_gap_s=3.5)[:, 0], [5])


@pytest.mark.parametrize("start", [0, 1_399_379_412])  # on a clock from 1970 a tenth of a second is off by 1e-7
def test_a_gap_of_just_the_interval_is_bridged_whatever_the_rounding(start: int):
    time = np.array([float(f"{start + k // 10}.{k % 10}") for k in range(2000)])
    positions = at_times(*((one, k, 0) for k, one in enumerate(time)))
    found = positions_of_frames(positions, times=(time[1:] + time[:-1]) / 2, max_gap_s=0.1)
    np.testing.assert_allclose(found[:, 0], np.arange(1999) + 0.5, atol=1e-5)
    assert np.isnan(positions_of_frames(positions, times=time[[0, 3]] + [0, 0.05], max_gap_s=0.0999)[1, 0])


def test_segments_are_not_joined():
    positions = at_times((0, 0, 0), (1, 1, 0), (2, 9, 0), (3, 8, 0), segment=[0, 0, 1, 1])
    found = positions_of_frames(positions, times=[0.5, 1, 1.5, 2, 2.5])
    np.testing.assert_array_equal(found[:, 0], [0.5, 1, np.nan, 9, 8.5])


def test_rows_without_place_or_time_and_order_do_not_matter():
    positions = at_times((4, 4, 0), (0, 0, 0), (2, np.nan, 0), (np.nan, 7, 7), (1, 1, 0), (1, 99, 0), (3, 3, np.nan))
    found = positions_of_frames(positions, times=[0.5, 2, np.nan], max_gap_s=3)
    np.testing.assert_array_equal(found[:, 0], [0.5, 2, np.nan])  # of two at one time the first


moments = st.lists(st.integers(0, 60), min_size=2, max_size=12, unique=True).map(sorted)


@settings(max_examples=200, deadline=None)
@given(moments, st.lists(st.floats(0, 60), min_size=1, max_size=8), st.floats(0.5, 30))
def test_what_moves_evenly_is_found_where_it_is_or_not_at_all(known: list, asked: list, max_gap: float):
    known_time = np.array(known, float)
    positions = at_times(*np.stack([known_time, 3 * known_time - 5, -known_time], axis=-1))
    try:
        found = positions_of_frames(positions, times=asked, max_gap_s=max_gap)
    except InputError:
        return
    for time, place in zip(asked, found, strict=True):
        before, after = (
            known_time[known_time <= time].max(initial=-np.inf),
            known_time[known_time >= time].min(initial=np.inf),
        )
        assert np.isnan(place[0]) == (after - before > max_gap)
        if not np.isnan(place[0]):
            np.testing.assert_allclose(place, [3 * time - 5, -time, 0], atol=1e-9)


def test_names_match_without_folder_and_ending(tmp_path: Path):
    text = "file,x_m,y_m\nsub/a_1.png,1,2\na_2.JPG,3,4\n1403636579.763,5,6\n"
    positions = read_positions(written(tmp_path, text))
    found = positions_of_frames(positions, names=["/data/a_2.tif", "a_3.png", "1403636579.763.png", Path("x/a_1.png")])
    np.testing.assert_array_equal(found[:, 0], [3, np.nan, 5, 1])


def test_numbers_of_frames_match(tmp_path: Path):
    positions = read_positions(written(tmp_path, "frame;x_cm;y_cm\n10;100;-200\n20;300;400\n"))
    np.testing.assert_allclose(positions_of_frames(positions, frames=[20, 10, 15])[:2], [(3, 4, 0), (1, -2, 0)])
    assert np.isnan(positions_of_frames(positions, frames=[20, 15])[1]).all()


def test_table_of_rendered_frames_is_read_by_name_number_and_time(tmp_path: Path):
    header = "frame,file,x_m,y_m,z_m,heading_deg,pitch_deg,roll_deg,distance_m,time_s,foliage,light_utc\n"
    rows = "0,000000,1.0,2.0,0.3,90,0,0,0,0.0,1.0,\n1,000001,2.0,2.0,0.3,90,0,0,1,0.5,1.0,\n"
    positions = read_positions(written(tmp_path, header + rows))
    for key in ({"names": ["000001.png"]}, {"frames": [1]}, {"times": [0.5]}):
        np.testing.assert_array_equal(positions_of_frames(positions, **key), [(2, 2, 0.3)])


def test_latitude_and_longitude_become_metres(tmp_path: Path):
    text = "timestamp [ms],Latitude,Longitude,altitude_m\n1000,60,10,5\n2000,60.001,10,6\n"
    path = written(tmp_path, text)
    positions = read_positions(path)
    assert positions.origin_deg == (60, 10)
    np.testing.assert_array_equal(positions.time, [1, 2])
    np.testing.assert_allclose(positions.position, [(0, 0, 5), (0, 111.412, 6)], atol=1e-3)  # published, km in a degree
    moved = read_positions(path, origin_deg=(60.001, 10)).position
    np.testing.assert_allclose(moved[:, 1], [-111.412, 0], atol=1e-3)


def test_tracks_of_receivers_keep_their_segments(tmp_path: Path):
    point = '<trkpt lat="60.00{k}" lon="10"><time>2014-05-06T12:00:0{k}Z</time></trkpt>'
    inside = "".join(f"<trkseg>{point.format(k=k)}{point.format(k=k + 1)}</trkseg>" for k in (0, 2))
    positions = read_positions(written(tmp_path, f"<gpx><trk>{inside}</trk></gpx>", "any.csv"))
    assert positions.origin_deg == (60, 10)
    start = positions.time[0]
    found = positions_of_frames(positions, times=start + np.array([0.5, 1.5, 2.5]))
    np.testing.assert_allclose(found[:, 1], [55.706, np.nan, 278.53], atol=1e-2)
    assert (positions.position[:, 2] == 0).all()  # no height in the file


@pytest.mark.parametrize(
    ("text", "columns", "says"),
    [
        ("time_s,x_m\n1,2\n", None, "no columns of a position .* 'x_m', expected x_m and y_m"),
        ("time_s,x,y\n1,2,3\n", None, "which unit is 'x' in?"),
        ("x_m,y_m\n1,2\n", None, "no column of a time or a frame"),
        ("time,x_m,y_m\n1,2,3\n", None, "which unit is 'time' in?"),
        ("65.7,138.0,-44.4\n98.6,137.6,-42.6\n", None, "does the table lack its header?"),
        ("65.7,138.0,-44.4\n", ("time_ms", "x_cm"), "row 1 has 3 cells, expected 2"),
        ("time_s,x_m,y_m\n2,0,0\n1,0,0\n", None, "row 3: the time goes back"),
        ("time_s,x_m,y_m\n,0,0\n", None, "row 2: the time is missing"),
        ("frame,x_m,y_m\n1.5,0,0\n", None, "fractions"),
        ("time_s,x_m,x_cm,y_m\n1,2,3,4\n", None, "both 'x_m' and 'x_cm'"),
        ("time_s,x_m,y_cm\n1,2,3\n", None, "x and y differ in unit"),
        ("time_s,lat,lon\n1,513000,181000\n", None, "latitude reaches 513000"),
        ("time_s,x_m,y_m\n1,5e7,0\n", None, "another unit"),
        ("time_s,x_m,y_m\n1;2;3\n", None, "cells"),
    ],
)
def test_tables_that_cannot_be_meant_are_refused(text: str, columns: tuple | None, says: str, tmp_path: Path):
    path = written(tmp_path, text)
    with pytest.raises(InputError, match=says) as error:
        read_positions(path, columns=columns)
    assert "positions.csv" in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("key", "says"),
    [
        ({}, "nothing given, expected one of"),
        ({"times": [1.0], "frames": [1]}, "times and frames given"),
        ({"names": ["a.png"]}, "no names of frames"),
        ({"frames": [1]}, "no numbers of frames"),
        ({"times": [1000.0, 2500.0]}, "seconds against milliseconds"),
        ({"times": [1e9 + 1]}, "from 1970: which offset"),
        ({"times": [7000.0]}, "time zones"),
        ({"times": [np.nan]}, "no time of the frames is known"),
        ({"times": [1.5], "max_gap_s": 0.5}, "mostly are 1 s apart.*milliseconds taken as seconds, or raise"),
        ({"times": [[1.0]]}, "shape"),
        ({"times": [1.0], "max_gap_s": -1}, "longest gap"),
    ],
)
def test_frames_that_cannot_belong_are_refused(key: dict, says: str):
    with pytest.raises(InputError, match=says):
        positions_of_frames(at_times((1, 0, 0), (2, 1, 0), (3, 2, 0)), **key)


def test_frames_of_another_recording_and_doubtful_tables_are_refused(tmp_path: Path):
    positions = read_positions(written(tmp_path, "file,x_m,y_m\na,1,2\nb,1,2\n"))
    with pytest.raises(InputError, match="no frame has a name of the positions, such as 'c' here and 'a' there"):
        positions_of_frames(positions, names=["c.png"])
    positions = read_positions(written(tmp_path, "file,x_m,y_m\na,1,2\na.png,1,2\n"))
    assert positions_of_frames(positions, names=["a"])[0, 0] == 1
    positions = read_positions(written(tmp_path, "file,x_m,y_m\na,1,2\na,5,2\n"))
    with pytest.raises(InputError, match="two positions"):
        positions_of_frames(positions, names=["a"])


def test_positions_are_checked_copies():
    time = np.array([1.0, 2.0])
    positions = Positions(position=np.zeros((2, 3)), time=time)
    time[0] = 9
    assert positions.time[0] == 1
    with pytest.raises(ValueError, match="read-only"):
        positions.position[0] = 1
    with pytest.raises(InputError, match="neither times"):
        Positions(position=np.zeros((2, 3)))
    with pytest.raises(InputError, match="1 names, expected 2"):
        Positions(position=np.zeros((2, 3)), name=("a",))


@pytest.mark.data
@pytest.mark.parametrize(
    ("kind", "times", "tracking", "max_gap_s", "n_frames", "n_known"),
    [
        ("snapshot", "training.csv", "training_path_scaled.csv", 0.1, 455, 455),
        ("test", "testing_infomax.csv", "testing_path_infomax_scaled.csv", 0.1, 102, 36),  # while the robot was tracked
        (
            "test",
            "testing_infomax.csv",
            "testing_path_infomax_scaled.csv",
            22.0,
            102,
            94,
        ),  # across losses of up to 21.4 s
    ],
)
def test_robot_in_sussex(kind: str, times: str, tracking: str, max_gap_s: float, n_frames: int, n_known: int):
    folder = DATA / "sussex_route"
    if not folder.exists():
        pytest.skip(f"{folder} is missing")
    taken = times_of_frames(folder / times, names=[f"{kind}_{k}.png" for k in range(n_frames)])
    positions = read_positions(folder / tracking, columns=("time_ms", "x_cm", "y_cm"))
    found = positions_of_frames(positions, times=taken, max_gap_s=max_gap_s)
    known = np.isfinite(found[:, 0])
    assert known.sum() == n_known
    track = np.loadtxt(folder / tracking, delimiter=",")
    for axis in (0, 1):
        wanted = np.interp(taken[known] * 1000, track[:, 0], track[:, 1 + axis]) / 100
        np.testing.assert_allclose(found[known, axis], wanted, atol=1e-9)
