"""People and cars that move below the skyline of an eye held at two metres; where they are follows from the time."""

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats
from insectnav.checks import check_count, check_range
from insectnav.worlds.shapes import Part, ball, box, frustum, joined, placed

CAR_LENGTH, CAR_WIDTH, CAR_HEIGHT = 4.4, 1.8, 1.5  # [m]
PERSON_HEIGHT, PERSON_WIDTH = 1.8, 0.6  # [m], of the tallest
CAR_SPEED, WALKING_SPEED = (5.0, 12.0), (0.9, 1.7)  # [m/s], least and greatest
PAINTS = ("dark paint", "light paint", "red paint")
_ROOM = 0.25  # [m] that is left between the route and whatever moves


def moving_along(
    rng: np.random.Generator, lines: Floats, n: int, speeds: tuple[float, float], time_s: float
) -> tuple[Floats, Floats]:
    """Positions (n, 2) [m] and headings (n,) [rad] of `n` things at a time, each on a line of its own.

    Parameters
    ----------
    lines : (line, 2, 2) array, start and end of each [m]
        A thing goes from the start to the end of its line, and then enters at the start again.
    speeds : pair of float
        Least and greatest [m/s].
    time_s : float
        [s]; any time. What is where at time 0 follows from the random numbers.
    """
    check_count("number of moving things", n, minimum=0)
    check_range("time_s", time_s, -1e9, 1e9, "s")
    which = rng.integers(0, max(len(lines), 1), n)
    begin, speed = rng.random(n), speeds[0] + (speeds[1] - speeds[0]) * rng.random(n)
    if not len(lines):
        return np.zeros((0, 2)), np.zeros(0)
    start, way = lines[which, 0], lines[which, 1] - lines[which, 0]
    length = np.sqrt(way[:, 0] ** 2 + way[:, 1] ** 2)
    share = np.mod(begin + speed * time_s / length, 1.0)
    return start + share[:, None] * way, np.arctan2(way[:, 0], way[:, 1])


def clear_of(route: Floats, positions: Floats, headings: Floats, length: float, width: float) -> npt.NDArray[np.bool_]:
    """Whether each of the things leaves the route free, (n,) array of bool.

    Parameters
    ----------
    route : (point, 2) array [m]
    positions, headings : (n, 2) array [m], (n,) array [rad]
    length, width : float
        Of a thing along and across its heading [m].
    """
    off = route[None] - positions[:, None]
    sine, cosine = np.sin(headings)[:, None], np.cos(headings)[:, None]
    ahead = np.abs(off[..., 0] * sine + off[..., 1] * cosine)
    aside = np.abs(off[..., 0] * cosine - off[..., 1] * sine)
    within = (ahead < length / 2 + _ROOM) & (aside < width / 2 + _ROOM)
    return np.asarray(~within.any(axis=1))


def traffic(rng: np.random.Generator, lanes: Floats, n: int, time_s: float, route: Floats) -> tuple[Floats, Floats]:
    """Positions (k, 2) [m] and headings (k,) [rad] of those of `n` cars that leave the route free.

    Parameters
    ----------
    lanes, n, time_s : as of `moving_along`
    route : (point, 2) array [m]
    """
    positions, headings = moving_along(rng, lanes, n, CAR_SPEED, time_s)
    free = clear_of(route, positions, headings, CAR_LENGTH, CAR_WIDTH)
    return positions[free], headings[free]


def walkers(rng: np.random.Generator, walks: Floats, n: int, time_s: float, route: Floats) -> tuple[Floats, Floats]:
    """The same of people; parameters as of `traffic`."""
    positions, headings = moving_along(rng, walks, n, WALKING_SPEED, time_s)
    free = clear_of(route, positions, headings, PERSON_WIDTH, PERSON_WIDTH)
    return positions[free], headings[free]


def cars(rng: np.random.Generator, positions: Floats, headings: Floats) -> list[Part]:
    """Cars of three paints at positions (n, 3) [m]: body, glass, roof and wheels; none is higher than `CAR_HEIGHT`."""
    body = box(CAR_WIDTH, CAR_LENGTH, 0.65, base=0.2)
    cabin = frustum(4, 1.0, 0.8, 0.65, base=0.85)
    cabin = placed(cabin, [(0.0, 0.0, 0.0)], np.pi / 4)[0] * np.array([1.15, 1.75, 1.0]) - [0.0, 0.35, 0.0]
    x, y = 0.8 * np.sqrt(0.5) * 1.15, 0.8 * np.sqrt(0.5) * 1.75
    roof = box(2 * x, 2 * y, 0.0, base=CAR_HEIGHT)[8:] - [0.0, 0.35, 0.0]
    paint = rng.integers(0, len(PAINTS), len(positions))
    shell = placed(joined([body, roof]), positions, headings)
    parts: list[Part] = [(name, joined([shell[paint == index]])) for index, name in enumerate(PAINTS)]
    glass = ("window", joined([placed(cabin, positions, headings)]))
    return [*parts, glass, ("dark paint", joined([placed(_wheels(), positions, headings)]))]


def _wheels() -> Floats:
    """Four wheels, as dark as paint can be, on which the body stands."""
    wheel = box(0.2, 0.62, 0.6)
    return joined([wheel + np.array([x, y, 0.0]) for x in (-0.78, 0.78) for y in (-1.35, 1.35)])


def people(rng: np.random.Generator, positions: Floats, headings: Floats) -> list[Part]:
    """People at positions (n, 3) [m]: a coat and a head; heights are 1.5 m to `PERSON_HEIGHT`."""
    tall = PERSON_HEIGHT * (1.5 / 1.8 + (1 - 1.5 / 1.8) * rng.random(len(positions)))
    legs, body = frustum(6, 0.10, 0.13, 0.48), frustum(6, 0.15, 0.14, 0.38, base=0.46)
    coat = joined([legs, body, frustum(6, 0.14, 0.0, 0.06, base=0.84)])
    head = ball() * np.array([0.05, 0.06, 0.07]) + [0.0, 0.0, 0.93]
    scale = tall[:, None, None, None]
    return [
        ("cloth", joined([placed(coat * scale, positions, headings)])),
        ("timber", joined([placed(head * scale, positions, headings)])),
    ]
