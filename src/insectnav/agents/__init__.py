"""Agents: how they move, the routes they take, and trials of going out and coming home."""

from insectnav.agents.motion import MotionParams, move
from insectnav.agents.routes import RouteParams, random_routes
from insectnav.agents.trials import run_trials

__all__ = ["MotionParams", "RouteParams", "move", "random_routes", "run_trials"]
