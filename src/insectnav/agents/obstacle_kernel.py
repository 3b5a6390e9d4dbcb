"""Obstacles, compiled: the rule that `insectnav.agents.obstacles` gives in words.

An obstacle is all that lies within ``radius`` of its core, which is a line for a wall and a point for a circle. As that
is convex, a move at right angles to the line from the nearest point of the core never comes nearer. One trial at a
time: obstacles are rare. Each row of an array of obstacles is x and y of both ends of the core, then the radius.
"""

import math

import numpy as np

from insectnav.lanes import LANES
from insectnav.lanes.compiled import kernel, lane_function
from insectnav.lanes.vector import load, store

X, Y, HEADING, VELOCITY_X, VELOCITY_Y = range(5)  # rows of the place of 16 agents
N_ATTEMPTS = 8  # turns of direction in one step, before the agent stands still: two obstacles take three
ROUNDING = 1e-9  # [steps]


@lane_function
def go_round(notebook, obstacles, n_obstacles, agents):
    """Position, heading and velocity of 16 agents for a move that is free of obstacles.

    The notebook's ``sides`` hold on which side each agent follows each obstacle: 1 for clockwise round it, −1 for
    anticlockwise, 0 for neither.
    """
    place = notebook.place
    x, y, theta, velocity_x, velocity_y = agents
    store(place, X, x)
    store(place, Y, y)
    store(place, HEADING, theta)
    store(place, VELOCITY_X, velocity_x)
    store(place, VELOCITY_Y, velocity_y)
    for lane in range(LANES):
        deflect(place, notebook.sides, obstacles, n_obstacles, lane)
    return load(place, X), load(place, Y), load(place, HEADING), load(place, VELOCITY_X), load(place, VELOCITY_Y)


@kernel
def deflect(place, sides, obstacles, n_obstacles, lane):
    """Free the move of one agent."""
    x, y = np.float64(place[X * LANES + lane]), np.float64(place[Y * LANES + lane])
    heading = np.float64(place[HEADING * LANES + lane])
    for obstacle in range(n_obstacles):
        x, y = leave_obstacle(obstacles, obstacle, x, y, heading)
    place[X * LANES + lane], place[Y * LANES + lane] = x, y
    move_x, move_y = np.float64(place[VELOCITY_X * LANES + lane]), np.float64(place[VELOCITY_Y * LANES + lane])
    speed = math.sqrt(move_x * move_x + move_y * move_y)
    for obstacle in range(n_obstacles):
        forget_side(sides, obstacles, obstacle, lane, x, y, speed)
    before, last = -1, -1
    for _ in range(N_ATTEMPTS):
        blocking = blocking_obstacle(obstacles, n_obstacles, x, y, move_x, move_y)
        if blocking < 0:
            break
        if blocking in (before, last):  # between two obstacles: turn round
            sides[last * LANES + lane] = -sides[last * LANES + lane]
            move_x, move_y = -move_x, -move_y
        else:
            move_x, move_y = follow(sides, obstacles, blocking, lane, x, y, move_x, move_y, speed)
            before, last = last, blocking
        heading = math.atan2(move_x, move_y)
    if blocking_obstacle(obstacles, n_obstacles, x, y, move_x, move_y) >= 0:
        move_x, move_y = 0.0, 0.0
    place[HEADING * LANES + lane] = heading
    place[VELOCITY_X * LANES + lane], place[VELOCITY_Y * LANES + lane] = move_x, move_y


@lane_function
def leave_obstacle(obstacles, obstacle, x, y, heading):
    """The position, or the nearest one on the surface for an agent that is inside."""
    normal_x, normal_y, distance = outwards(obstacles, obstacle, x, y, heading)
    inside = max(obstacles[5 * obstacle + 4] - distance, 0.0)
    return x + inside * normal_x, y + inside * normal_y


@lane_function
def forget_side(sides, obstacles, obstacle, lane, x, y, speed):
    """Free to go round either way is who is more than a step, and more than a move, away."""
    _, _, distance = outwards(obstacles, obstacle, x, y, 0.0)
    if distance - obstacles[5 * obstacle + 4] > max(1.0, speed):
        sides[obstacle * LANES + lane] = 0


@lane_function
def follow(sides, obstacles, obstacle, lane, x, y, move_x, move_y, speed):
    """A move along the surface, on the side that is kept or, at first, on the one nearer to the motion."""
    normal_x, normal_y, _ = outwards(obstacles, obstacle, x, y, 0.0)
    side = sides[obstacle * LANES + lane]
    if side == 0:
        side = 1 if normal_y * move_x - normal_x * move_y >= 0.0 else -1
        sides[obstacle * LANES + lane] = side
    return side * speed * normal_y, -side * speed * normal_x


@kernel
def blocking_obstacle(obstacles, n_obstacles, x, y, move_x, move_y):
    """Of the obstacles that the move would run into, the one with the nearest surface; −1 where the way is free."""
    blocking, smallest_gap = -1, np.inf
    for obstacle in range(n_obstacles):
        normal_x, normal_y, distance = outwards(obstacles, obstacle, x, y, 0.0)
        radius = obstacles[5 * obstacle + 4]
        if normal_x * move_x + normal_y * move_y >= 0.0 or distance - radius >= smallest_gap:
            continue  # away from all of it, as it is convex; or behind another
        if closest_approach(obstacles, obstacle, x, y, move_x, move_y) < min(radius, distance) - ROUNDING:
            blocking, smallest_gap = obstacle, distance - radius
    return blocking


@kernel
def outwards(obstacles, obstacle, x, y, heading):
    """Unit vector from the nearest point of the core to x, y, and the distance; on the core, to where it heads."""
    start_x, start_y = obstacles[5 * obstacle], obstacles[5 * obstacle + 1]
    along_x, along_y = obstacles[5 * obstacle + 2] - start_x, obstacles[5 * obstacle + 3] - start_y
    away_x, away_y = nearest_to_line(start_x, start_y, along_x, along_y, x, y)
    distance = math.sqrt(away_x * away_x + away_y * away_y)
    if distance > 0.0:
        return away_x / distance, away_y / distance, distance
    ahead_x, ahead_y = math.sin(heading), math.cos(heading)
    length = math.sqrt(along_x * along_x + along_y * along_y)
    if length == 0.0:
        return ahead_x, ahead_y, 0.0
    side = 1.0 if along_y * ahead_x - along_x * ahead_y >= 0.0 else -1.0
    return side * along_y / length, -side * along_x / length, 0.0


@lane_function
def nearest_to_line(start_x, start_y, along_x, along_y, x, y):
    """Vector from the nearest point of a line, from its start along a vector, to x, y."""
    to_x, to_y = x - start_x, y - start_y
    square = along_x * along_x + along_y * along_y
    share = (to_x * along_x + to_y * along_y) / square if square > 0.0 else 0.0
    share = min(max(share, 0.0), 1.0)
    return to_x - share * along_x, to_y - share * along_y


@kernel
def closest_approach(obstacles, obstacle, x, y, move_x, move_y):
    """Smallest distance between a move and the core of an obstacle: 0 where they cross, else at an end of either."""
    start_x, start_y = obstacles[5 * obstacle], obstacles[5 * obstacle + 1]
    end_x, end_y = obstacles[5 * obstacle + 2], obstacles[5 * obstacle + 3]
    along_x, along_y = end_x - start_x, end_y - start_y
    side_before = along_x * (y - start_y) - along_y * (x - start_x)
    side_after = along_x * (y + move_y - start_y) - along_y * (x + move_x - start_x)
    side_of_start = move_x * (start_y - y) - move_y * (start_x - x)
    side_of_end = move_x * (end_y - y) - move_y * (end_x - x)
    if side_before * side_after < 0.0 and side_of_start * side_of_end < 0.0:
        return 0.0
    square = np.inf
    for away_x, away_y in (
        nearest_to_line(start_x, start_y, along_x, along_y, x, y),
        nearest_to_line(start_x, start_y, along_x, along_y, x + move_x, y + move_y),
        nearest_to_line(x, y, move_x, move_y, start_x, start_y),
        nearest_to_line(x, y, move_x, move_y, end_x, end_y),
    ):
        square = min(square, away_x * away_x + away_y * away_y)
    return math.sqrt(square)
