"""The bee's central complex as a path integrator: cells, wiring, one step, and reading its memory."""

from insectnav.central_complex.circuit import CircuitState, Rates, Senses, initial_state, step
from insectnav.central_complex.connectivity import Connectivity
from insectnav.central_complex.decoding import WaggleDance, decode_home_vector, decode_waggle_dance
from insectnav.central_complex.layers import N_CELLS, POPULATIONS
from insectnav.central_complex.parameters import CircuitParams
from insectnav.central_complex.variants import CODE_2017, PRESETS, THESIS, VARIANTS, circuit_params

__all__ = [
    "CODE_2017",
    "N_CELLS",
    "POPULATIONS",
    "PRESETS",
    "THESIS",
    "VARIANTS",
    "CircuitParams",
    "CircuitState",
    "Connectivity",
    "Rates",
    "Senses",
    "WaggleDance",
    "circuit_params",
    "decode_home_vector",
    "decode_waggle_dance",
    "initial_state",
    "step",
]
