"""Every constant of the circuit, with its source."""

from dataclasses import dataclass

import numpy as np

from insectnav.central_complex.connectivity import STANDARD_WIRING, Connectivity
from insectnav.checks import check_choice, check_finite, check_range

MEMORY_RULES = ("inhibited-flow", "flow-times-heading", "backward-flow")
STEERING_RULES = ("subtract", "gate")


@dataclass(frozen=True, kw_only=True)
class CircuitParams:
    """Constants of the path integrator; the defaults are those of the thesis.

    A cell's rate is ``clip(σ(slope · input − bias) + noise, 0, 1)``, or ``clip(input + noise, 0, 1)`` where
    ``is_sigmoid`` is off. `insectnav.central_complex.circuit_params` makes the published variants.

    Raises
    ------
    InputError
        If a rule is unknown or a number is out of its range.

    Notes
    -----
    [1] T. Stone's thesis, chapter 5, Methods and Extended Data Fig. 6, published as Stone et al. 2017, Current Biology
    27:3069, doi 10.1016/j.cub.2017.08.052; [2] the authors' public 2017 code, where the text does not give the value.
    """

    variant: str = "partially-holonomic"
    preset: str = "thesis"

    tl_slope: float = 6.8  # [2]
    tl_bias: float = 3.0  # [2]
    cl1_slope: float = 3.0  # [2]
    cl1_bias: float = -0.5  # [2]
    tb1_slope: float = 5.0  # [2]
    tb1_bias: float = 0.0  # [2]
    cpu4_slope: float = 5.0  # [2]
    cpu4_bias: float = 2.5  # [2]
    pontine_slope: float = 5.0  # [1] Ext. Data Fig. 6: as CPU4
    pontine_bias: float = 2.5  # [1] Ext. Data Fig. 6: as CPU4
    cpu1_slope: float = 7.5  # [2]
    cpu1_bias: float = -1.0  # [2]
    is_sigmoid: bool = True  # [1] off in the idealised circuit

    cl1_to_tb1_strength: float = 0.667  # [2]
    tb1_to_tb1_strength: float = 0.333  # [2]
    cpu4_to_cpu1_strength: float = 0.5  # [2]
    pontine_to_cpu1_strength: float = 0.5  # [2]; 0 removes the pontine cells
    tb1_to_cpu1_strength: float = 1.0  # [1]

    tn_preference: float = np.pi / 4.0  # [rad] [1] φ_TN, preferred expansion either side of the body axis
    is_flow_averaged: bool = False  # [1] Ext. Data Fig. 10d: no separate right and left speed

    memory_rule: str = "inhibited-flow"  # [1] how a step charges the memory: see `circuit_kernel.update_memory`
    memory_gain: float = 0.0025  # [1/step] h [2]
    memory_loss: float = 0.1  # [gain] k [1]; 0.125 in [2]
    memory_start: float = 0.5  # [1]
    steering_rule: str = "subtract"  # [1] TB1 is subtracted from the memory, or multiplies it ("gate")
    motor_gain: float = 0.5  # [rad] m [1]; 0.25 in [2]

    connectivity: Connectivity = STANDARD_WIRING  # [1] Ext. Data Fig. 6b

    def __post_init__(self) -> None:
        check_choice("memory_rule", self.memory_rule, MEMORY_RULES)
        check_choice("steering_rule", self.steering_rule, STEERING_RULES)
        for name, value in vars(self).items():
            if isinstance(value, float):
                check_finite(name, value)
        check_range("memory_gain", self.memory_gain, 1e-9, 1.0, "per step")
        check_range("memory_start", self.memory_start, 0.0, 1.0)
        check_range("tn_preference", self.tn_preference, -2.0 * np.pi, 2.0 * np.pi, "rad")
