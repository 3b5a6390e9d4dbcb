"""A route that is seen twice, for the tests of maps: pictures, panoramas, and skies of a camera that looks up."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from insectnav.experiments.place_maps.located import Located

N_FRAMES = 40


def landscape(seed: int = 0, columns: int = 900) -> np.ndarray:
    """A strip of smooth texture, (48, columns) of bytes, along which a camera moves."""
    noise = np.random.default_rng(seed).normal(size=(48, columns)).astype(np.float32)
    smooth = cv2.GaussianBlur(noise, (0, 0), 3.0)
    return np.clip(128 + 60 * smooth / smooth.std(), 0, 255).astype(np.uint8)


def views(n: int = N_FRAMES, *, season: int = 0, seed: int = 0) -> np.ndarray:
    """Frames along the strip, (n, 48, 96): in another season darker, flatter and with noise of its own."""
    strip = landscape(seed)
    frames = np.stack([strip[:, 16 * k : 16 * k + 96] for k in range(n)])
    if not season:
        return frames
    noise = np.random.default_rng(100 + season).normal(0.0, 6.0, frames.shape)
    return np.clip(20 + 0.6 * frames + noise, 0, 255).astype(np.uint8)


def panoramas(n: int = N_FRAMES, *, seed: int = 1) -> np.ndarray:
    """Panoramas of 30 × 120 pixels that change smoothly from one to the next, (n, 30, 120) of bytes."""
    rng = np.random.default_rng(seed)
    knots = rng.normal(size=(n // 4 + 2, 30, 120))
    along = np.arange(n) / 4.0
    low = along.astype(int)
    mixed = knots[low] + (along - low)[:, None, None] * (knots[low + 1] - knots[low])
    smooth = np.stack([cv2.GaussianBlur(np.tile(one, 3), (0, 0), 2.0)[:, 120:240] for one in mixed])
    return np.clip(128 + 50 * smooth / smooth.std(), 0, 255).astype(np.uint8)


def skylines(n: int = N_FRAMES, *, seed: int = 2) -> np.ndarray:
    """Elevation of the skyline at 720 azimuths from straight ahead to the right, (n, 720) [deg], between 5° and 60°."""
    rng = np.random.default_rng(seed)
    azimuth = np.arange(720) * 2 * np.pi / 720
    waves = np.concatenate([[np.cos(m * azimuth), np.sin(m * azimuth)] for m in range(1, 7)])
    weights = np.cumsum(rng.normal(size=(n, len(waves))), axis=0)
    heights = weights @ waves
    heights -= heights.min(axis=1, keepdims=True)
    return 5.0 + 55.0 * heights / heights.max(axis=1, keepdims=True)


def sky_disk(skyline: np.ndarray, size: int = 128, turn_deg: float = 0.0) -> np.ndarray:
    """Mask of the sky, (size, size) bytes of 0 and 255: a fisheye of 180° that looks up, its top ahead.

    Seen from below, azimuth runs anticlockwise in the picture. ``turn_deg`` turns the eye to the right.
    """
    place = (np.arange(size) + 0.5) / size * 2 - 1
    right, down = np.meshgrid(place, place)
    radius, azimuth = np.hypot(right, down), np.arctan2(-right, -down) + np.deg2rad(turn_deg)
    index = np.floor(np.mod(azimuth, 2 * np.pi) / (2 * np.pi) * 720).astype(int) % 720
    return np.where((radius <= 1.0) & (90.0 * (1.0 - radius) > skyline[index]), 255, 0).astype(np.uint8)


def write_pictures(folder: Path, pictures: np.ndarray, name: str = "frame{}.png") -> Path:
    """A folder of pictures, numbered from 0 without leading zeros."""
    folder.mkdir(parents=True, exist_ok=True)
    for k, picture in enumerate(pictures):
        assert cv2.imwrite(str(folder / name.format(k)), picture if picture.ndim == 2 else picture[..., ::-1])
    return folder


def two_seasons(folder: Path) -> Path:
    """The folder with two in it, summer and winter: one route in two seasons."""
    write_pictures(folder / "summer", views())
    write_pictures(folder / "winter", views(season=1))
    return folder


def spoil(path: Path) -> None:
    """Cut a file in the middle."""
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])


def located(reference, score=None, truth=None, **given):
    """Queries located in a map of ten places; all of it by hand."""
    reference = np.array(reference)
    n_places = given.pop("n_places", 10)
    return Located(
        names=[f"q{k}" for k in range(len(reference))],
        times=np.full(len(reference), np.nan),
        reference=reference,
        score=np.where(reference >= 0, 0.5 if score is None else score, np.nan),
        speed=np.where(reference >= 0, 1.0, np.nan),
        place_names=[f"p{k}" for k in range(n_places)],
        place_positions=given.pop("place_positions", np.full((n_places, 3), np.nan)),
        place_routes=given.pop("place_routes", np.zeros(n_places, np.int64)),
        truth=truth,
        **given,
    )


def robot_recording(folder: Path, pictures: np.ndarray, *, is_stamped: bool = True) -> Path:
    """A bag of ROS 2: a picture a second from 10 s on, and odometry that moves north by 3 m a second."""
    rosbag2, typesys = pytest.importorskip("rosbags.rosbag2"), pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    make = {name.rsplit("/", 1)[1]: kind for name, kind in store.types.items()}
    zero = make["Vector3"](x=0.0, y=0.0, z=0.0)
    upright = make["Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
    path = folder / "robot"
    with rosbag2.Writer(path, version=9) as writer:
        images = writer.add_connection("/camera", "sensor_msgs/msg/Image", typestore=store)
        places = writer.add_connection("/odometry", "nav_msgs/msg/Odometry", typestore=store)
        for k, picture in enumerate(pictures):
            stamp = make["Time"](sec=10 + k, nanosec=0)
            header = make["Header"](stamp=stamp, frame_id="")
            taken = header if is_stamped else make["Header"](stamp=make["Time"](sec=0, nanosec=0), frame_id="")
            rows, columns = picture.shape
            image = make["Image"](header=taken, height=rows, width=columns, encoding="mono8", is_bigendian=0,
                                  step=columns, data=picture.reshape(-1))  # fmt: skip
            pose = make["Pose"](position=make["Point"](x=0.0, y=3.0 * k, z=0.0), orientation=upright)
            place = make["Odometry"](
                header=header, child_frame_id="base",
                pose=make["PoseWithCovariance"](pose=pose, covariance=np.zeros(36)),
                twist=make["TwistWithCovariance"](twist=make["Twist"](linear=zero, angular=zero),
                                                  covariance=np.zeros(36)),
            )  # fmt: skip
            for connection, message in ((images, image), (places, place)):
                data = store.serialize_cdr(message, message.__msgtype__)
                writer.write(connection, (10 + k) * 10**9, bytes(data))
    return path
