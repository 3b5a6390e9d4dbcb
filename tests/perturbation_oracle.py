"""Perturbed trials of the plain NumPy path integrator: one noise-free trial, float64, step by step.

Written from the descriptions of the perturbations and from `oracle` alone; it shares no code with the package.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

import oracle
from oracle import Array, OracleParams, unit_vector, wrap

SKIN = 0.01  # [step] left to the surface of obstacles


def run_trial(
    heading: Array,
    velocity: Array,
    n_inbound: int,
    params: OracleParams,
    *,
    speed: float = 1.0,
    filter_steps: int = 1,
    shift: float = 0.0,
    shift_legs: Sequence[str] = (),
    body: Array | None = None,
    is_body_turned_home: bool = False,
    carried: Mapping[int, tuple[float, Array]] | None = None,
    memories: Mapping[int, tuple[str, Array]] | None = None,
    frozen: range = range(0),
    obstacles: Sequence[tuple[Array, Array, float]] = (),
) -> dict[str, Array]:
    """Heading of the body, position and memory after each step.

    Parameters
    ----------
    heading, velocity, n_inbound, params
        As of `oracle.run_trial`.
    body : (T + n_inbound,) array, optional [rad]
        Heading of the body minus that of the course.
    carried : step to (share of the position that stays, vector added)
    memories : step to (mode, memory (16,))
    obstacles : of (one end, the other end, radius)
        A wall has radius 0, a circle the same point twice.
    """
    n_out = len(heading)
    body = np.zeros(n_out + n_inbound) if body is None else body
    tb1, memory = oracle.initial_state()
    start, position, flow_seen = memory, np.zeros(2), np.zeros(2)
    last_turn, sides = 0.0, [0] * len(obstacles)
    rows: dict[str, list[Any]] = {"heading": [], "position": [], "memory": []}
    theta, v = 0.0, np.zeros(2)
    for t in range(n_out + n_inbound):
        leg = "out" if t < n_out else "home"
        if leg == "out":
            last_turn = wrap(heading[t] - heading[t - 1]) if t else 0.0
            theta, v = heading[t], speed * velocity[t]
        elif t == n_out:
            last_turn = 0.0
            if not is_body_turned_home:
                theta = wrap(theta + body[t - 1])
        if carried and t in carried:
            position = carried[t][0] * position + carried[t][1]
        if memories and t in memories:
            memory = set_memory(memory, *memories[t], start)
        offset = body[t] if leg == "out" or is_body_turned_home else 0.0
        seen = wrap(theta + offset + (np.sign(last_turn) * shift if leg in shift_legs else 0.0))
        _, _, tb1 = oracle.compass(tb1, seen, params, 0.0, None)
        flow_seen = flow(seen, v, params) / filter_steps + (1 - 1 / filter_steps) * flow_seen
        if t not in frozen:
            tn1, tn2 = np.clip((1 - flow_seen) / 2, 0, 1), np.clip(flow_seen, 0, 1)
            memory = oracle.update_memory(memory, tb1, tn1, tn2, params)
        _, _, _, turn = oracle.steering(tb1, memory, params, 0.0, None)
        if leg == "home":
            theta, v = oracle.move(theta, v, turn, params.acceleration, params.drag)
            last_turn = turn
            theta, position, v = go_round(theta, position, v, obstacles, sides)
        position = position + v
        rows["heading"].append(wrap(theta + offset))
        rows["position"].append(position)
        rows["memory"].append(memory)
    return {name: np.array(values) for name, values in rows.items()}


def flow(heading: float, velocity: Array, params: OracleParams) -> Array:
    """Flow to the right and to the left of the heading."""
    sides = np.array([unit_vector(heading + params.phi_tn) @ velocity, unit_vector(heading - params.phi_tn) @ velocity])
    return np.full(2, sides.mean()) if params.variant == "non-holonomic" else sides


def set_memory(memory: Array, mode: str, other: Array, start: Array) -> Array:
    """Memory after another has replaced it, or has been added or subtracted."""
    if mode == "replace":
        return other
    sign = {"add": 1.0, "subtract": -1.0}[mode]
    return np.clip(memory + sign * (other - start), 0, 1)


def go_round(
    theta: float, position: Array, velocity: Array, obstacles: Sequence[tuple[Array, Array, float]], sides: list[int]
) -> tuple[float, Array, Array]:
    """Heading, position and velocity for a move round obstacles; ``sides`` are kept from step to step."""
    for obstacle in obstacles:
        away, radius = from_core(position, obstacle), obstacle[2] + SKIN
        distance = np.hypot(*away)
        if 0 < distance < radius:
            position = position + away * (radius / distance - 1)
        elif distance == 0:  # in the middle of a circle
            position = position + radius * unit_vector(theta)
    speed = np.hypot(*velocity)
    gaps = [np.hypot(*from_core(position, obstacle)) - obstacle[2] - SKIN for obstacle in obstacles]
    for i, gap in enumerate(gaps):
        if gap > max(1.0, speed):
            sides[i] = 0
    met: list[int] = []
    for _ in range(8):
        in_the_way = [i for i, obstacle in enumerate(obstacles) if is_blocked(position, velocity, obstacle)]
        if not in_the_way:
            return theta, position, velocity
        nearest = min(in_the_way, key=lambda i: gaps[i])
        if nearest in met[-2:]:
            sides[met[-1]] *= -1
            velocity = -velocity
        else:
            away = from_core(position, obstacles[nearest])
            clockwise = np.array([away[1], -away[0]]) / np.hypot(*away)
            sides[nearest] = sides[nearest] or (1 if clockwise @ velocity >= 0 else -1)
            velocity = sides[nearest] * speed * clockwise
            met.append(nearest)
        theta = float(np.arctan2(*velocity))
    if any(is_blocked(position, velocity, obstacle) for obstacle in obstacles):
        velocity = np.zeros(2)
    return theta, position, velocity


def from_core(position: Array, obstacle: tuple[Array, Array, float]) -> Array:
    """Vector to a position from the nearest point of an obstacle's middle line."""
    start, end, _ = obstacle
    along = end - start
    share = np.clip((position - start) @ along / (along @ along), 0, 1) if along.any() else 0.0
    return position - (start + share * along)


def is_blocked(position: Array, move: Array, obstacle: tuple[Array, Array, float]) -> bool:
    """Whether a move comes nearer to an obstacle than its surface, and than it is."""
    away = from_core(position, obstacle)
    if away @ move >= 0:
        return False
    closest = segment_distance(position, position + move, obstacle[0], obstacle[1])
    return bool(closest < min(obstacle[2] + SKIN, np.hypot(*away)) - 1e-9)


def segment_distance(p: Array, p_end: Array, q: Array, q_end: Array) -> float:
    """Smallest distance between two segments: Ericson (2005), Real-Time Collision Detection, 5.1.9."""
    d1, d2, r = p_end - p, q_end - q, p - q
    a, e, f, c, b = d1 @ d1, d2 @ d2, d2 @ r, d1 @ r, d1 @ d2
    if e == 0:
        s, t = np.clip(-c / a, 0, 1), 0.0
    else:
        denominator = a * e - b * b
        s = np.clip((b * f - c * e) / denominator, 0, 1) if denominator > 0 else 0.0
        t = (b * s + f) / e
        if not 0 <= t <= 1:
            t = np.clip(t, 0, 1)
            s = np.clip((t * b - c) / a, 0, 1)
    return float(np.hypot(*(p + d1 * s - q - d2 * t)))
