"""Tables of poses: what is read, what is filled in, and that a table that was written comes back to the last bit."""

import csv
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from insectnav.checks import InputError
from insectnav.datasets.pose_table import as_tabled, pose_columns, read_poses
from insectnav.datasets.tracks import read_track
from insectnav.records import Poses


def written(folder: Path, text: str) -> Path:
    path = folder / "poses.csv"
    path.write_text(text)
    return path


def test_all_columns_are_read_in_their_units(tmp_path: Path):
    text = "x_cm,note,y_cm,z_m,heading_deg,pitch_rad,roll_deg,time_s,distance_m\n"
    text += "100,7,200,0.3,90,0.1,-5,2,10\n110,7,200,0.3,-170,0.1,-5,3,12\n"
    poses, has_height = read_poses(written(tmp_path, text), speed=1.0)
    assert has_height
    np.testing.assert_allclose(poses.position, [(1.0, 2.0, 0.3), (1.1, 2.0, 0.3)])
    np.testing.assert_allclose(poses.heading, np.deg2rad([90, -170]))
    np.testing.assert_allclose(poses.pitch, 0.1)
    np.testing.assert_allclose(poses.roll, np.deg2rad(-5))
    np.testing.assert_array_equal(poses.time, [2, 3])
    np.testing.assert_array_equal(poses.distance, [10, 12])


def test_what_a_table_lacks_follows_from_its_positions(tmp_path: Path):
    poses, has_height = read_poses(written(tmp_path, "x_m,y_m\n0,0\n0,3\n0,3\n4,3\n"), speed=2.0)
    assert not has_height
    np.testing.assert_allclose(np.rad2deg(poses.heading), [0, 90, 90, 90])  # onwards to the next other place
    np.testing.assert_array_equal(poses.distance, [0, 3, 3, 7])
    np.testing.assert_array_equal(poses.time, [0, 1.5, 1.5, 3.5])
    np.testing.assert_array_equal(poses.pitch, 0)


angles = st.floats(-np.pi, np.pi - 1e-3)
rows = st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), st.floats(0.01, 9.0), angles, angles, angles)


@settings(max_examples=50, deadline=None)
@given(st.lists(rows, min_size=1, max_size=6))
def test_written_table_comes_back_to_the_last_bit(tmp_path_factory: pytest.TempPathFactory, values: list):
    columns = np.array(values).T
    steps = np.arange(len(values)) / 3
    poses = Poses(
        position=columns[:3].T, heading=columns[3], pitch=columns[4], roll=columns[5], distance=steps, time=steps
    )
    path = tmp_path_factory.mktemp("table") / "poses.csv"
    table = {name: column.tolist() for name, column in pose_columns(poses).items()}
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(table)
        writer.writerows(zip(*table.values(), strict=True))
    found, has_height = read_poses(path, speed=1.0)
    assert has_height
    for name in ("position", "heading", "pitch", "roll", "distance", "time"):
        np.testing.assert_array_equal(getattr(found, name), getattr(as_tabled(poses), name))
        np.testing.assert_allclose(getattr(found, name), getattr(poses, name), atol=1e-6)


def test_written_table_is_a_track(tmp_path: Path):
    steps = np.arange(12.0)
    nothing = np.zeros(12)
    poses = Poses(position=np.stack([steps, 2 * steps, nothing], axis=-1), heading=nothing, pitch=nothing, roll=nothing,
                  distance=steps, time=0.5 * steps)  # fmt: skip
    table = {name: column.tolist() for name, column in pose_columns(poses).items()}
    lines = [",".join(table), *(",".join(map(repr, row)) for row in zip(*table.values(), strict=True))]
    track = read_track(written(tmp_path, "\n".join(lines) + "\n"))
    np.testing.assert_array_equal(track.position, poses.position[:, :2])
    np.testing.assert_array_equal(track.time, poses.time)
    assert (track.length_unit, track.time_unit) == ("m", "s")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x,y\n1,2\n", "which unit is 'x' in?"),
        ("x_m\n1\n", "no column for y among 'x_m'"),
        ("1,2\n3,4\n", "does the table lack its header?"),
        ("x_m y_m\n1 2\n", "is the separator"),
        ("x_m,y_cm\n1,2\n", "x and y differ in unit"),
        ("x_m,x_cm,y_m\n1,2,3\n", "both 'x_m' and 'x_cm' could be the x column"),
        ("x_m,y_m\n1,2\n1,\n", "row 3, column 'y_m': the y is missing"),
        ("x_m,y_m\n1,a\n", "'a' is not a number"),
        ("x_m,y_m,heading_rad\n1,2,90\n", "degrees?"),
        ("x_m,y_m,heading_deg\n1,2,900\n", "another unit"),
        ("x_m,y_m,time_s\n1,2,5\n1,3,4\n", "row 3, column 'time_s': the time goes back from 5 to 4"),
        ("x_m,y_m\n1,2\n1,2\n", "expected a column heading_deg where the camera does not move"),
        ("x_m,y_m\n", "holds only a header"),
    ],
)
def test_bad_table_is_refused_in_one_sentence(text: str, words: str, tmp_path: Path):
    path = written(tmp_path, text)
    with pytest.raises(InputError) as refused:
        read_poses(path, speed=1.0)
    assert words in str(refused.value)
    assert str(path.name) in str(refused.value)
    assert "\n" not in str(refused.value)
