"""Recordings of robots, ROS 1 and 2, written by rosbags."""

from pathlib import Path

import cv2
import numpy as np
import pytest

rosbag1 = pytest.importorskip("rosbags.rosbag1")
rosbag2 = pytest.importorskip("rosbags.rosbag2")
typesys = pytest.importorskip("rosbags.typesys")

ROS1, ROS2, MCAP = "ros1", "ros2", "mcap"
KINDS = (ROS1, ROS2, MCAP)
PACKED = (rosbag2.CompressionMode.FILE, rosbag2.CompressionMode.MESSAGE)
PICTURE = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)  # red, green, blue


class Messages:
    """Messages of one version of ROS."""

    def __init__(self, kind: str) -> None:
        self.is_first = kind == ROS1
        self.store = typesys.get_typestore(typesys.Stores.ROS1_NOETIC if self.is_first else typesys.Stores.ROS2_HUMBLE)

    def make(self, name: str, **fields):
        return self.store.types[name](**fields)

    def header(self, seconds: float):
        whole = int(seconds)
        stamp = self.make("builtin_interfaces/msg/Time", sec=whole, nanosec=round((seconds - whole) * 1e9))
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id="", **({"seq": 0} if self.is_first else {}))

    def image(self, seconds: float, encoding: str, lines: np.ndarray, columns: int, **more):
        fields = {"height": len(lines), "width": columns, "step": lines.shape[1], "is_bigendian": 0} | more
        header = self.header(seconds)
        return self.make(
            "sensor_msgs/msg/Image", header=header, encoding=encoding, data=lines.reshape(-1).view(np.uint8), **fields
        )

    def compressed(self, seconds: float, ending: str, picture: np.ndarray):
        data = cv2.imencode(f".{ending}", picture[..., ::-1] if picture.ndim == 3 else picture)[1].reshape(-1)
        return self.make("sensor_msgs/msg/CompressedImage", header=self.header(seconds), format=ending, data=data)

    def fix(self, seconds: float, latitude: float, longitude: float, altitude: float, status: int = 0):
        return self.make(
            "sensor_msgs/msg/NavSatFix",
            header=self.header(seconds),
            status=self.make("sensor_msgs/msg/NavSatStatus", status=status, service=1),
            latitude=latitude,
            longitude=longitude,
            altitude=altitude,
            position_covariance=np.zeros(9),
            position_covariance_type=0,
        )

    def pose(self, x: float, y: float, z: float):
        return self.make(
            "geometry_msgs/msg/Pose",
            position=self.make("geometry_msgs/msg/Point", x=x, y=y, z=z),
            orientation=self.make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0),
        )

    def stamped(self, seconds: float, x: float, y: float, z: float):
        return self.make("geometry_msgs/msg/PoseStamped", header=self.header(seconds), pose=self.pose(x, y, z))

    def odometry(self, seconds: float, x: float, y: float, z: float):
        still = self.make("geometry_msgs/msg/Vector3", x=0.0, y=0.0, z=0.0)
        twist = self.make("geometry_msgs/msg/Twist", linear=still, angular=still)
        return self.make(
            "nav_msgs/msg/Odometry",
            header=self.header(seconds),
            child_frame_id="base",
            pose=self.make("geometry_msgs/msg/PoseWithCovariance", pose=self.pose(x, y, z), covariance=np.zeros(36)),
            twist=self.make("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=np.zeros(36)),
        )


def bag(folder: Path, kind: str, topics: dict, compression=None) -> Path:
    """A bag of messages by topic, each arriving 2 s after the topic's start and one second after the other."""
    messages = Messages(kind)
    path = folder / ("walk.bag" if kind == ROS1 else "walk")
    if kind == ROS1:
        writer = rosbag1.Writer(path)
        if compression:
            writer.set_compression(compression)
    else:
        plugin = rosbag2.StoragePlugin.MCAP if kind == MCAP else rosbag2.StoragePlugin.SQLITE3
        writer = rosbag2.Writer(path, version=9, storage_plugin=plugin)
        if compression:
            writer.set_compression(compression, rosbag2.CompressionFormat.ZSTD)
    serialise = messages.store.serialize_ros1 if kind == ROS1 else messages.store.serialize_cdr
    with writer:
        for topic, make in topics.items():
            made = make(messages)
            connection = writer.add_connection(topic, made[0].__msgtype__, typestore=messages.store)
            for k, message in enumerate(made):
                writer.write(connection, (2 + k) * 10**9, bytes(serialise(message, message.__msgtype__)))
    return path


def camera(messages: Messages) -> list:
    return [messages.image(10.5 + k, "rgb8", PICTURE.reshape(2, 12) + np.uint8(k), 4) for k in range(3)]


def walk(messages: Messages) -> list:
    return [messages.odometry(10.0 + k, 1.0 * k, 2.0, 0.5) for k in range(4)]
