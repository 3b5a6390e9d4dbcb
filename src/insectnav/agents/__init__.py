"""Agents: how they move, the routes they take, and trials of going out and coming home."""

from insectnav.agents.motion import MotionParams, move
from insectnav.agents.obstacles import Circle, Wall
from insectnav.agents.perturbations import (
    LEGS,
    ClampCells,
    CompassShift,
    Displace,
    FilterSpeed,
    FreezeMemory,
    ScaleSpeed,
    SetMemory,
    TurnBody,
    WeightNoise,
)
from insectnav.agents.recorded_routes import RecordedRoute, route_from_track
from insectnav.agents.routes import RouteParams, random_routes
from insectnav.agents.trials import run_trials

__all__ = [
    "LEGS",
    "Circle",
    "ClampCells",
    "CompassShift",
    "Displace",
    "FilterSpeed",
    "FreezeMemory",
    "MotionParams",
    "RecordedRoute",
    "RouteParams",
    "ScaleSpeed",
    "SetMemory",
    "TurnBody",
    "Wall",
    "WeightNoise",
    "move",
    "random_routes",
    "route_from_track",
    "run_trials",
]
