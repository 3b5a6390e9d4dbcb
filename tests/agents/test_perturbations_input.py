"""Perturbations as data: what cannot be is refused in a sentence, and what was done is written down."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
import xarray

from insectnav.agents import (
    LEGS,
    Circle,
    ClampCells,
    CompassShift,
    Displace,
    FilterSpeed,
    FreezeMemory,
    ScaleSpeed,
    SetMemory,
    TurnBody,
    Wall,
    WeightNoise,
    random_routes,
    run_trials,
)
from insectnav.agents.perturbation_packing import describe_perturbation
from insectnav.checks import InputError

EVEN = np.full(16, 0.5)

REFUSED = [
    (WeightNoise, {"sd": -0.1}, r"sd of the weights is -0\.1, expected 0 to 10"),
    (WeightNoise, {"sd": np.nan}, "sd of the weights is nan"),
    (WeightNoise, {"sd": 0.1, "keep_signs": 1}, "keep_signs is 1, expected True or False"),
    (WeightNoise, {"sd": 0.1, "projections": "tb1_to_tb1"}, "projections are 'tb1_to_tb1', expected some as in"),
    (WeightNoise, {"sd": 0.1, "projections": 3}, "projections are 3, expected some as in"),
    (
        WeightNoise,
        {"sd": 0.1, "projections": ["tb1_to_tb2"]},
        r"projection with weight noise 'tb1_to_tb2' is unknown.*\?",
    ),
    (CompassShift, {"shift": 30.0}, "compass shift is 30, expected radians within ±2π: degrees?"),
    (CompassShift, {"shift": np.inf}, "compass shift is inf, expected finite numbers"),
    (CompassShift, {"shift": [0.1, 0.2]}, r"compass shift has shape \(2,\)"),
    (CompassShift, {"shift": "0.1"}, "compass shift holds .* values, expected real numbers"),
    (CompassShift, {"shift": 0.1, "leg": "inbound"}, "leg 'inbound' is unknown: expected one of out, home, both"),
    (FilterSpeed, {"n_steps": 0}, "n_steps of the speed filter is 0, expected a whole number of at least 1"),
    (FilterSpeed, {"n_steps": 2.5}, r"n_steps of the speed filter is 2\.5"),
    (FilterSpeed, {"n_steps": 2, "form": "2017"}, r"form of the speed filter '2017' is unknown.*code-2017"),
    (ScaleSpeed, {"factor": -1.0}, "speed factor is -1, expected 0 to"),
    (ScaleSpeed, {"factor": np.nan}, "speed factor is nan"),
    (ScaleSpeed, {"factor": None}, "speed factor holds object values"),
    (TurnBody, {}, "body has neither offset nor redraw_every, expected one of them"),
    (TurnBody, {"offset": 0.1, "redraw_every": 25}, "body has both offset and redraw_every, expected one of them"),
    (TurnBody, {"offset": 45}, "body offset is 45, expected radians within ±2π: degrees?"),
    (TurnBody, {"redraw_every": 0}, "redraw_every is 0, expected a whole number of at least 1"),
    (TurnBody, {"offset": 0.1, "leg": "hme"}, r"leg 'hme' is unknown.*did you mean home\?"),
    (Circle, {"centre": (1, 2), "radius": 0.0}, "radius of the circle is 0, expected 1e-06 to .* steps"),
    (Circle, {"centre": (1, 2), "radius": np.nan}, "radius of the circle is nan"),
    (Circle, {"centre": (1, 2), "radius": [1.0]}, r"radius of the circle has shape \(1,\)"),
    (Circle, {"centre": (1, 2, 3), "radius": 1.0}, r"centre of the circle has shape \(3,\), expected \(2,\)"),
    (Circle, {"centre": (1, np.inf), "radius": 1.0}, "centre of the circle is inf at index 1"),
    (Circle, {"centre": 5, "radius": 1.0}, r"centre of the circle has shape \(\)"),
    (Wall, {"start": (1, 2), "end": (1.0, 2.0)}, "wall starts and ends at 1, 2, expected two points"),
    (Wall, {"start": (1, 2), "end": "ab"}, "end of the wall holds"),
    (Wall, {"start": [(1, 2)], "end": (3, 4)}, r"start of the wall has shape \(1, 2\)"),
    (Displace, {"step": -1, "by": (1, 2)}, "step of the displacement is -1"),
    (Displace, {"step": 3}, "displacement has neither by nor to, expected one of them"),
    (Displace, {"step": 3, "by": (1, 2), "to": (1, 2)}, "displacement has both by and to, expected one of them"),
    (Displace, {"step": 3, "to": (1, np.nan)}, "displacement to is nan at index 1"),
    (Displace, {"step": 3, "by": (1,)}, r"displacement by has shape \(1,\)"),
    (SetMemory, {"memory": np.zeros(8)}, r"memory has shape \(8,\), expected \(16,\)"),
    (SetMemory, {"memory": np.zeros((16, 3))}, r"memory has shape \(16, 3\), expected \(trial, 16\): transposed\?"),
    (SetMemory, {"memory": EVEN + 0.6}, r"memory reaches 1\.1, expected 0 to 1"),
    (SetMemory, {"memory": EVEN * np.nan}, "memory reaches nan"),
    (SetMemory, {"memory": "full"}, "memory holds"),
    (SetMemory, {"memory": EVEN, "step": 1.5}, r"step of the memory is 1\.5"),
    (SetMemory, {"memory": EVEN, "mode": "substract"}, r"mode of the memory 'substract' is unknown.*subtract\?"),
    (FreezeMemory, {"first_step": -2}, "first_step is -2"),
    (FreezeMemory, {"first_step": 5, "end_step": 4}, "end_step is 4, expected a whole number of at least 5"),
]


@pytest.mark.parametrize(("kind", "given", "message"), REFUSED)
def test_what_cannot_be_done_is_refused_in_a_sentence(kind: type, given: dict, message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}") as refusal:
        kind(**given)
    assert "\n" not in str(refusal.value)


TOGETHER = [
    ([WeightNoise(sd=0.1)] * 2, "perturbations hold 2 of WeightNoise, expected one at most"),
    ([CompassShift(shift=0.1, leg=leg) for leg in LEGS], "perturbations hold 3 of CompassShift, expected one at most"),
    ([FilterSpeed(n_steps=2), FilterSpeed(n_steps=3)], "perturbations hold 2 of FilterSpeed"),
    ([TurnBody(offset=0.1), TurnBody(redraw_every=9, leg="home")], "perturbations hold 2 of TurnBody"),
    ([SetMemory(memory=np.zeros((3, 16)))], "memory to replace has 3 rows, expected 1 or one for each of 4"),
    ([FreezeMemory(), None], "perturbations hold a NoneType, expected some of ClampCells, .*FreezeMemory"),
    ([WeightNoise], "perturbations hold a type, expected some of"),
    ({"sd": 0.1}, "perturbations are a dict, expected a list"),
    (FreezeMemory(), "perturbations are a FreezeMemory, expected a list"),
]


@pytest.mark.parametrize(("perturbations", "message"), TOGETHER)
def test_what_does_not_go_together_is_refused_in_a_sentence(perturbations: object, message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}"):
        run_trials(random_routes(4, 10), n_inbound=1, perturbations=perturbations)


ALL: Sequence = [
    ClampCells(population="tb1", cells=[3, 4], rate=np.float32(0.5), first_step=np.int64(7)),
    WeightNoise(sd=np.float64(0.1), projections=["tb1_to_tb1"]),
    CompassShift(shift=0.25),
    FilterSpeed(n_steps=np.int32(3)),
    ScaleSpeed(factor=2),
    TurnBody(redraw_every=25),
    Circle(centre=np.array([1, 2]), radius=3),
    Wall(start=[0, 1], end=(2.5, 3)),
    Displace(step=5, by=(1, 2)),
    SetMemory(memory=EVEN, step=4, mode="add"),
    FreezeMemory(first_step=3),
]


def test_what_was_done_is_written_down() -> None:
    written = json.loads(json.dumps(run_trials(random_routes(1, 10), n_inbound=1, perturbations=ALL).attrs))
    digest = hashlib.sha256(b"\0\0\0\0\0\0\xe0\x3f" * 16).hexdigest()[
        :12
    ]  # sixteen halves in IEEE 754 double precision
    assert written["perturbations"] == [
        "ClampCells(population='tb1', cells=(3, 4), rate=0.5, first_step=7, end_step=None)",
        "WeightNoise(sd=0.1, keep_signs=True, projections=('tb1_to_tb1',))",
        "CompassShift(shift=0.25, leg='home')",
        "FilterSpeed(n_steps=3, form='clean')",
        "ScaleSpeed(factor=2)",
        "TurnBody(offset=None, redraw_every=25, leg='out')",
        "Circle(centre=(1.0, 2.0), radius=3)",
        "Wall(start=(0.0, 1.0), end=(2.5, 3.0))",
        "Displace(step=5, by=(1.0, 2.0), to=None)",
        f"SetMemory(memory=<array (16,) sha256 {digest}>, step=4, mode='add')",
        "FreezeMemory(first_step=3, end_step=None)",
    ]


def test_description_of_a_memory_is_short_and_tells_memories_apart() -> None:
    many = np.linspace(0.0, 1.0, 1600).reshape(100, 16)
    one, same, other = (describe_perturbation(SetMemory(memory=m)) for m in (many, many.tolist(), many[::-1]))
    assert one == same
    assert one != other
    assert "(100, 16)" in one
    assert len(one) < 100


@pytest.mark.parametrize("perturbation", ALL, ids=lambda perturbation: type(perturbation).__name__)
def test_perturbations_do_not_change(perturbation: object) -> None:
    name = next(iter(vars(perturbation)))
    with pytest.raises(FrozenInstanceError):
        setattr(perturbation, name, None)


def test_memory_is_a_copy_of_its_own() -> None:
    given = np.full((4, 16), 0.5)
    kept = SetMemory(memory=given)
    given[:] = 0.0
    assert (kept.memory == 0.5).all()
    with pytest.raises(ValueError, match="read-only"):
        kept.memory[0] = 1.0


def test_one_row_of_memory_is_for_every_trial() -> None:
    routes = random_routes(4, 10)
    memory = np.linspace(0.0, 1.0, 16)
    out = [
        run_trials(routes, n_inbound=5, record=["memory"], perturbations=[SetMemory(memory=rows, step=3)])
        for rows in (memory, memory[None], np.tile(memory, (4, 1)))
    ]
    for other in out[1:]:
        xarray.testing.assert_equal(other, out[0])
