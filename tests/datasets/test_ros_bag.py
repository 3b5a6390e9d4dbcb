"""Bags of ROS 1 and 2, written by rosbags: pictures, positions, the choice of a topic, and bags that mean harm."""

import sqlite3
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from insectnav.checks import InputError
from insectnav.datasets.ros_bag import bag_frames, bag_images, bag_positions, bag_topics
from robot_bags import KINDS, PACKED, PICTURE, ROS1, ROS2, Messages, bag, camera, rosbag1, typesys, walk


@pytest.mark.parametrize("kind", KINDS)
def test_topics_pictures_and_positions(kind: str, tmp_path: Path):
    path = bag(tmp_path, kind, {"/camera": camera, "/odometry": walk})
    found = [(topic.name, topic.kind, topic.n_messages) for topic in bag_topics(path)]
    assert found == [("/camera", "sensor_msgs/msg/Image", 3), ("/odometry", "nav_msgs/msg/Odometry", 4)]
    pictures = list(bag_images(path))
    np.testing.assert_allclose([time for time, _ in pictures], [10.5, 11.5, 12.5])
    np.testing.assert_array_equal(pictures[2][1], PICTURE + 2)
    assert [time for time, _ in bag_images(path, "/camera", clock="bag")] == [2, 3, 4]
    positions = bag_positions(path)
    np.testing.assert_array_equal(positions.time, [10, 11, 12, 13])
    np.testing.assert_array_equal(positions.position, [(k, 2, 0.5) for k in range(4)])
    assert positions.origin_deg is None


@pytest.mark.parametrize("kind", KINDS)
def test_fixes_become_metres_and_what_is_no_fix_is_left_out(kind: str, tmp_path: Path):
    def fixes(messages: Messages) -> list:
        return [
            messages.fix(3.0, 60.001, 10.0, 30.0),
            messages.fix(1.0, 60.0, 10.0, np.nan),
            messages.fix(2.0, 0.0, 0.0, 0.0, status=-1),
            messages.fix(4.0, np.nan, 10.0, 30.0),
            messages.fix(0.0, np.nan, np.nan, np.nan, status=-1),  # before it knows the time, either
        ]

    positions = bag_positions(bag(tmp_path, kind, {"/fix": fixes}))
    np.testing.assert_array_equal(positions.time, [1, 3])
    np.testing.assert_allclose(positions.position, [(0, 0, np.nan), (0, 111.412, 30)], atol=1e-3)
    assert positions.origin_deg == (60, 10)
    assert positions.notes[0] == "messages left out, no fix: 3"
    assert (
        bag_positions(tmp_path / ("walk.bag" if kind == ROS1 else "walk"), origin_deg=(60.001, 10)).position[1, 1] == 0
    )


def test_poses(tmp_path: Path):
    path = bag(tmp_path, ROS2, {"/pose": lambda messages: [messages.stamped(1.0, 1.0, 2.0, 3.0)]})
    np.testing.assert_array_equal(bag_positions(path).position, [(1, 2, 3)])


DEEP = np.array([[1, 256, 65535]], "<u2")


@pytest.mark.parametrize(
    ("encoding", "lines", "columns", "more", "expected"),
    [
        ("mono8", PICTURE[..., 0], 4, {}, PICTURE[..., 0]),
        ("mono8", PICTURE[..., 0], 3, {}, PICTURE[:, :3, 0]),  # rows longer than their pixels
        ("rgb8", PICTURE.reshape(2, 12), 4, {}, PICTURE),
        ("bgr8", PICTURE.reshape(2, 12), 4, {}, PICTURE[..., ::-1]),
        ("bgra8", PICTURE.reshape(2, 12), 3, {}, PICTURE.reshape(2, 3, 4)[..., [2, 1, 0]]),
        ("mono16", DEEP.view(np.uint8), 3, {}, DEEP),
        ("mono16", DEEP.view(np.uint8), 3, {"is_bigendian": 1}, DEEP.byteswap()),
    ],
)
def test_encodings(encoding: str, lines: np.ndarray, columns: int, more: dict, expected: np.ndarray, tmp_path: Path):
    lines = np.ascontiguousarray(lines)
    path = bag(tmp_path, ROS1, {"/camera": lambda messages: [messages.image(1.0, encoding, lines, columns, **more)]})
    ((_, picture),) = bag_images(path)
    np.testing.assert_array_equal(picture, expected)
    assert picture.dtype == (np.uint16 if encoding == "mono16" else np.uint8)


@pytest.mark.parametrize("kind", KINDS)
def test_compressed_pictures(kind: str, tmp_path: Path):
    smooth = np.full((16, 16, 3), (200, 100, 50), np.uint8)
    make = lambda messages: [messages.compressed(1.0, ending, smooth) for ending in ("png", "jpg")]  # noqa: E731
    first, second = (picture for _, picture in bag_images(bag(tmp_path, kind, {"/camera": make})))
    np.testing.assert_array_equal(first, smooth)
    np.testing.assert_allclose(second, smooth, atol=3)


@pytest.mark.parametrize(
    ("form", "is_exchanged"),
    [
        ("jpeg", False),
        ("png", False),
        ("rgb8; jpeg compressed bgr8", False),
        ("bgr8; jpeg compressed bgr8", False),
        ("rgb8; jpeg compressed", True),  # as compressed_image_transport wrote up to 1.8.4
        ("bgr8; jpeg compressed ", True),
        ("rgba8; png compressed rgb8", True),
        ("rgb8; jpeg compressed rgb8", True),
        ("mono8; jpeg compressed ", False),
    ],
)
def test_old_formats_of_compressed_pictures_have_red_and_blue_exchanged(form: str, is_exchanged: bool, tmp_path: Path):
    """As the reader of ROS has it: what OpenCV's decoder calls blue, green, red is red, green, blue in these."""

    def make(messages: Messages) -> list:
        messages_made = [messages.compressed(1.0, "png", PICTURE)]
        messages_made[0].format = form
        return messages_made

    (frame,) = bag_frames(bag(tmp_path, ROS1, {"/camera": make}))
    np.testing.assert_array_equal(frame.read(), PICTURE[..., ::-1] if is_exchanged else PICTURE)
    assert (repr(form.strip()) in frame.remark or repr(form) in frame.remark) == is_exchanged


def test_compressed_raw_data_of_a_colour_sensor_are_refused_unless_demosaiced(tmp_path: Path):
    def make(messages: Messages) -> list:
        pictures = [messages.compressed(k + 1.0, "png", one) for k, one in enumerate((PICTURE, PICTURE[..., 0]))]
        pictures[0].format, pictures[1].format = "bayer_rggb8; png compressed bgr8", "bayer_rggb8; png compressed "
        return pictures

    first, second = bag_frames(bag(tmp_path, ROS2, {"/camera": make}))
    np.testing.assert_array_equal(first.read(), PICTURE)
    with pytest.raises(InputError, match="message 1 of '/camera' in 'walk' is raw data of a colour sensor"):
        second.read()


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda m: [m.image(1.0, "bayer_rggb8", PICTURE[..., 0].copy(), 4)], "colour sensor .'bayer_rggb8'"),
        (lambda m: [m.image(1.0, "32FC1", PICTURE.reshape(2, 12), 3)], "encoding '32FC1', expected one of mono8"),
        (lambda m: [m.image(1.0, "rgb8", PICTURE.reshape(2, 12), 5)], "rows of 12, expected 2 rows of at least 15"),
        (lambda m: [m.image(1.0, "rgb8", PICTURE.reshape(2, 12), 4, height=3)], "24 bytes"),
        (lambda m: [m.image(1.0, "rgb8", PICTURE.reshape(2, 12), 4, height=0)], "0 × 4 pixels"),
        (lambda m: [m.image(1.0, "mono8", PICTURE.reshape(2, 12), 2**31, height=2**31)], "pixels"),
        (lambda m: [m.image(0.0, "rgb8", PICTURE.reshape(2, 12), 4)], 'expected one: --clock bag, clock="bag"'),
        (
            lambda m: [m.make("sensor_msgs/msg/CompressedImage", header=m.header(1.0), format="h264",
                              data=np.zeros(9, np.uint8))],
            "no PNG, JPEG or TIFF",
        ),
    ],
)  # fmt: skip
def test_pictures_that_cannot_be_decoded_are_refused(make, says: str, tmp_path: Path):
    with pytest.raises(InputError, match=says) as error:
        list(bag_images(bag(tmp_path, ROS1, {"/camera": make})))
    assert "message 0 of '/camera' in 'walk.bag'" in str(error.value)


@pytest.mark.parametrize("kind", KINDS)
def test_one_of_several_topics_is_to_be_chosen(kind: str, tmp_path: Path):
    path = bag(tmp_path, kind, {"/left": camera, "/right": camera, "/odometry": walk})
    with pytest.raises(InputError, match=r"2 topics of pictures, expected a choice of one: /left \(Image, 3\), /right"):
        list(bag_images(path))
    assert len(list(bag_images(path, "/right"))) == 3
    with pytest.raises(InputError, match="no topic '/centre' of pictures, expected one of /left"):
        list(bag_images(path, "/centre"))
    with pytest.raises(InputError, match="no topic '/left' of positions"):
        bag_positions(path, "/left")


def test_bag_without_such_topics_names_the_others(tmp_path: Path):
    path = bag(tmp_path, ROS1, {"/odometry": walk})
    with pytest.raises(InputError, match="no pictures, expected a topic of Image, CompressedImage among '/odometry'"):
        list(bag_images(path))
    empty = tmp_path / "empty.bag"
    with rosbag1.Writer(empty):
        pass
    with pytest.raises(InputError, match="no topic"):
        bag_positions(empty)


@pytest.mark.parametrize("kind", KINDS)
def test_a_damaged_picture_does_not_end_those_that_follow(kind: str, tmp_path: Path):
    def make(messages: Messages) -> list:
        whole = [messages.compressed(10.0 + k, "png", PICTURE + np.uint8(k)) for k in range(3)]
        whole[1].data = whole[1].data[:-20]
        return whole

    path = bag(tmp_path, kind, {"/camera": make})
    frames = list(bag_frames(path))
    assert [frame.time for frame in frames] == [10.0, 11.0, 12.0]
    np.testing.assert_array_equal(frames[0].read(), PICTURE)
    np.testing.assert_array_equal(frames[2].read(), PICTURE + 2)
    with pytest.raises(InputError, match=r"^message 1 of '/camera' in .* ends before its picture does"):
        frames[1].read()
    with pytest.raises(InputError, match="message 1 of"):
        list(bag_images(path))


def test_a_damaged_message_is_a_picture_at_an_unknown_time(tmp_path: Path):
    path = bag(tmp_path, ROS2, {"/camera": camera})
    with sqlite3.connect(next(path.glob("*.db3"))) as store:
        store.execute("UPDATE messages SET data = substr(data, 1, 30) WHERE id = 2")
    frames = list(bag_frames(path))
    np.testing.assert_array_equal([frame.time for frame in frames], [10.5, np.nan, 12.5])
    assert [frame.time for frame in bag_frames(path, clock="bag")] == [2, 3, 4]
    np.testing.assert_array_equal(frames[2].read(), PICTURE + 2)
    with pytest.raises(InputError, match=r"^message 1 of '/camera' in 'walk' cannot be decoded"):
        frames[1].read()


def test_message_of_another_definition_is_refused(tmp_path: Path):
    store = typesys.get_typestore(typesys.Stores.EMPTY)
    store.register(typesys.get_types_from_msg("float64 y\nfloat64 x", "nav_msgs/msg/Odometry"))
    path = tmp_path / "a.bag"
    with rosbag1.Writer(path) as writer:
        writer.add_connection("/odometry", "nav_msgs/msg/Odometry", typestore=store)
    with pytest.raises(InputError, match="defines nav_msgs/msg/Odometry otherwise than ROS"):
        bag_positions(path)


@pytest.mark.parametrize(
    ("name", "data", "says"),
    [
        ("a.bag", b"", "cannot be read as a bag"),
        ("a.bag", b"#ROSBAG V1.2\n", "version 102"),
        ("a.bag", b"PK\x03\x04" * 50, "magic"),
        ("a.mcap", bytes(100), "cannot be read as a bag"),
        ("a.db3", bytes(100), "cannot be read as a bag"),
        ("a.csv", b"time_s,x_m", "cannot be read as a bag"),
    ],
)
def test_other_files_are_refused(name: str, data: bytes, says: str, tmp_path: Path):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match=says) as error:
        bag_topics(tmp_path / name)
    assert "\n" not in str(error.value)


def test_missing_bags_and_folders_that_are_none_are_refused(tmp_path: Path):
    with pytest.raises(InputError, match="does not exist"):
        bag_topics(tmp_path / "absent.bag")
    with pytest.raises(InputError, match="cannot be read as a bag"):
        bag_topics(tmp_path)
    (tmp_path / "metadata.yaml").write_text("rosbag2_bagfile_information: {version: 99}")
    with pytest.raises(InputError, match="cannot be read as a bag"):
        bag_topics(tmp_path)


def test_without_the_extra_the_error_names_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "a.bag").write_bytes(b"")
    monkeypatch.setitem(sys.modules, "rosbags", None)
    with pytest.raises(InputError, match=r"pip install insectnav\[robot\]"):
        bag_topics(tmp_path / "a.bag")


DAMAGED = {kind: (kind, None) for kind in KINDS} | {f"packed by {mode.name}": (ROS2, mode) for mode in PACKED}


@pytest.fixture(scope="module")
def whole_bags(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Path, Path]]:
    """A sound bag of each kind and its file, with a copy beside it."""
    found = {}
    for name, (kind, mode) in DAMAGED.items():
        path = bag(tmp_path_factory.mktemp("bag"), kind, {"/camera": camera, "/odometry": walk}, mode)
        file = path if kind == ROS1 else next(one for one in path.iterdir() if one.suffix in (".mcap", ".db3", ".zstd"))
        file.with_suffix(".whole").write_bytes(file.read_bytes())
        found[name] = path, file
    return found


@settings(max_examples=100, deadline=None)
@given(
    kind=st.sampled_from(sorted(DAMAGED)), share=st.floats(0, 1), length=st.integers(0, 40), other=st.binary(max_size=8)
)
def test_damaged_bag_is_read_or_refused_but_never_fails_otherwise(
    whole_bags: dict, kind: str, share: float, length: int, other: bytes
):
    path, file = whole_bags[kind]
    whole = file.with_suffix(".whole").read_bytes()
    start = int(share * (len(whole) - 1))
    file.write_bytes(whole[:start] + other + whole[start + length :])
    for read in (bag_positions, lambda bag: list(bag_images(bag))):
        try:
            read(path)
        except InputError as error:
            assert "\n" not in str(error)
