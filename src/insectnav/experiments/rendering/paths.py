"""Where pictures are taken: at one place, along the route of a world, or at the rows of a table."""

from dataclasses import dataclass, replace

import numpy as np

from insectnav.angles import Floats, wrap
from insectnav.checks import InputError, check_count, check_range
from insectnav.datasets.pose_table import as_tabled, read_poses
from insectnav.experiments.rendering.places import Place
from insectnav.records import Poses
from insectnav.worlds.traverse import (
    MAX_POSES,
    TURN_LENGTH,
    WALKING_SPEED,
    Jitter,
    carried,
    lifted,
    spaced,
    swayed,
    way_length,
)

_OF_TRAVERSES = {"start": "--start", "stop": "--stop", "is_reversed": "--reverse", "offset": "--offset"}
_WAYS = {"spacing": "--spacing", "frame_rate": "--frame-rate", "n_frames": "--frames"}


@dataclass(frozen=True, kw_only=True)
class PathParams:
    """Where pictures are taken.

    Parameters
    ----------
    positions : str or None
        A table of them.
    at : x, y and perhaps z [m], or None
        A single place.
    spacing : float or None [m]
    frame_rate : float or None [1/s]
    n_frames : int or None
        Along the route of the world: a picture every so many metres, so many in a second of walk, or so many in all.
        Where nothing is given, one picture is taken in the middle of the route.
    speed : float [m/s]
    start, stop : float [m]
        Along the route; without a stop, its end.
    is_reversed : bool
        Walk the route from its end; start and stop then count from there.
    offset : float [m]
        To the right of the route.
    turn_length : float [m]
        As of `insectnav.worlds.traverse.along`.
    heading_deg : float or None [°]
        The same for all; None is along the way, or that of the table; north at a single place.
    pitch_deg, roll_deg : float [°]
        Added to that of the table.
    eye_height : float or None [m]
        Above the ground; None is that of the world. Heights in a table stay as they are.
    yaw_jitter_deg, pitch_jitter_deg, roll_jitter_deg, lateral_jitter, jitter_length, jitter_seed
        As of `insectnav.worlds.traverse.Jitter` and `swayed`.

    Raises
    ------
    InputError
        If two ways of choosing places are given, or a number makes no sense.
    """

    positions: str | None = None
    at: tuple[float, ...] | None = None
    spacing: float | None = None
    frame_rate: float | None = None
    n_frames: int | None = None
    speed: float = WALKING_SPEED
    start: float = 0.0
    stop: float | None = None
    is_reversed: bool = False
    offset: float = 0.0
    turn_length: float = TURN_LENGTH
    heading_deg: float | None = None
    pitch_deg: float = 0.0
    roll_deg: float = 0.0
    eye_height: float | None = None
    yaw_jitter_deg: float = 0.0
    pitch_jitter_deg: float = 0.0
    roll_jitter_deg: float = 0.0
    lateral_jitter: float = 0.0
    jitter_length: float = 2.0
    jitter_seed: int = 0

    def __post_init__(self) -> None:
        ways = {"positions": "--positions", "at": "--at", **_WAYS}
        given = [option for name, option in ways.items() if getattr(self, name) is not None]
        if len(given) > 1:
            raise InputError(f"{given[0]} and {given[1]} are given, expected one of them: both say where to look from")
        if not self.is_traverse:
            strange = [option for name, option in _OF_TRAVERSES.items() if getattr(self, name)]
            if strange:
                raise InputError(f"{strange[0]} needs a traverse, expected --spacing, --frame-rate or --frames as well")
        check_range("speed", self.speed, 1e-6, 1e4, "m/s")
        if self.frame_rate is not None:
            check_range("frame rate", self.frame_rate, 1e-6, 1e4, "in a second")
        if self.n_frames is not None:
            check_count("frames", self.n_frames)
            check_range("frames", self.n_frames, 1, MAX_POSES)
        for name in ("heading_deg", "pitch_deg", "roll_deg"):
            limit = 90.0 if name == "pitch_deg" else 360.0
            check_range(name.removesuffix("_deg"), getattr(self, name) or 0.0, -limit, limit, "degrees")
        if self.at is not None:
            if len(self.at) not in (2, 3):
                raise InputError(f"--at has {len(self.at)} numbers, expected X,Y or X,Y,Z in metres")
            check_range("--at", self.at, -1e4, 1e4, "m")
        check_count("jitter seed", self.jitter_seed, minimum=0)
        check_range("jitter in degrees", self._jitter_deg, 0.0, 90.0, "degrees")
        self.jitter()

    @property
    def is_traverse(self) -> bool:
        """Whether pictures are taken along the route of the world."""
        return any(getattr(self, name) is not None for name in _WAYS)

    @property
    def _jitter_deg(self) -> tuple[float, float, float]:
        return self.yaw_jitter_deg, self.pitch_jitter_deg, self.roll_jitter_deg

    def jitter(self) -> Jitter:
        """The sway about the way."""
        yaw, pitch, roll = np.deg2rad(self._jitter_deg).tolist()
        return Jitter(
            yaw=yaw, pitch=pitch, roll=roll, lateral=self.lateral_jitter, correlation_length=self.jitter_length
        )


def poses_in(place: Place, params: PathParams) -> Poses:
    """Poses of all pictures, as a table of them with six decimals gives them back.

    Raises
    ------
    InputError
        If the table cannot be read, or the world has no route.
    """
    has_height = False
    if params.positions is not None:
        poses, has_height = read_poses(params.positions, speed=params.speed)
    elif params.is_traverse:
        poses = _traverse(place, params)
    else:
        poses, has_height = _single(place, params)
    course = poses.heading
    if params.heading_deg is not None:
        poses = replace(poses, heading=np.full(len(poses), np.deg2rad(params.heading_deg)))
    poses = swayed(poses, params.jitter(), params.jitter_seed, course=course)
    if not has_height:
        height = place.eye_height if params.eye_height is None else params.eye_height
        poses = lifted(poses, place.ground_height, height)
    tilt = np.deg2rad([params.pitch_deg, params.roll_deg])
    return as_tabled(replace(poses, pitch=wrap(poses.pitch + tilt[0]), roll=wrap(poses.roll + tilt[1])))


def _traverse(place: Place, params: PathParams) -> Poses:
    """Along the route of the world."""
    if len(place.route) < 2:
        raise InputError(
            f"the world {place.name} has no route to walk along, expected --positions TABLE.csv, or --at X,Y"
        )
    way = place.route[::-1] if params.is_reversed else place.route
    distances = _distances(way_length(way), params)
    return carried(way, distances, offset=params.offset, speed=params.speed, turn_length=params.turn_length)


def _distances(length: float, params: PathParams) -> Floats:
    """Where along the route pictures are taken [m]."""
    if params.n_frames is None:
        spacing = params.spacing if params.frame_rate is None else params.speed / params.frame_rate
        return spaced(length, spacing or 0.0, params.start, params.stop)
    ends = spaced(length, 1e6, params.start, params.stop)[0], length if params.stop is None else params.stop
    return np.linspace(*ends, params.n_frames) if params.n_frames > 1 else np.array([sum(ends) / 2])


def _single(place: Place, params: PathParams) -> tuple[Poses, bool]:
    """At one place, by default in the middle of the route, and whether its height is given."""
    if params.at is None and len(place.route) > 1:
        return carried(place.route, [way_length(place.route) / 2], turn_length=params.turn_length), False
    at = place.route[0] if params.at is None else np.array(params.at)
    nothing = np.zeros(1)
    position = np.append(at, 0.0)[None, :3]
    return Poses(position=position, heading=nothing, pitch=nothing, roll=nothing, distance=nothing, time=nothing), len(
        at
    ) == 3
