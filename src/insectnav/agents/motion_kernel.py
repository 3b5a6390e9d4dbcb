"""The agent's motion, compiled."""

from insectnav.lanes.compiled import lane_function
from insectnav.lanes.functions import sin_cos
from insectnav.lanes.vector import fma


@lane_function
def accelerate(heading, velocity_x, velocity_y, acceleration, drag):
    """Velocity after one step along ``heading``: v' = (1 − F_D) · (v + a · (sin θ, cos θ))."""
    sine, cosine = sin_cos(heading)
    kept = 1.0 - drag
    return kept * fma(sine, acceleration, velocity_x), kept * fma(cosine, acceleration, velocity_y)
