"""What an experimenter does to the animal and its circuit during a trial, as data.

Any of them go together in the list that `insectnav.agents.run_trials` takes as ``perturbations``.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from insectnav.agents.obstacles import Circle, Wall, point
from insectnav.central_complex.connectivity import PROJECTIONS
from insectnav.central_complex.layers import N_CELLS, POPULATIONS_WITH_RATE
from insectnav.checks import (
    InputError,
    as_numbers,
    check_choice,
    check_count,
    check_finite,
    check_radians,
    check_range,
    check_shape,
)

LEGS = ("out", "home", "both")
FILTER_FORMS = ("clean", "code-2017")
MEMORY_MODES = ("replace", "add", "subtract")
_WITHOUT_WEIGHT_NOISE = ("tn_to_cpu4", "cpu4_to_pontine", "pontine_to_cpu1")  # unless they are named


@dataclass(frozen=True, kw_only=True)
class ClampCells:
    """Hold cells at a rate, whatever their input: 1 for an injected current, 0 for silenced or lost cells.

    Parameters
    ----------
    population : str
        "tl", "cl1", "tb1", "tn1", "tn2", "cpu4", "pontine" or "cpu1".
    cells : sequence of int, optional
        Indices within the population; all of them by default. Of two clamps on one cell, the later counts.
    rate : float
        From 0 to 1.
    first_step, end_step : int
        Steps of the trial, from ``first_step`` up to but not including ``end_step``; to the end by default.

    Raises
    ------
    InputError
        If the population, a cell, the rate or the interval does not exist.

    Notes
    -----
    Stone et al. 2017, Extended Data Fig. 10a–c: output of chosen cells set to 1 for 200 steps.
    """

    population: str
    cells: Sequence[int] | None = None
    rate: float
    first_step: int = 0
    end_step: int | None = None

    def __post_init__(self) -> None:
        check_choice("population to clamp", self.population, POPULATIONS_WITH_RATE)
        check_range("clamped rate", self.rate, 0.0, 1.0)
        _check_interval(self.first_step, self.end_step)
        if self.cells is not None:
            if not isinstance(self.cells, Sequence | range) or isinstance(self.cells, str):
                raise InputError(f"cells of {self.population} are {self.cells!r}, expected some as in (3, 4)")
            object.__setattr__(self, "cells", tuple(self.cells))
        for cell in self.cells or ():
            check_count(f"cell of {self.population}", cell, minimum=0)
            check_range(f"cell of {self.population}", cell, 0, N_CELLS[self.population] - 1)


@dataclass(frozen=True, kw_only=True)
class WeightNoise:
    """Synaptic weights that differ from animal to animal: W + N(0, sd) · W, drawn once for each trial.

    Parameters
    ----------
    sd : float
        Standard deviation, as a share of each weight.
    keep_signs : bool
        Whether a weight that would change its sign is 0 instead, as in the text; the authors' 2017 code lets it.
    projections : sequence of str, optional
        Which connection matrices, names as in `insectnav.central_complex.connectivity.PROJECTIONS`; by default all but
        those from TN to CPU4 and to and from the pontine cells. A synapse draws the same number whichever are named.

    Raises
    ------
    InputError
        If the standard deviation is negative or a projection does not exist.

    Notes
    -----
    Stone et al. 2017, Methods and Extended Data Fig. 9a, doi 10.1016/j.cub.2017.08.052.
    """

    sd: float
    keep_signs: bool = True
    projections: Sequence[str] | None = None

    def __post_init__(self) -> None:
        check_range("sd of the weights", self.sd, 0.0, 10.0)
        _check_flag("keep_signs", self.keep_signs)
        if self.projections is None:
            object.__setattr__(self, "projections", tuple(p for p in PROJECTIONS if p not in _WITHOUT_WEIGHT_NOISE))
        elif isinstance(self.projections, str) or not isinstance(self.projections, Sequence):
            raise InputError(f"projections are {self.projections!r}, expected some as in ('tb1_to_cpu1',)")
        for projection in self.projections or ():
            check_choice("projection with weight noise", projection, tuple(PROJECTIONS))
        object.__setattr__(self, "projections", tuple(self.projections or ()))


@dataclass(frozen=True, kw_only=True)
class CompassShift:
    """A heading sense that leads or lags in turns: the circuit is given heading + sign(last turn) · shift.

    Compass and flow cells alike are given that heading. On the way home the last turn is the one that the steering
    cells made in the step before, and there is none before the first step. On the way out it is the change of the
    route's heading.

    Parameters
    ----------
    shift : float [rad]
        Positive where the sense runs ahead of the turn.
    leg : {"home", "out", "both"}

    Raises
    ------
    InputError
        If the shift is not in radians or the leg is unknown.

    Notes
    -----
    Stone et al. 2017, Extended Data Fig. 9a, doi 10.1016/j.cub.2017.08.052; as their 2017 code does it.
    """

    shift: float
    leg: str = "home"

    def __post_init__(self) -> None:
        _check_angle("compass shift", self.shift)
        check_choice("leg", self.leg, LEGS)


@dataclass(frozen=True, kw_only=True)
class FilterSpeed:
    """A sluggish speed sense: TN cells are given s ← flow / n + (1 − 1/n) · s, one s for each side, 0 at the start.

    Parameters
    ----------
    n_steps : int
        n; 1 is no filter.
    form : {"clean", "code-2017"}
        "clean" adds noise to the cells, after the filter. In the authors' 2017 code the noise of TN2 gets into s
        itself, where it piles up; what was published is that.

    Raises
    ------
    InputError
        If there is no step or the form is unknown.

    Notes
    -----
    Stone et al. 2017, Extended Data Fig. 9a and d, doi 10.1016/j.cub.2017.08.052.
    """

    n_steps: int
    form: str = "clean"

    def __post_init__(self) -> None:
        check_count("n_steps of the speed filter", self.n_steps)
        check_choice("form of the speed filter", self.form, FILTER_FORMS)


@dataclass(frozen=True, kw_only=True)
class ScaleSpeed:
    """An outbound route flown ``factor`` times as fast, and so as far. Several multiply.

    Parameters
    ----------
    factor : float

    Raises
    ------
    InputError
        If the factor is negative.

    Notes
    -----
    Stone et al. 2017, Extended Data Fig. 9a: acceleration times 1 to 3, to which speed is proportional.
    """

    factor: float

    def __post_init__(self) -> None:
        check_range("speed factor", self.factor, 0.0, 1e6)


@dataclass(frozen=True, kw_only=True)
class TurnBody:
    """A body that does not point where the animal flies: its heading is turned, the course stays.

    The body's heading is what the circuit is given and what the results have as ``heading``. On the way home the course
    is the heading that the agent steers and thrusts along. Turned on the way out only, it comes home starting with the
    body's last heading.

    Parameters
    ----------
    offset : float, optional [rad]
        Heading of the body minus that of the route; positive is to the right.
    redraw_every : int, optional [steps]
        Instead, an offset drawn for each trial at the start of the leg and every so many steps, uniform in −π to π.
    leg : {"out", "home", "both"}

    Raises
    ------
    InputError
        If not exactly one of the two is given, or one is out of its range.

    Notes
    -----
    Stone et al. 2017, Extended Data Fig. 10d–f, doi 10.1016/j.cub.2017.08.052: 0 to 180°, and random every 25 steps.
    """

    offset: float | None = None
    redraw_every: int | None = None
    leg: str = "out"

    def __post_init__(self) -> None:
        if (self.offset is None) == (self.redraw_every is None):
            given = "neither offset nor" if self.offset is None else "both offset and"
            raise InputError(f"body has {given} redraw_every, expected one of them")
        if self.offset is not None:
            _check_angle("body offset", self.offset)
        if self.redraw_every is not None:
            check_count("redraw_every", self.redraw_every)
        check_choice("leg", self.leg, LEGS)


@dataclass(frozen=True, kw_only=True)
class Displace:
    """An animal that is carried at the start of a step: its position changes, its memory does not.

    Parameters
    ----------
    step : int
        Of the trial.
    by : (2,) sequence, optional [steps]
        How far it is carried.
    to : (2,) sequence, optional [steps]
        Instead, where it is put down.

    Raises
    ------
    InputError
        If not exactly one of the two is given, or it is no finite point.
    """

    step: int
    by: Sequence[float] | None = None
    to: Sequence[float] | None = None

    def __post_init__(self) -> None:
        check_count("step of the displacement", self.step, minimum=0)
        if (self.by is None) == (self.to is None):
            given = "neither by nor to" if self.by is None else "both by and to"
            raise InputError(f"displacement has {given}, expected one of them")
        for name in ("by", "to"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, point(f"displacement {name}", getattr(self, name)))


@dataclass(frozen=True, kw_only=True, eq=False)
class SetMemory:
    """A memory of another trip: at the start of a step it replaces the present one, or is added or subtracted.

    ``M ← memory``, or ``M ← clip(M ± (memory − start), 0, 1)`` with the even memory of the start of a trial. Memories
    set at one step follow in the order of the list. A frozen memory is set all the same.

    Parameters
    ----------
    memory : (16,) or (trial, 16) array
        Charge of the CPU4 cells, 0 to 1; one for all trials, or one for each in the order of the batch.
    step : int
        Of the trial.
    mode : {"replace", "add", "subtract"}
        At the nest, subtracting the memory of a place makes the circuit steer there.

    Raises
    ------
    InputError
        If the memory has another shape or leaves its range, or the mode is unknown.

    Notes
    -----
    Stone et al. 2017, Discussion, doi 10.1016/j.cub.2017.08.052: stored memories for vector navigation and shortcuts.
    """

    memory: ArrayLike
    step: int = 0
    mode: str = "replace"

    def __post_init__(self) -> None:
        memory = np.array(as_numbers("memory", self.memory))
        check_shape("memory", memory, (16,) if memory.ndim == 1 else ("trial", 16))
        check_range("memory", memory, 0.0, 1.0)
        check_count("step of the memory", self.step, minimum=0)
        check_choice("mode of the memory", self.mode, MEMORY_MODES)
        memory.flags.writeable = False
        object.__setattr__(self, "memory", memory)


@dataclass(frozen=True, kw_only=True)
class FreezeMemory:
    """A memory that does not change, and so a heading to keep.

    Parameters
    ----------
    first_step, end_step : int
        Steps of the trial, from ``first_step`` up to but not including ``end_step``; to the end by default.

    Raises
    ------
    InputError
        If the interval does not exist.

    Notes
    -----
    Stone et al. 2017, Discussion, doi 10.1016/j.cub.2017.08.052: migration by a permanent memory.
    """

    first_step: int = 0
    end_step: int | None = None

    def __post_init__(self) -> None:
        _check_interval(self.first_step, self.end_step)


Perturbation = (
    ClampCells
    | WeightNoise
    | CompassShift
    | FilterSpeed
    | ScaleSpeed
    | TurnBody
    | Circle
    | Wall
    | Displace
    | SetMemory
    | FreezeMemory
)


def _check_interval(first_step: int, end_step: int | None) -> None:
    check_count("first_step", first_step, minimum=0)
    if end_step is not None:
        check_count("end_step", end_step, minimum=first_step)


def _check_angle(name: str, angle: float) -> None:
    check_shape(name, np.asarray(angle), ())
    check_finite(name, angle)
    check_radians(name, angle)


def _check_flag(name: str, flag: bool) -> None:
    if not isinstance(flag, bool | np.bool_):
        raise InputError(f"{name} is {flag!r}, expected True or False")
