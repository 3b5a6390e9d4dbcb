"""Ways through a world: where a camera that is carried along a line of way points is, and how it sways."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats, bearing
from insectnav.checks import InputError, as_numbers, check_count, check_finite, check_range, check_shape
from insectnav.records import Poses
from insectnav.worlds.shapes import generator

WALKING_SPEED = 1.4  # [m/s] assumed: a person's usual pace
TURN_LENGTH = 2.0  # [m] assumed: the way along which a person turns round a corner
MAX_POSES = 1_000_000


@dataclass(frozen=True, kw_only=True)
class Jitter:
    """How much a camera sways about its way: standard deviations, and how soon a deviation is forgotten.

    Parameters
    ----------
    yaw, pitch, roll : float [rad]
    lateral : float [m]
        To the right and left of the way.
    correlation_length : float [m]
        Of way, over which the correlation of a deviation with itself falls to 1/e; 0 makes each frame independent.

    Raises
    ------
    InputError
        If a number is negative or an angle is in degrees.
    """

    yaw: float = 0.0  # [rad]
    pitch: float = 0.0  # [rad]
    roll: float = 0.0  # [rad]
    lateral: float = 0.0  # [m]
    correlation_length: float = 2.0  # [m] assumed: some steps of a walk

    def __post_init__(self) -> None:
        for name in ("yaw", "pitch", "roll"):
            check_range(f"jitter in {name}", getattr(self, name), 0.0, np.pi / 2, "rad", "degrees?")
        check_range("lateral jitter", self.lateral, 0.0, 100.0, "m")
        check_range("correlation length of the jitter", self.correlation_length, 0.0, 1e6, "m")

    @property
    def is_still(self) -> bool:
        """True where nothing sways."""
        return not (self.yaw or self.pitch or self.roll or self.lateral)


def way_length(way: npt.ArrayLike) -> float:
    """Length of a line of way points (n, 2) [m]."""
    return float(_arc(_checked_way(way))[-1])


def spaced(length: float, spacing: float, start: float = 0.0, stop: float | None = None) -> Floats:
    """Distances along a way, from start to stop, both included where they fit, (n,) array [m].

    Parameters
    ----------
    length : of the way [m]
    spacing : between two frames [m]
    start, stop : distances from the start of the way [m]; without a stop, its end

    Raises
    ------
    InputError
        If they lie beyond the way, or make more than a million frames.
    """
    stop = length if stop is None else stop
    beyond = f"the way is {length:.6g} m long"
    check_range("start", start, 0.0, length, "m", beyond)
    check_range("stop", stop, 0.0, length * (1 + 1e-12), "m", beyond)
    if start > stop:
        raise InputError(f"the traverse starts at {start:g} m and stops at {stop:g} m, expected the start first")
    check_range("spacing", spacing, 1e-6, 1e6, "m")
    n = np.floor((stop - start) / spacing * (1 + 1e-12)) + 1
    check_range("number of frames", n, 1, MAX_POSES, slip="a spacing in kilometres?")
    return np.minimum(start + spacing * np.arange(int(n)), length)


def along(way: npt.ArrayLike, distances: npt.ArrayLike, *, turn_length: float = TURN_LENGTH) -> tuple[Floats, Floats]:
    """Positions (n, 2) [m] at distances along a way, and the course (n,) [rad] there.

    Parameters
    ----------
    way : (point, 2) array [m]
    distances : (n,) array [m] from the first way point
    turn_length : [m] of way, about each place, whose ends the course connects, so that corners are turned gradually

    Raises
    ------
    InputError
        If there is no way, or a distance lies beyond it.
    """
    points = _checked_way(way)
    arc = _arc(points)
    check_range("distances", distances, 0.0, float(arc[-1]), "m", "beyond the end of the way?")
    check_range("turn_length", turn_length, 0.0, 1e4, "m")
    at = np.asarray(distances, dtype=np.float64)
    leg = np.clip(np.searchsorted(arc, at, side="right") - 1, 0, len(points) - 2)
    course = bearing(np.diff(points, axis=0)[leg])
    chord = _interpolated(points, arc, at + turn_length / 2) - _interpolated(points, arc, at - turn_length / 2)
    is_turned_back = np.hypot(chord[:, 0], chord[:, 1]) < 1e-9
    return _interpolated(points, arc, at), np.where(is_turned_back, course, bearing(chord))


def carried(
    way: npt.ArrayLike,
    distances: npt.ArrayLike,
    *,
    offset: float = 0.0,
    speed: float = WALKING_SPEED,
    turn_length: float = TURN_LENGTH,
) -> Poses:
    """Poses of a level camera that is carried along a way and looks ahead, on the ground z = 0.

    Parameters
    ----------
    way : (point, 2) array [m]
    distances : (n,) array [m] from the first way point, not decreasing
    offset : [m] to the right of the way
    speed : [m/s]; the time counts from the first frame
    turn_length : as of `along`

    Raises
    ------
    InputError
        If there is no way, or a distance lies beyond it.
    """
    check_range("offset", offset, -1000.0, 1000.0, "m")
    check_range("speed", speed, 1e-6, 1e4, "m/s")
    distances = np.asarray(distances, dtype=np.float64)
    position, course = along(way, distances, turn_length=turn_length)
    position = position + offset * _right_of(course)
    level = np.zeros(len(position))
    return Poses(
        position=np.column_stack([position, level]),
        heading=course,
        pitch=level,
        roll=level,
        distance=distances,
        time=(distances - distances[:1]) / speed,
    )


def swayed(poses: Poses, jitter: Jitter, seed: int = 0, *, course: Floats | None = None) -> Poses:
    """The same poses with a random sway.

    Parameters
    ----------
    poses : Poses
    jitter : Jitter
    seed : int
        Not negative. A longer traverse of the same spacing begins like a shorter one.
    course : (n,) array [rad] of the way, to whose right and left the camera sways; None is the heading

    Notes
    -----
    An Ornstein-Uhlenbeck process along the way for each of the four: from one frame to the next, a distance d further,
    a deviation x becomes a x + σ √(1 − a²) ξ with a = exp(−d / correlation length) and ξ a standard normal number. The
    first is drawn from the stationary distribution, so that σ is the standard deviation everywhere, at any spacing
    (Uhlenbeck & Ornstein 1930, Phys. Rev. 36, 823, doi 10.1103/PhysRev.36.823).
    """
    check_count("seed", seed, minimum=0)
    if jitter.is_still:
        return poses
    noise = generator(seed, "traverse jitter").standard_normal((len(poses), 4))
    if jitter.correlation_length > 0.0:
        kept = np.exp(-np.diff(poses.distance) / jitter.correlation_length)
        fresh = np.sqrt(1.0 - kept**2)
        for index, (a, b) in enumerate(zip(kept, fresh, strict=True), 1):
            noise[index] = a * noise[index - 1] + b * noise[index]
    yaw, pitch, roll, lateral = (noise * [jitter.yaw, jitter.pitch, jitter.roll, jitter.lateral]).T
    position = poses.position.copy()
    position[:, :2] += lateral[:, None] * _right_of(poses.heading if course is None else course)
    return replace(
        poses, position=position, heading=poses.heading + yaw, pitch=poses.pitch + pitch, roll=poses.roll + roll
    )


def lifted(poses: Poses, ground_height: Callable[[Floats], Floats], eye_height: float) -> Poses:
    """The same poses with the eye at a height above the ground beneath it.

    Parameters
    ----------
    poses : Poses
    ground_height : from positions (n, 2) to heights (n,) [m], as ``BuiltWorld.ground_height``
    eye_height : [m]
    """
    check_range("eye height", eye_height, 1e-4, 1000.0, "m", "above the ground")
    plane = poses.position[:, :2]
    return replace(poses, position=np.column_stack([plane, ground_height(plane) + eye_height]))


def _checked_way(way: npt.ArrayLike) -> Floats:
    points = np.asarray(as_numbers("way", way), dtype=np.float64)
    check_shape("way", points, ("n", 2))
    check_finite("way", points)
    if len(points) < 2 or not _arc(points)[-1] > 0.0:
        raise InputError("the way has no length, expected two different way points at least")
    return points


def _arc(points: Floats) -> Floats:
    """Distance of each way point from the first, (n,) [m]."""
    steps = np.diff(points, axis=0)
    return np.concatenate([[0.0], np.cumsum(np.sqrt((steps**2).sum(axis=-1)))])


def _interpolated(points: Floats, arc: Floats, distances: Floats) -> Floats:
    """Places (n, 2) at distances along the way; beyond its ends, the ends."""
    return np.stack([np.interp(distances, arc, points[:, axis]) for axis in (0, 1)], axis=-1)


def _right_of(course: Floats) -> Floats:
    """Unit vectors (n, 2) to the right of a course (n,) [rad]."""
    return np.stack([np.cos(course), -np.sin(course)], axis=-1)
