"""Plain NumPy central complex path integrator: one trial, one call a step, float64.

The second implementation that the package is tested against, and the baseline of its benchmark. It shares no code
with the package.

Notes
-----
Stone et al. (2017), Current Biology 27:3069, doi 10.1016/j.cub.2017.08.052, and chapter 5 of the thesis. Where the
thesis and the authors' published code differ, `THESIS` and `CODE_2017` hold the two sets of numbers.

Heading is in radians, clockwise from +y, in [-pi, pi); its unit vector is (sin, cos); a positive turn is to the right.
Distances and times are in steps.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

Array = NDArray[np.float64]

VARIANTS = ("partially-holonomic", "non-holonomic", "fully-holonomic", "no-pontine", "idealised")
RATES = ("tl", "cl1", "tb1", "tn1", "tn2", "memory", "cpu4", "pontine", "cpu1", "motor")
USES_TN1 = ("fully-holonomic", "no-pontine", "idealised")

PREFERRED = np.arange(16) % 8 * np.pi / 4  # [rad] of TL and CL1
CL1_TO_TB1 = 0.667
TB1_TO_TB1 = 0.333


@dataclass(frozen=True, kw_only=True)
class OracleParams:
    """Constants of the circuit and of the agent; rate = sigmoid(slope * input - bias)."""

    variant: str = "partially-holonomic"
    slope_tl: float = 6.8
    bias_tl: float = 3.0
    slope_cl1: float = 3.0
    bias_cl1: float = -0.5
    slope_tb1: float = 5.0
    bias_tb1: float = 0.0
    slope_cpu4: float = 5.0
    bias_cpu4: float = 2.5
    slope_pontine: float = 5.0
    bias_pontine: float = 2.5
    slope_cpu1: float = 7.5
    bias_cpu1: float = -1.0
    gain: float = 0.0025  # h [1/step]
    loss: float = 0.1  # k, thesis
    motor: float = 0.5  # m [rad], thesis
    phi_tn: float = np.pi / 4  # [rad] preferred flow direction of TN, either side of the body axis
    drag: float = 0.15  # F_D
    acceleration: float = 0.1  # [step/step^2] homing

    def __post_init__(self) -> None:
        if self.variant not in VARIANTS:
            raise ValueError(f"variant is {self.variant!r}, expected one of {VARIANTS}")


THESIS = OracleParams()
CODE_2017 = OracleParams(motor=0.25, loss=0.125)


def variant_params(variant: str, base: OracleParams = THESIS) -> OracleParams:
    """`base` with the constants that the variant changes."""
    changes: dict[str, dict[str, float]] = {
        "no-pontine": {"gain": 0.005, "slope_cpu1": 5.0, "bias_cpu1": 2.5},
        "idealised": {"motor": 1.0},
    }
    return replace(base, variant=variant, **changes.get(variant, {}))


def connection_matrices() -> dict[str, Array]:
    """Every connection matrix, rows = target; `*_CPU1` and `W_motor` have CPU1 in index order 0..15.

    Notes
    -----
    CPU1 0..7 and 8..15 are, in anatomical naming, CPU1b second, CPU1a 0..13, CPU1b first.
    """
    cells = np.arange(8)
    one = np.eye(8)
    none = np.zeros((8, 8))
    between = (cells[:, None] - cells[None, :]) * np.pi / 4
    cpu1 = {
        "W_TB1": np.vstack([one, one]),
        "W_CPU4": np.block([[none, one[(cells - 1) % 8]], [one[(cells + 1) % 8], none]]),
        "W_pontin": np.block([[none, one[(cells + 3) % 8]], [one[(cells + 5) % 8], none]]),
    }
    motor = np.repeat(np.eye(2), 8, axis=1)
    weights = {
        "W_CL1_TB1": np.hstack([one, one]),
        "W_TB1_TB1": (1 - np.cos(between)) / 2,
        "W_TB1_CPU4": np.vstack([one, one]),
        "W_TN_CPU4": np.repeat(np.eye(2), 8, axis=0),
        "W_CPU4_pontin": np.eye(16),
        "W_motor": motor,
        "W_CPU1a_motor": motor[:, 1:15],
        "W_CPU1b_motor": motor[:, [15, 0]],
    }
    for name, matrix in cpu1.items():
        weights[f"{name}_CPU1"] = matrix
        weights[f"{name}_CPU1a"] = matrix[1:15]
        weights[f"{name}_CPU1b"] = matrix[[15, 0]]
    return weights


WEIGHTS = connection_matrices()


def wrap(angle: float) -> float:
    """Angle in [-pi, pi) [rad]."""
    wrapped = (angle + np.pi) % (2 * np.pi) - np.pi
    return -np.pi if wrapped >= np.pi else wrapped  # the remainder of -eps rounds to 2 pi


def unit_vector(heading: float) -> Array:
    """(sin, cos) of the heading."""
    return np.array([np.sin(heading), np.cos(heading)])


def initial_state() -> tuple[Array, Array]:
    """TB1 (8,) silent and memory (16,) half full."""
    return np.zeros(8), np.full(16, 0.5)


def sigmoid(current: Array, slope: float, bias: float) -> Array:
    """1 / (1 + exp(bias - slope * current))."""
    return 1 / (1 + np.exp(-(slope * current - bias)))


def noisy(rate: Array, noise: float, rng: np.random.Generator | None) -> Array:
    """Rate plus a normal draw per cell, clipped to [0, 1]."""
    if noise > 0:
        rate = rate + rng.normal(0, noise, rate.size)
    return np.clip(rate, 0, 1)


def compass(
    tb1: Array, heading: float, params: OracleParams, noise: float, rng: np.random.Generator | None
) -> tuple[Array, Array, Array]:
    """TL (16,), CL1 (16,) and TB1 (8,) at this heading."""
    p = params
    towards = np.cos(heading - PREFERRED)
    if p.variant == "idealised":
        tl = noisy((1 + towards) / 2, noise, rng)
        cl1 = noisy(1 - tl, noise, rng)
        tb1 = noisy(WEIGHTS["W_CL1_TB1"] @ cl1 / 2, noise, rng)
        return tl, cl1, tb1
    tl = noisy(sigmoid(towards, p.slope_tl, p.bias_tl), noise, rng)
    cl1 = noisy(sigmoid(-tl, p.slope_cl1, p.bias_cl1), noise, rng)
    current = CL1_TO_TB1 * (WEIGHTS["W_CL1_TB1"] @ cl1) - TB1_TO_TB1 * (WEIGHTS["W_TB1_TB1"] @ tb1)
    tb1 = noisy(sigmoid(current, p.slope_tb1, p.bias_tb1), noise, rng)
    return tl, cl1, tb1


def flow_neurons(
    heading: float, velocity: Array, params: OracleParams, noise: float, rng: np.random.Generator | None
) -> tuple[Array, Array]:
    """TN1 (2,) and TN2 (2,); index 0 looks to the right of the body axis."""
    right = unit_vector(heading + params.phi_tn)
    left = unit_vector(heading - params.phi_tn)
    flow = np.array([right @ velocity, left @ velocity])
    if params.variant == "non-holonomic":
        flow = np.full(2, flow.mean())
    tn1 = noisy((1 - flow) / 2, noise if params.variant in USES_TN1 else 0.0, rng)
    tn2 = noisy(flow, noise, rng)
    return tn1, tn2


def update_memory(memory: Array, tb1: Array, tn1: Array, tn2: Array, params: OracleParams) -> Array:
    """Memory (16,) after this step, in [0, 1]."""
    h, k = params.gain, params.loss
    direction = WEIGHTS["W_TB1_CPU4"] @ tb1
    tn1 = WEIGHTS["W_TN_CPU4"] @ tn1
    tn2 = WEIGHTS["W_TN_CPU4"] @ tn2
    if params.variant in ("fully-holonomic", "idealised"):
        memory = memory + h * (0.5 - tn1) * (0.5 - direction)
    elif params.variant == "no-pontine":
        memory = memory + h * np.clip(0.5 - tn1, 0, 1) * (1 - direction) - h / 4 * tn2
    else:
        memory = memory + h * np.clip(tn2 - direction, 0, 1) - h * k
    return np.clip(memory, 0, 1)


def steering(
    tb1: Array, memory: Array, params: OracleParams, noise: float, rng: np.random.Generator | None
) -> tuple[Array, Array, Array, float]:
    """CPU4, pontine, CPU1 (16,) and the turn [rad]; pontine is zero in the variants without it."""
    p = params
    direction = WEIGHTS["W_TB1_CPU1"] @ tb1
    if p.variant == "idealised":
        cpu4 = noisy(memory, noise, rng)
        pontine = np.zeros(16)
        cpu1 = noisy((WEIGHTS["W_CPU4_CPU1"] @ cpu4) * (1 - direction), noise, rng)
    else:
        cpu4 = noisy(sigmoid(memory, p.slope_cpu4, p.bias_cpu4), noise, rng)
        if p.variant == "no-pontine":
            pontine = np.zeros(16)
            current = (WEIGHTS["W_CPU4_CPU1"] @ cpu4) * (1 - direction)
        else:
            pontine = noisy(sigmoid(WEIGHTS["W_CPU4_pontin"] @ cpu4, p.slope_pontine, p.bias_pontine), noise, rng)
            current = 0.5 * (WEIGHTS["W_CPU4_CPU1"] @ cpu4) - 0.5 * (WEIGHTS["W_pontin_CPU1"] @ pontine) - direction
        cpu1 = noisy(sigmoid(current, p.slope_cpu1, p.bias_cpu1), noise, rng)
    to_right, to_left = WEIGHTS["W_motor"] @ cpu1
    return cpu4, pontine, cpu1, float(p.motor * (to_right - to_left))


def step(
    tb1: Array,
    memory: Array,
    heading: float,
    velocity: Array,
    params: OracleParams,
    noise: float = 0.0,
    rng: np.random.Generator | None = None,
) -> tuple[Array, Array, dict[str, Any]]:
    """TB1, memory and all rates after one time step.

    Parameters
    ----------
    tb1 : (8,) array
        Rates of the step before.
    memory : (16,) array
    heading : float [rad]
    velocity : (2,) array [step/step]
    params : OracleParams
    noise : float
        Standard deviation, the same for all cells; no draw is made at zero.
    rng : numpy Generator
        Only used with noise.

    Returns
    -------
    tb1 : (8,) array
    memory : (16,) array
    rates : dict
        One array per population, and `motor`, the turn [rad].
    """
    tl, cl1, tb1 = compass(tb1, heading, params, noise, rng)
    tn1, tn2 = flow_neurons(heading, velocity, params, noise, rng)
    memory = update_memory(memory, tb1, tn1, tn2, params)
    cpu4, pontine, cpu1, turn = steering(tb1, memory, params, noise, rng)
    values = (tl, cl1, tb1, tn1, tn2, memory, cpu4, pontine, cpu1, turn)
    return tb1, memory, dict(zip(RATES, values, strict=True))


def move(heading: float, velocity: Array, turn: float, acceleration: float, drag: float) -> tuple[float, Array]:
    """Heading [rad] and velocity (2,) after turning, then accelerating along the new heading."""
    heading = wrap(heading + turn)
    return heading, (1 - drag) * (velocity + acceleration * unit_vector(heading))


def run_trial(
    heading: Array,
    velocity: Array,
    n_inbound: int,
    params: OracleParams,
    noise: float = 0.0,
    rng: np.random.Generator | None = None,
    record: bool = False,
) -> dict[str, Array]:
    """One trip out along a given route and `n_inbound` steps of steering home.

    Parameters
    ----------
    heading : (T,) array [rad]
    velocity : (T, 2) array [step/step]
    n_inbound : int
    params : OracleParams
    noise : float
        Standard deviation of the rates.
    rng : numpy Generator
    record : bool
        Also return the rates of every step.

    Returns
    -------
    dict
        `heading` (T + n_inbound,) [rad], `position` (T + n_inbound, 2) [step], `memory_at_turn` (16,) and, if recorded,
        each of `RATES` as (T + n_inbound, n), `motor` as (T + n_inbound,). Homing row T + i holds the rates that
        the cells had before the turn that leads to heading T + i: its first one sees the turning point again.
    """
    headings, velocities = list(heading), list(velocity)
    recorded: list[dict[str, Any]] = []
    tb1, memory = initial_state()
    for theta, v in zip(heading, velocity, strict=True):
        tb1, memory, rates = step(tb1, memory, theta, v, params, noise, rng)
        if record:
            recorded.append(rates)
    trial = {"memory_at_turn": memory}
    for _ in range(n_inbound):
        tb1, memory, rates = step(tb1, memory, headings[-1], velocities[-1], params, noise, rng)
        theta, v = move(headings[-1], velocities[-1], rates["motor"], params.acceleration, params.drag)
        headings.append(theta)
        velocities.append(v)
        if record:
            recorded.append(rates)
    trial["heading"] = np.array(headings)
    trial["position"] = np.cumsum(velocities, axis=0)
    if record:
        trial |= {name: np.array([rates[name] for rates in recorded]) for name in RATES}
    return trial


def decode(memory: Array, params: OracleParams) -> tuple[float, float]:
    """Bearing from nest to agent [rad] and distance [step]; the home vector points the opposite way.

    Notes
    -----
    `F = sum_j s_j exp(-i j pi/4)`, bearing = -arg F: the published code returns arg F, its mirror image.
    Where the memory multiplies flow and direction (fully holonomic, idealised, no pontine), cos² summed over eight
    columns gives distance |F| / h; where it subtracts them, |F| / (2 h).
    """
    total = np.roll(memory[:8], 1) + np.roll(memory[8:], -1)
    first = np.fft.fft(total)[1]
    per_step = (
        2 if params.variant in ("partially-holonomic", "non-holonomic") else 1
    )  # products: exact for linear cells
    return wrap(-np.angle(first)), float(np.abs(first) / (per_step * params.gain))


def random_route(n_steps: int, rng: np.random.Generator, drag: float = OracleParams.drag) -> tuple[Array, Array]:
    """Heading (T,) [rad] and velocity (T, 2) of a random outbound route that starts at rest, heading 0.

    Notes
    -----
    Turns r_t = 0.4 r_{t-1} + von Mises(0, kappa = 100), the first not taken but kept by the filter. Acceleration is a
    not-a-knot cubic spline through T // 50 (4 up to T = 200) draws from U(0, 0.15), which may overshoot its limits.
    """
    draws = rng.vonmises(0, 100, n_steps)
    n_knots = 4 if n_steps <= 200 else n_steps // 50
    knots = np.linspace(0, n_steps - 1, n_knots)
    acceleration = CubicSpline(knots, rng.uniform(0, 0.15, n_knots), bc_type="not-a-knot")(np.arange(n_steps))
    heading = np.zeros(n_steps)
    velocity = np.zeros((n_steps, 2))
    turn = draws[0]
    for t in range(1, n_steps):
        turn = 0.4 * turn + draws[t]
        heading[t], velocity[t] = move(heading[t - 1], velocity[t - 1], turn, acceleration[t], drag)
    return heading, velocity
