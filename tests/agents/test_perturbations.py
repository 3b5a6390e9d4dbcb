"""Clamped cells: held exactly as long as asked, felt by what they feed, and no trace where nothing is clamped."""

import json
from dataclasses import replace

import numpy as np
import pytest
import xarray

from insectnav.agents import ClampCells, random_routes, run_trials
from insectnav.agents.motion import MotionParams
from insectnav.central_complex import CODE_2017, N_CELLS, POPULATIONS, THESIS, circuit_params
from insectnav.checks import InputError

N_OUT, N_HOME, N_TRIALS = 80, 60, 19  # a full register of lanes and three more
WITH_RATE = tuple(name for name in POPULATIONS if name not in ("memory", "motor"))
DTYPES = ("float32", "float64")


@pytest.fixture(scope="module")
def routes() -> xarray.Dataset:
    return random_routes(N_TRIALS, N_OUT, seed=6)


def fly(routes: xarray.Dataset, *clamps: ClampCells, **options) -> xarray.Dataset:
    options = {"n_inbound": N_HOME, "noise": 0.1, "seed": 2, "record": POPULATIONS} | options
    return run_trials(routes, perturbations=clamps, **options)


# What is held, and when.


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("population", WITH_RATE)
def test_cells_are_held_exactly_from_first_to_before_end(population: str, dtype: str, routes: xarray.Dataset):
    cell = N_CELLS[population] - 1
    held = ClampCells(population=population, cells=(cell,), rate=0.3, first_step=50, end_step=90)
    clamped, free = fly(routes, held, dtype=dtype), fly(routes, dtype=dtype)
    rates = clamped[population].values
    assert (rates[:, 50:90, cell] == np.dtype(dtype).type(0.3)).all()
    assert (rates[:, [49, 90], cell] != np.dtype(dtype).type(0.3)).all()
    for name in POPULATIONS:
        np.testing.assert_array_equal(clamped[name][:, :50], free[name][:, :50], err_msg=name)
    neighbours = np.arange(N_CELLS[population]) != cell  # of the same layer: they hear of it a step later at most
    np.testing.assert_array_equal(rates[:, 50, neighbours], free[population].values[:, 50, neighbours])


@pytest.mark.parametrize("rate", [0.0, 1.0])
@pytest.mark.parametrize("variant", ["fully-holonomic", "no-pontine", "idealised"])
def test_whole_population_is_held_to_the_end_by_default(variant: str, rate: float, routes: xarray.Dataset):
    has_pontine = circuit_params(variant).pontine_to_cpu1_strength > 0.0
    for population in WITH_RATE if has_pontine else set(WITH_RATE) - {"pontine"}:
        held = ClampCells(population=population, rate=rate, first_step=N_OUT - 5)
        rates = fly(routes, held, circuit=circuit_params(variant))[population].values
        assert (rates[:, N_OUT - 5 :] == rate).all()
        assert (rates[:, : N_OUT - 5] != rate).any()


def test_whole_trial_is_held_by_default(routes: xarray.Dataset):
    assert (fly(routes, ClampCells(population="tn2", rate=0.25)).tn2 == 0.25).all()


def test_later_clamp_wins_while_it_lasts(routes: xarray.Dataset):
    outer = ClampCells(population="cpu1", rate=0.25, first_step=10, end_step=100)
    inner = ClampCells(population="cpu1", cells=(3, 7), rate=0.75, first_step=40, end_step=60)
    rates = fly(routes, outer, inner).cpu1.values
    others = np.delete(np.arange(16), [3, 7])
    assert (rates[:, 40:60, [3, 7]] == 0.75).all()
    assert (rates[:, 10:100][..., others] == 0.25).all()
    assert (rates[:, 10:40] == 0.25).all()
    assert (rates[:, 60:100] == 0.25).all()
    assert (fly(routes, inner, outer).cpu1.values[:, 10:100] == 0.25).all()


def test_cells_may_repeat_and_have_any_order(routes: xarray.Dataset):
    one = fly(routes, ClampCells(population="cpu4", cells=(9, 2, 9), rate=0.5))
    two = fly(routes, ClampCells(population="cpu4", cells=(2, 9), rate=0.5))
    xarray.testing.assert_equal(one, two)


def test_clamped_trials_in_batches_are_as_one_by_one(routes: xarray.Dataset):
    held = ClampCells(population="tb1", cells=(1, 2), rate=1.0, first_step=30, end_step=70)
    whole = fly(routes, held)
    for trial in (0, 7, 18):
        xarray.testing.assert_equal(fly(routes.isel(trial=[trial]), held), whole.isel(trial=[trial]))


# What follows from it.


@pytest.mark.parametrize("params", [THESIS, CODE_2017])
def test_held_steering_cells_turn_the_agent_by_their_sum(params, routes: xarray.Dataset):
    # turn = m · (Σ CPU1[0:8] − Σ CPU1[8:16]); positive is to the right, and headings are clockwise.
    right = ClampCells(population="cpu1", cells=(2,), rate=1.0, first_step=N_OUT)
    all_others = ClampCells(population="cpu1", rate=0.5, first_step=N_OUT)
    out = fly(routes, all_others, right, circuit=params, dtype="float64")
    turns = np.diff(out.heading.values[:, N_OUT - 1 :], axis=1)
    np.testing.assert_allclose(np.angle(np.exp(1j * turns)), params.motor_gain * 0.5, atol=1e-9)
    np.testing.assert_allclose(out.motor.values[:, N_OUT:], params.motor_gain * 0.5, atol=1e-12)


def test_one_injected_steering_cell_bends_the_path_to_its_side(routes: xarray.Dataset):
    free = fly(routes, noise=0.0)
    for cells, side in (((4,), 1), ((12,), -1)):
        held = ClampCells(population="cpu1", cells=cells, rate=1.0, first_step=N_OUT, end_step=N_OUT + 1)
        change = (fly(routes, held, noise=0.0).motor - free.motor).values[:, N_OUT]
        assert (side * change > 0.0).all()  # no rate is 1 already
        expected = THESIS.motor_gain * side * (1.0 - free.cpu1.values[:, N_OUT, cells[0]])
        np.testing.assert_allclose(change, expected, atol=1e-5)


def test_agent_that_always_turns_alike_walks_a_circle(routes: xarray.Dataset):
    held = (
        ClampCells(population="cpu1", rate=0.0, first_step=N_OUT),
        ClampCells(population="cpu1", cells=(0,), rate=0.4, first_step=N_OUT),
    )
    motion = MotionParams()
    out = fly(routes, *held, n_inbound=400, dtype="float64")
    # The velocity settles to v = (1 − F)(v' + a u) with v' turned by δ less: |v| = (1 − F) a / |1 − (1 − F) e^(−iδ)|.
    turn, kept = THESIS.motor_gain * 0.4, 1.0 - motion.drag
    speed = kept * motion.acceleration / abs(1.0 - kept * np.exp(-1j * turn))
    steps = np.linalg.norm(np.diff(out.position.values[:, -100:], axis=1), axis=-1)
    np.testing.assert_allclose(steps, speed, rtol=1e-9)


def test_silenced_pontine_cells_are_as_good_as_none(routes: xarray.Dataset):
    silenced = fly(routes, ClampCells(population="pontine", rate=0.0), noise=0.0)
    without = fly(routes, circuit=replace(THESIS, pontine_to_cpu1_strength=0.0), noise=0.0)
    for name in ("cpu1", "motor", "heading", "position", "memory", "closest_distance"):
        np.testing.assert_array_equal(silenced[name], without[name], err_msg=name)
    assert not np.array_equal(fly(routes, noise=0.0).cpu1, without.cpu1)


def test_silenced_speed_cells_leave_the_memory_to_leak(routes: xarray.Dataset):
    # Nothing charges it: a loss of h k in each step is all there is.
    out = fly(routes, ClampCells(population="tn2", rate=0.0), dtype="float64")
    leak = THESIS.memory_gain * THESIS.memory_loss
    expected = 0.5 - leak * np.arange(1, N_OUT + N_HOME + 1)
    np.testing.assert_allclose(out.memory.values, np.broadcast_to(expected[:, None], out.memory.shape), atol=1e-12)
    np.testing.assert_allclose(out.home_vector_at_turn, 0.0, atol=1e-9)


def test_steering_cells_held_on_the_way_out_leave_no_trace(routes: xarray.Dataset):
    # Steering is not connected then, and they keep nothing: even the noise that follows is the same.
    held = ClampCells(population="cpu1", rate=1.0, first_step=20, end_step=N_OUT)
    clamped, free = fly(routes, held), fly(routes)
    for name in ("heading", "position", "memory", "closest_distance", "tb1"):
        np.testing.assert_array_equal(clamped[name], free[name], err_msg=name)
    np.testing.assert_array_equal(clamped.cpu1[:, N_OUT:], free.cpu1[:, N_OUT:])
    assert (clamped.motor[:, 20:N_OUT] == 0.0).all()


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize(
    "clamps",
    [
        (),
        (ClampCells(population="tb1", rate=1.0, first_step=30, end_step=30),),
        (ClampCells(population="tb1", rate=1.0, first_step=N_OUT + N_HOME),),
        (ClampCells(population="tb1", rate=1.0, first_step=10**12, end_step=10**12 + 1),),
        (ClampCells(population="tb1", cells=(), rate=1.0),),
    ],
)
def test_nothing_clamped_changes_not_a_bit(clamps: tuple, dtype: str, routes: xarray.Dataset):
    plain = run_trials(routes, n_inbound=N_HOME, noise=0.1, seed=2, record=POPULATIONS, dtype=dtype)
    xarray.testing.assert_equal(fly(routes, *clamps, dtype=dtype), plain)


def test_perturbations_are_written_down(routes: xarray.Dataset):
    held = ClampCells(population="tb1", cells=(5,), rate=0.125, first_step=3, end_step=9)
    (written,) = json.loads(json.dumps(fly(routes, held).attrs))["perturbations"]
    for word in ("tb1", "5", "0.125", "3", "9"):
        assert word in written


# Bad input.


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"population": "cpu2"}, r"population to clamp 'cpu2' is unknown: expected one of .*tb1.*did you mean cpu"),
        ({"population": "memory"}, "population to clamp 'memory' is unknown"),
        ({"population": "motor"}, "population to clamp 'motor' is unknown"),
        ({"rate": 1.5}, "clamped rate is 1.5, expected 0 to 1"),
        ({"rate": -0.1}, "clamped rate is -0.1"),
        ({"rate": np.nan}, "clamped rate is nan"),
        ({"cells": (16,)}, "cell of cpu1 is 16, expected 0 to 15"),
        ({"cells": (0, -1)}, "cell of cpu1 is -1"),
        ({"population": "tb1", "cells": (8,)}, "cell of tb1 is 8, expected 0 to 7"),
        ({"cells": (1.5,)}, "cell of cpu1 is 1.5"),
        ({"cells": ("1",)}, "cell of cpu1 "),
        ({"cells": 3}, "cells"),
        ({"first_step": -1}, "first_step is -1"),
        ({"first_step": 1.5}, "first_step is 1.5"),
        ({"first_step": 10, "end_step": 9}, "end_step is 9, expected a whole number of at least 10"),
    ],
)
def test_cells_that_cannot_be_held_are_refused_in_a_sentence(change: dict, message: str):
    with pytest.raises(InputError, match=f"^{message}"):
        ClampCells(**{"population": "cpu1", "rate": 1.0} | change)


@pytest.mark.parametrize("perturbations", [("tb1",), [{"population": "tb1"}], ClampCells(population="tb1", rate=1.0)])
def test_what_is_no_list_of_clamps_is_refused_in_a_sentence(perturbations: object, routes: xarray.Dataset):
    with pytest.raises(InputError, match=r"^perturbations .*expected"):
        run_trials(routes, n_inbound=1, perturbations=perturbations)
