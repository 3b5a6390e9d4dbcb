"""Flights in which the body looks another way than it moves, and where the agent then looks for its nest."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.agents.perturbations import TurnBody
from insectnav.angles import bearing, wrap
from insectnav.central_complex import CircuitParams, decode_waggle_dance
from insectnav.experiments.stone2017_path_integration.straight_flights import (
    Route,
    fly,
    straight_flight,
)

N_OUTBOUND, SPEED = 800, 0.25  # [steps], [steps per time step] Ext. Data Fig. 10d-f
N_INBOUND = 1000
COURSE_DEG = 180.0
STEPS_PER_OFFSET = 25  # Ext. Data Fig. 10d-f: where the offset is drawn anew
RANDOM = 999.0  # [deg] stands for offsets drawn anew
N_SEARCH = 300  # last steps of the way home, well after the nest would have been reached


def turned_body(offset_deg: float) -> TurnBody:
    """The body turned from the course by an angle, or by one drawn anew every 25 steps.

    Parameters
    ----------
    offset_deg : float
        Positive clockwise; `RANDOM` for angles drawn from all directions, the same for trial k of a seed in all
        conditions.
    """
    if offset_deg == RANDOM:
        return TurnBody(redraw_every=STEPS_PER_OFFSET)
    return TurnBody(offset=float(np.radians(offset_deg)))


def southward_flight(n_trials: int) -> Route:
    """Heading (trial, step) [rad] and velocity (trial, step, 2) of the flights out, the body along the course."""
    return straight_flight(np.full(n_trials, np.radians(COURSE_DEG)), N_OUTBOUND, SPEED)


def search_place(position: ArrayLike) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
    """Where the agent looks for its nest, from the turning point: angle from the direction of home, share of its way.

    Parameters
    ----------
    position : (trial, step, 2) array
        Of flights of `southward_flight` and the ways home of 1000 steps.

    Returns
    -------
    angle : (trial,) array [rad]
        Positive clockwise.
    share : (trial,) array
        Distance of the centre of the search, the mean place of the last 300 steps, over the distance of the nest.
    """
    position = np.asarray(position, float)
    start = position[:, N_OUTBOUND - 1]
    flown = position[:, -N_SEARCH:].mean(axis=1) - start
    angle = wrap(bearing(flown) - bearing(-start))
    return angle, np.linalg.norm(flown, axis=-1) / np.linalg.norm(start, axis=-1)


def stored_bearing_error(circuit: CircuitParams, offset_deg: float) -> tuple[float, float]:
    """Error of the stored bearing out [rad], and stored over true distance, without noise and in double precision.

    Parameters
    ----------
    circuit : CircuitParams
    offset_deg : float
        As of `turned_body`, but not drawn anew.
    """
    flight = fly(southward_flight(1), circuit, perturbations=[turned_body(offset_deg)], dtype="float64")
    dance = decode_waggle_dance(flight.memory_at_turn[0], circuit)
    return float(wrap(dance.bearing - np.radians(COURSE_DEG))), float(dance.distance / (N_OUTBOUND * SPEED))
