"""Constants of the circuit, presets and variants as data."""

import math
from dataclasses import FrozenInstanceError, fields, replace

import numpy as np
import pytest

from insectnav.central_complex import (
    CODE_2017,
    PRESETS,
    THESIS,
    VARIANTS,
    CircuitParams,
    Connectivity,
    circuit_params,
)
from insectnav.checks import InputError

NUMBERS = [field.name for field in fields(CircuitParams) if isinstance(getattr(THESIS, field.name), float)]
LIMITED = {"memory_gain": (0.0, 1.5), "memory_start": (-0.1, 1.1), "tn_preference": (-45.0, 45.0)}


def differences(params: CircuitParams, other: CircuitParams) -> dict[str, object]:
    names = (field.name for field in fields(CircuitParams))
    return {name: getattr(params, name) for name in names if getattr(params, name) != getattr(other, name)}


def test_names_are_the_promised_ones() -> None:
    assert VARIANTS == ("partially-holonomic", "non-holonomic", "fully-holonomic", "no-pontine", "idealised")
    assert PRESETS == ("thesis", "code-2017")


def test_constants_are_those_of_the_thesis() -> None:
    # Stone et al. 2017, Methods: slope and bias of each population.
    expected = {
        "tl": (6.8, 3.0),
        "cl1": (3.0, -0.5),
        "tb1": (5.0, 0.0),
        "cpu4": (5.0, 2.5),
        "pontine": (5.0, 2.5),
        "cpu1": (7.5, -1.0),
    }
    for population, slope_and_bias in expected.items():
        assert (getattr(THESIS, f"{population}_slope"), getattr(THESIS, f"{population}_bias")) == slope_and_bias
    assert (THESIS.cl1_to_tb1_strength, THESIS.tb1_to_tb1_strength) == (0.667, 0.333)
    assert (THESIS.memory_gain, THESIS.memory_start) == (0.0025, 0.5)
    assert THESIS.tn_preference == math.radians(45)


def test_presets_differ_in_motor_gain_and_memory_loss_alone() -> None:
    assert (THESIS.motor_gain, THESIS.memory_loss) == (0.5, 0.1)
    assert differences(CODE_2017, THESIS) == {"preset": "code-2017", "motor_gain": 0.25, "memory_loss": 0.125}


def test_thesis_is_the_default() -> None:
    assert circuit_params() == THESIS == CircuitParams()
    assert circuit_params("partially-holonomic", "code-2017") == CODE_2017


@pytest.mark.parametrize(
    ("variant", "expected"),
    [
        ("non-holonomic", {"is_flow_averaged": True}),
        ("fully-holonomic", {"memory_rule": "flow-times-heading"}),
        (
            "no-pontine",
            {
                "memory_rule": "backward-flow",
                "memory_gain": 0.005,
                "steering_rule": "gate",
                "cpu4_to_cpu1_strength": 1.0,
                "pontine_to_cpu1_strength": 0.0,
                "cpu1_slope": 5.0,
                "cpu1_bias": 2.5,
            },
        ),
        (
            "idealised",
            {
                "is_sigmoid": False,
                "cl1_to_tb1_strength": 0.5,
                "tb1_to_tb1_strength": 0.0,
                "memory_rule": "flow-times-heading",
                "steering_rule": "gate",
                "cpu4_to_cpu1_strength": 1.0,
                "pontine_to_cpu1_strength": 0.0,
                "motor_gain": 1.0,
            },
        ),
    ],
)
def test_variant_is_a_few_differences(variant: str, expected: dict) -> None:
    assert differences(circuit_params(variant), THESIS) == {"variant": variant} | expected
    in_code = {"preset": "code-2017", "motor_gain": 0.25, "memory_loss": 0.125}
    assert differences(circuit_params(variant, "code-2017"), THESIS) == {"variant": variant} | in_code | expected


@pytest.mark.parametrize(
    ("name", "suggestion"),
    [
        ("fully_holonomic", "fully-holonomic"),
        ("Partially-Holonomic", "partially-holonomic"),
        ("idealized", "idealised"),
        ("no-pontin", "no-pontine"),
    ],
)
def test_unknown_variant_gets_a_suggestion(name: str, suggestion: str) -> None:
    with pytest.raises(InputError, match=rf"^variant '{name}' is unknown.*\(did you mean {suggestion}\?\)$"):
        circuit_params(name)


def test_unknown_preset_gets_a_suggestion() -> None:
    with pytest.raises(InputError, match=r"^preset 'code2017' is unknown.*\(did you mean code-2017\?\)$"):
        circuit_params(preset="code2017")


@pytest.mark.parametrize("name", ["", "chaos", None, 3])
def test_name_without_likeness_lists_the_choices(name: object) -> None:
    with pytest.raises(InputError, match=r"expected one of thesis, code-2017$"):
        circuit_params(preset=name)


@pytest.mark.parametrize("rule", ["memory_rule", "steering_rule"])
def test_unknown_rule_is_refused(rule: str) -> None:
    with pytest.raises(InputError, match=rf"^{rule} 'subtrat' is unknown"):
        replace(THESIS, **{rule: "subtrat"})


@pytest.mark.parametrize("name", LIMITED)
def test_number_out_of_its_range_is_refused(name: str) -> None:
    for value in LIMITED[name]:
        with pytest.raises(InputError, match=rf"^{name} is "):
            replace(THESIS, **{name: value})


def test_constant_that_is_no_number_is_refused() -> None:
    accepted = []
    for name in NUMBERS:
        try:
            replace(THESIS, **{name: math.nan})
        except InputError as error:
            assert name in str(error)
        else:
            accepted.append(name)
    assert accepted == []


def test_constants_are_frozen() -> None:
    with pytest.raises(FrozenInstanceError):
        THESIS.motor_gain = 1.0
    with pytest.raises(TypeError):
        CircuitParams("idealised")


def test_equal_constants_are_one_key() -> None:
    assert len({circuit_params(variant, preset) for variant in VARIANTS for preset in PRESETS}) == 10
    assert hash(circuit_params()) == hash(THESIS)
    assert len({THESIS, replace(THESIS, memory_loss=0.2), replace(THESIS, memory_loss=0.1)}) == 2


def test_another_wiring_makes_other_constants() -> None:
    rewired = replace(THESIS, connectivity=Connectivity(cpu1_to_motor=np.ones((2, 16))))
    assert rewired != THESIS
    assert hash(rewired) == hash(replace(rewired))
