"""Pictures and positions of robots from bags of ROS 1 and ROS 2, with the extra `robot`.

Of the messages in a bag only the five types below are decoded, by the definitions that come with rosbags; definitions
that a bag brings along are not compiled.
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, check_choice, quoted
from insectnav.datasets.bag_pictures import is_exchanged, picture_of
from insectnav.datasets.bag_unpacking import bound_chunks, unpacked_folder, unpacker_of_messages
from insectnav.datasets.gps import local_plane
from insectnav.datasets.gps_track import MAX_FIXES
from insectnav.datasets.positions import Positions

IMAGES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
PLACES = ("sensor_msgs/msg/NavSatFix", "nav_msgs/msg/Odometry", "geometry_msgs/msg/PoseStamped")
CLOCKS = STAMP, ARRIVAL = ("stamp", "bag")
MAX_MESSAGE = 512 * 2**20  # bytes
NO_FIX = -1  # sensor_msgs/NavSatStatus


@dataclass(frozen=True, kw_only=True)
class BagTopic:
    """A topic that can be read: its name, the type of its messages, and how many there are."""

    name: str
    kind: str
    n_messages: int


def bag_topics(path: str | PathLike[str]) -> tuple[BagTopic, ...]:
    """Topics of a bag that hold pictures or positions, by name.

    Parameters
    ----------
    path : a file .bag of ROS 1, or the folder (or the file .mcap or .db3) of ROS 2

    Raises
    ------
    InputError
        If it is no bag.
    """
    with _opened(Path(path)) as bag:
        return tuple(sorted(bag.topics(IMAGES + PLACES), key=lambda topic: topic.name))


def bag_images(
    path: str | PathLike[str], topic: str | None = None, *, clock: str = "stamp"
) -> Iterator[tuple[float, NDArray[Any]]]:
    """Time [s] and picture, (rows, columns) or (rows, columns, 3) red, green, blue, of each image in order of the bag.

    Parameters
    ----------
    path : a file .bag of ROS 1, or the folder (or the file .mcap or .db3) of ROS 2
    topic : of sensor_msgs/Image (mono8, mono16, rgb8, bgr8, rgba8, bgra8) or CompressedImage; None takes the only one
    clock : "stamp" for the time that the camera's driver wrote into the message, "bag" for that of its arrival

    Raises
    ------
    InputError
        If it is no bag, the topic is not there or not alone, or a picture cannot be decoded.
    """
    for frame in bag_frames(path, topic, clock=clock):
        yield frame.time, frame.read()


@dataclass(frozen=True, kw_only=True, eq=False)
class BagFrame:
    """A picture of a bag that is still to be decoded.

    Parameters
    ----------
    time : [s]; NaN where the message that holds it cannot be decoded
    read : gives the picture as `bag_images` does; raises InputError where it is damaged
    remark : what a person must know of how it is decoded; empty where there is nothing to say
    """

    time: float
    read: Callable[[], NDArray[Any]]
    remark: str = ""


def bag_frames(path: str | PathLike[str], topic: str | None = None, *, clock: str = "stamp") -> Iterator[BagFrame]:
    """Images in order of the bag, of which a damaged one does not end those that follow.

    Parameters
    ----------
    path, topic, clock : as of `bag_images`

    Raises
    ------
    InputError
        If it is no bag, is damaged but for the messages in it, or the topic is not there or not alone.
    """
    check_choice("clock", clock, CLOCKS)
    with _opened(Path(path)) as bag:
        for sealed in bag.sealed_messages(topic, IMAGES, "pictures"):
            try:
                message = sealed.open()
            except InputError as error:
                yield BagFrame(time=sealed.arrival if clock == ARRIVAL else np.nan, read=partial(_refuse, str(error)))
            else:
                yield BagFrame(
                    time=sealed.time(message, clock),
                    read=partial(picture_of, message, sealed.name),
                    remark=_remark(message),
                )


def _remark(message: Any) -> str:
    if not is_exchanged(message):
        return ""
    return (
        f"red and blue are exchanged in pictures of the format {quoted(message.format)}, as compressed_image_transport "
        "reads them: where the sky is not blue then, another program wrote them"
    )


def _refuse(sentence: str) -> NDArray[Any]:
    raise InputError(sentence)


def bag_positions(
    path: str | PathLike[str],
    topic: str | None = None,
    *,
    clock: str = "stamp",
    origin_deg: tuple[float, float] | None = None,
) -> Positions:
    """Positions of a topic in order of time.

    Parameters
    ----------
    path : a file .bag of ROS 1, or the folder (or the file .mcap or .db3) of ROS 2
    topic : of sensor_msgs/NavSatFix (without a fix it is left out), nav_msgs/Odometry or geometry_msgs/PoseStamped,
        whose x, y and z are taken as they are; None takes the only one
    clock : "stamp" for the time that the driver wrote into the message, "bag" for that of its arrival
    origin_deg : latitude and longitude of (0, 0) for NavSatFix; None takes the first fix

    Raises
    ------
    InputError
        If it is no bag, the topic is not there or not alone, or it holds no position.
    """
    check_choice("clock", clock, CLOCKS)
    times: list[float] = []
    places: list[tuple[float, float, float]] = []
    n_without = 0
    is_global = False
    with _opened(Path(path)) as bag:
        for sealed in bag.sealed_messages(topic, PLACES, "positions"):
            message = sealed.open()
            is_global = hasattr(message, "latitude")
            place = _place(message)
            if place is None:
                n_without += 1
                continue
            times.append(sealed.time(message, clock))
            places.append(place)
            if len(times) > MAX_FIXES:
                raise InputError(f"the topic holds more than {MAX_FIXES} positions, expected a single recording")
    if not times:
        raise InputError(f"{quoted(path, 200)}: none of {n_without} messages holds a position, expected some")
    order = np.argsort(times, kind="stable")
    when, where = np.array(times)[order], np.array(places)[order]
    notes = [f"messages left out, no fix: {n_without}"] if n_without else []
    if not is_global:
        return Positions(position=where, time=when, notes=tuple(notes))
    height = where[:, 2] if np.isfinite(where[:, 2]).any() else None
    if height is not None:
        notes.append("heights are above the ellipsoid, which may be 100 m off the level of the sea")
    position, origin = local_plane(where[:, 0], where[:, 1], height, origin_deg)
    return Positions(position=position, time=when, origin_deg=origin, notes=tuple(notes))


def _place(message: Any) -> tuple[float, float, float] | None:
    """Latitude, longitude and height, or x, y and z; None where nothing was measured."""
    if hasattr(message, "latitude"):
        place = (message.latitude, message.longitude, message.altitude)
        return place if message.status.status > NO_FIX and np.isfinite(place[:2]).all() else None
    pose = getattr(message.pose, "pose", message.pose)  # of odometry it comes with its covariance
    place = (pose.position.x, pose.position.y, pose.position.z)
    return place if np.isfinite(place[:2]).all() else None


@dataclass(frozen=True, kw_only=True, eq=False)
class _Sealed:
    """A message as it is stored, its name in a sentence, and when it arrived [s]."""

    data: bytes
    name: str
    arrival: float
    decode: Callable[[bytes], Any]

    def open(self) -> Any:
        """The message decoded; InputError where it is damaged."""
        if len(self.data) > MAX_MESSAGE:
            raise InputError(f"{self.name} has {len(self.data)} bytes, expected at most {MAX_MESSAGE}")
        try:
            return self.decode(self.data)
        except InputError as error:
            raise InputError(f"{self.name} {error}") from None
        except Exception as error:  # damage makes rosbags raise errors of many classes
            raise InputError(f"{self.name} cannot be decoded ({_reason(error)}): damaged?") from error

    def time(self, message: Any, clock: str) -> float:
        """When it was sent, or arrived [s]."""
        stamp = message.header.stamp
        if clock == STAMP and stamp.sec == 0 and stamp.nanosec == 0:
            raise InputError(
                f'{self.name} has no time stamp, expected one: --clock bag, clock="bag" in Python, takes the time of '
                "its arrival"
            )
        return (int(stamp.sec) * 10**9 + int(stamp.nanosec)) / 10**9 if clock == STAMP else self.arrival


class _Bag:
    """An open bag."""

    def __init__(self, reader: Any, store: Any, is_first: bool, name: str) -> None:
        self._reader, self._store, self._is_first, self._name = reader, store, is_first, name
        self._unpack = bytes if is_first else unpacker_of_messages(reader)

    def topics(self, kinds: tuple[str, ...]) -> list[BagTopic]:
        """Topics of the given kinds of messages."""
        counts: dict[tuple[str, str], int] = {}
        for connection in self._connections(kinds):
            key = (connection.topic, connection.msgtype)
            counts[key] = counts.get(key, 0) + connection.msgcount
        return [BagTopic(name=name, kind=kind, n_messages=count) for (name, kind), count in counts.items()]

    def sealed_messages(self, topic: str | None, kinds: tuple[str, ...], word: str) -> Iterator[_Sealed]:
        """Messages of a topic as they are stored."""
        chosen = self._choose(topic, kinds, word)
        connections = [connection for connection in self._connections(kinds) if connection.topic == chosen]
        for connection in connections:
            self._check_definition(connection)
        for number, (connection, arrival, data) in enumerate(self._reader.messages(connections)):
            yield _Sealed(
                data=data,
                name=f"message {number} of {quoted(chosen)} in {self._name}",
                arrival=arrival / 10**9,  # of two whole numbers, and so to the last digit
                decode=partial(self._decoded, connection.msgtype),
            )

    def _decoded(self, kind: str, data: bytes) -> Any:
        decode = self._store.deserialize_ros1 if self._is_first else self._store.deserialize_cdr
        return decode(self._unpack(data), kind)

    def _connections(self, kinds: tuple[str, ...]) -> list[Any]:
        return [connection for connection in self._reader.connections if connection.msgtype in kinds]

    def _choose(self, topic: str | None, kinds: tuple[str, ...], word: str) -> str:
        found = self.topics(kinds)
        listed = ", ".join(f"{one.name} ({one.kind.rpartition('/')[2]}, {one.n_messages})" for one in found[:20])
        if topic is None and len(found) == 1:
            return found[0].name
        if not found:
            others = ", ".join(sorted({quoted(one.topic) for one in self._reader.connections})[:12]) or "no topic"
            kinds_read = ", ".join(kind.rpartition("/")[2] for kind in kinds)
            raise InputError(f"{self._name} has no {word}, expected a topic of {kinds_read} among {others}")
        if topic is None:
            raise InputError(f"{self._name} has {len(found)} topics of {word}, expected a choice of one: {listed}")
        if topic not in [one.name for one in found]:
            raise InputError(f"{self._name} has no topic {quoted(topic)} of {word}, expected one of {listed}")
        return topic

    def _check_definition(self, connection: Any) -> None:
        """Refuse messages of another definition under the same name, which would be decoded to wrong numbers."""
        store, kind = self._store, connection.msgtype
        known = store.generate_msgdef(kind)[1] if self._is_first else store.hash_rihs01(kind)
        if connection.digest and connection.digest != known:
            raise InputError(
                f"{self._name} defines {kind} otherwise than ROS does, expected its standard definition: a changed or "
                "very old message?"
            )


@contextmanager
def _opened(path: Path) -> Iterator[_Bag]:
    """A bag, its errors as sentences."""
    name = quoted(path.name, 200)
    if not path.exists():
        raise InputError(f"{quoted(path, 200)} does not exist, expected a bag of ROS")
    try:
        from rosbags import rosbag1, rosbag2
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise InputError(
            f"{name} is a bag of ROS, expected the extra robot for it: pip install insectnav[robot]"
        ) from None
    is_first = path.suffix == ".bag" and path.is_file()
    store = get_typestore(Stores.ROS1_NOETIC if is_first else Stores.LATEST)
    try:
        with ExitStack() as stack:
            reader: Any
            if is_first:
                reader = stack.enter_context(rosbag1.Reader(path))
                bound_chunks(reader)
            else:
                reader = stack.enter_context(rosbag2.Reader(stack.enter_context(unpacked_folder(path, name))))
            yield _Bag(reader, store, is_first, name)
    except InputError:
        raise
    except Exception as error:  # damage makes rosbags, SQLite and the unpackers raise errors of a dozen classes
        raise InputError(
            f"{name} cannot be read as a bag of ROS ({_reason(error)}): damaged, or another kind of file?"
        ) from error


def _reason(error: Exception) -> str:
    return " ".join(str(error).split())[:160] or type(error).__name__
