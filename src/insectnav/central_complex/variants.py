"""The five published circuits and the two sets of constants, as differences from the default."""

from dataclasses import replace
from typing import Any

from insectnav.central_complex.parameters import CircuitParams
from insectnav.checks import check_choice

# Science: Stone et al. 2017, Methods, Supplementary Discussion and Extended Data Fig. 10d–f, and their 2017 code.
_VARIANTS: dict[str, dict[str, Any]] = {
    "partially-holonomic": {},
    "non-holonomic": {"is_flow_averaged": True},
    "fully-holonomic": {"memory_rule": "flow-times-heading"},
    "no-pontine": {
        "memory_rule": "backward-flow",
        "memory_gain": 0.005,
        "steering_rule": "gate",
        "cpu4_to_cpu1_strength": 1.0,
        "pontine_to_cpu1_strength": 0.0,
        "cpu1_slope": 5.0,
        "cpu1_bias": 2.5,
    },
    "idealised": {
        "is_sigmoid": False,
        "cl1_to_tb1_strength": 0.5,  # with linear cells TB1_i = (1 − cos(θ − d_i)) / 2
        "tb1_to_tb1_strength": 0.0,
        "memory_rule": "flow-times-heading",
        "steering_rule": "gate",
        "cpu4_to_cpu1_strength": 1.0,
        "pontine_to_cpu1_strength": 0.0,
        "motor_gain": 1.0,
    },
}
_PRESETS: dict[str, dict[str, Any]] = {
    "thesis": {"motor_gain": 0.5, "memory_loss": 0.1},
    "code-2017": {"motor_gain": 0.25, "memory_loss": 0.125},
}

VARIANTS = tuple(_VARIANTS)
PRESETS = tuple(_PRESETS)


def circuit_params(variant: str = "partially-holonomic", preset: str = "thesis") -> CircuitParams:
    """Constants of a published circuit.

    Parameters
    ----------
    variant : {"partially-holonomic", "non-holonomic", "fully-holonomic", "no-pontine", "idealised"}
        Which circuit: the one of the paper, or one of the four it is compared with.
    preset : {"thesis", "code-2017"}
        Where the text and the authors' code differ (motor gain m and memory loss k), which to follow. The thesis'
        values give the published tortuosity, 1.150. The idealised circuit has m = 1 under both.

    Raises
    ------
    InputError
        If a name is unknown.
    """
    check_choice("variant", variant, VARIANTS)
    check_choice("preset", preset, PRESETS)
    names = {"variant": variant, "preset": preset}
    return replace(CircuitParams(), **(names | _PRESETS[preset] | _VARIANTS[variant]))


THESIS = circuit_params()
CODE_2017 = circuit_params(preset="code-2017")
