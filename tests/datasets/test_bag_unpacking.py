"""Compressed parts of bags: read within bounds, refused beyond, and nothing stays behind."""

import bz2
import tempfile
from pathlib import Path

import numpy as np
import pytest

from command_line import everything
from insectnav.checks import InputError
from insectnav.datasets import bag_unpacking
from insectnav.datasets.ros_bag import bag_frames, bag_images, bag_positions, bag_topics
from robot_bags import MCAP, PACKED, PICTURE, ROS1, ROS2, bag, camera, rosbag1, rosbag2, walk


@pytest.mark.parametrize("compression", list(rosbag1.Writer.CompressionFormat))
def test_compressed_chunks_are_unpacked(compression, tmp_path: Path):
    path = bag(tmp_path, ROS1, {"/odometry": walk}, compression)
    assert len(bag_positions(path).time) == 4


@pytest.mark.parametrize("compression", list(rosbag1.Writer.CompressionFormat))
def test_chunks_that_unpack_beyond_bounds_are_refused(compression, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    path = bag(tmp_path, ROS1, {"/odometry": walk}, compression)
    monkeypatch.setattr(bag_unpacking, "MAX_CHUNK", 1000)
    with pytest.raises(InputError, match="unpacks to more than"):
        bag_positions(path)


def test_bound_stops_unpacking_early():
    bomb = bz2.compress(bytes(10**7))
    seen = []

    def unpack(data: bytes, most: int) -> bytes:
        seen.append(bz2.BZ2Decompressor().decompress(data, most))
        return seen[0]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bag_unpacking, "MAX_CHUNK", 1000)
        with pytest.raises(InputError, match="unpacks to more"):
            bag_unpacking._within(unpack, bomb)
    assert len(seen[0]) == 1001


@pytest.mark.parametrize("mode", PACKED)
@pytest.mark.parametrize("kind", [ROS2, MCAP])
def test_folders_with_compressed_files_or_messages_are_read(mode, kind: str, tmp_path: Path):
    path = bag(tmp_path, kind, {"/camera": camera, "/odometry": walk}, mode)
    before = everything(tmp_path)
    found = [(topic.name, topic.kind, topic.n_messages) for topic in bag_topics(path)]
    assert found == [("/camera", "sensor_msgs/msg/Image", 3), ("/odometry", "nav_msgs/msg/Odometry", 4)]
    pictures = list(bag_images(path))
    np.testing.assert_allclose([time for time, _ in pictures], [10.5, 11.5, 12.5])
    np.testing.assert_array_equal([picture for _, picture in pictures], [PICTURE + k for k in range(3)])
    np.testing.assert_array_equal(bag_positions(path).position, [(k, 2, 0.5) for k in range(4)])
    assert everything(tmp_path) == before


def test_files_that_unpack_beyond_bounds_are_refused_and_nothing_stays(tmp_path: Path, monkeypatch):
    path = bag(tmp_path, ROS2, {"/odometry": walk}, rosbag2.CompressionMode.FILE)
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    monkeypatch.setattr(bag_unpacking, "MAX_UNPACKED", 10_000)
    with pytest.raises(InputError, match="'walk' unpacks to more than there is room for"):
        bag_positions(path)
    assert not everything(temporary)


def test_messages_that_unpack_beyond_bounds_are_refused(tmp_path: Path, monkeypatch):
    path = bag(tmp_path, ROS2, {"/camera": camera, "/odometry": walk}, rosbag2.CompressionMode.MESSAGE)
    monkeypatch.setattr(bag_unpacking, "MAX_CHUNK", 60)
    with pytest.raises(InputError, match="message 0 of '/odometry' in 'walk' unpacks to more than"):
        bag_positions(path)
    frames = list(bag_frames(path))
    assert len(frames) == 3
    with pytest.raises(InputError, match="message 2 of '/camera' in 'walk' unpacks to more than"):
        frames[2].read()


def test_folders_compressed_in_another_way_are_refused(tmp_path: Path):
    path = bag(tmp_path, ROS2, {"/odometry": walk}, rosbag2.CompressionMode.FILE)
    about = path / "metadata.yaml"
    about.write_text(about.read_text().replace("zstd", "lz77"))
    with pytest.raises(InputError, match=r"'walk' is compressed by 'lz77', expected zstd, .*ros2 bag convert unpacks"):
        bag_positions(path)


def test_names_of_compressed_files_lead_nowhere_else(tmp_path: Path):
    path = bag(tmp_path, ROS2, {"/odometry": walk}, rosbag2.CompressionMode.FILE)
    file = next(path.glob("*.zstd"))
    (tmp_path / "elsewhere.db3.zstd").write_bytes(file.read_bytes())
    about = path / "metadata.yaml"
    about.write_text(about.read_text().replace(file.name, "../elsewhere.db3.zstd"))
    with pytest.raises(InputError, match="cannot be read as a bag"):
        bag_positions(path)
