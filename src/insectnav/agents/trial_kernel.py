"""Whole trials, compiled: out along a route, then home as the circuit steers."""

from typing import Any, NamedTuple

from insectnav.agents.motion_kernel import accelerate
from insectnav.agents.obstacle_kernel import go_round
from insectnav.agents.perturbation_kernel import (
    LAST_TURN,
    body_heading,
    displace,
    hold_cells,
    locate,
    memory_gain,
    prepare,
    set_memory,
    turn_senses,
)
from insectnav.central_complex.circuit_kernel import MEMORY, advance_circuit, locate_circuit, locate_workspace
from insectnav.central_complex.layers import N_ROWS
from insectnav.lanes import LANES
from insectnav.lanes.compiled import kernel, lane_function
from insectnav.lanes.functions import wrap
from insectnav.lanes.random import fetch_streams
from insectnav.lanes.vector import address, fill, fma, load, minimum, square_root, store


class ResultsAt(NamedTuple):
    """Addresses of the arrays of results, and how long they are."""

    heading: Any
    position: Any
    memory_at_turn: Any
    activity: Any
    recorded_rows: Any
    n_kept: int  # steps with heading and position: all or none
    n_steps: int
    n_recorded: int


@kernel
def run_trials_kernel(
    first, last, heading, velocity, streams, circuit_arrays, motion, disturbances, work_arrays, notebook_arrays, results
):
    """Run the trials from ``first`` up to ``last``; arrays and results as in `insectnav.agents.simulation`."""
    n_outbound, route = heading.shape[1], (address(heading), address(velocity))
    circuit, work, notebook = locate_circuit(circuit_arrays), locate_workspace(work_arrays), locate(notebook_arrays)
    has_events, n_obstacles = any_event(disturbances), disturbances.obstacles.shape[0]
    is_turned, speed = disturbances.body.is_on or disturbances.compass.is_on, disturbances.speed_factor
    results_at = locate_results(results)
    obstacles, zero = address(disturbances.obstacles), fill(0.0, load(work.rows, 0))
    for block in range(first, last, LANES):
        n_here = min(LANES, last - block)
        leave_nest(work, motion.memory_start)
        fetch_streams(streams, block, n_here, work.stream)
        prepare(notebook, disturbances, circuit.wiring.weight, block, n_here)
        x, y, closest, theta, velocity_x, velocity_y = zero, zero, zero, zero, zero, zero
        gain = circuit.constants.memory_gain
        for step in range(n_outbound + motion.n_inbound):
            if step < n_outbound:
                read_route(work.sample, route, block, n_here, step, n_outbound)
                theta = wrap(load(work.sample, 0))
                velocity_x, velocity_y = load(work.sample, 1) * speed, load(work.sample, 2) * speed
            if has_events:
                gain = intervene(work, circuit.constants.memory_gain, disturbances, block, n_here, step)
                x, y = displace(x, y, disturbances.displacements, step)
            perceived = theta
            if is_turned:
                theta, perceived = turn_senses(notebook, disturbances, theta, step, n_outbound)
            turn = advance_circuit(circuit, work, perceived, velocity_x, velocity_y, gain)
            if step >= n_outbound:
                theta = wrap(theta + turn)
                velocity_x, velocity_y = accelerate(theta, velocity_x, velocity_y, motion.acceleration, motion.drag)
                store(notebook.turning, LAST_TURN, turn)
            if step >= n_outbound and n_obstacles > 0:
                agents = x, y, theta, velocity_x, velocity_y
                x, y, theta, velocity_x, velocity_y = go_round(notebook, obstacles, n_obstacles, agents)
            x, y = x + velocity_x, y + velocity_y
            distance = square_root(fma(x, x, y * y))
            closest = distance if step < n_outbound else minimum(closest, distance)
            store(work.sample, 0, body_heading(notebook, theta) if is_turned else theta)
            store(work.sample, 1, x)
            store(work.sample, 2, y)
            write_results(work, results_at, block, n_here, step, n_outbound)
        store(work.sample, 0, closest)
        for lane in range(n_here):
            results.closest_distance[block + lane] = work.sample[lane]


@lane_function
def leave_nest(work, memory_start):
    """Activities at the start of a trial: nothing but an even memory."""
    for row in range(N_ROWS):
        store(work.rows, row, 0.0)
    for cell in range(16):
        store(work.rows, MEMORY + cell, memory_start)
    for side in range(2):
        store(work.flow, side, 0.0)


@lane_function
def any_event(disturbances):
    """Whether there is anything to do at single steps."""
    n_held = disturbances.clamps.row.shape[0] + disturbances.freezes.first_step.shape[0]
    return n_held + disturbances.displacements.step.shape[0] + disturbances.memories.step.shape[0] > 0


@lane_function
def intervene(work, gain, disturbances, block, n_here, step):
    """Do to the circuit what is to be done at the start of this step, and return the gain of its memory."""
    hold_cells(work.held, disturbances.clamps, step)
    set_memory(work.rows, work.sample, disturbances.memories, block, n_here, step)
    return memory_gain(gain, disturbances.freezes, step)


@lane_function
def read_route(sample, route, first, n_here, step, n_outbound):
    """Heading and velocity of 16 trials at one step of their routes; surplus lanes repeat the last trial."""
    heading_at, velocity_at = route
    for lane in range(LANES):
        index = (first + min(lane, n_here - 1)) * n_outbound + step
        sample[lane] = heading_at[index]
        sample[LANES + lane] = velocity_at[2 * index]
        sample[2 * LANES + lane] = velocity_at[2 * index + 1]


@lane_function
def locate_results(results):
    """Results with addresses in place of their arrays."""
    return ResultsAt(
        address(results.heading),
        address(results.position),
        address(results.memory_at_turn),
        address(results.activity),
        address(results.recorded_rows),
        results.heading.shape[1],
        results.activity.shape[1],
        results.recorded_rows.shape[0],
    )


@lane_function
def write_results(work, results, first, n_here, step, n_outbound):
    """Put what is asked for of 16 trials at one step where it belongs."""
    if results.n_kept > 0:
        write_sample(work.sample, results, first, n_here, step)
    if results.n_recorded > 0:
        write_activity(work.rows, results, first, n_here, step)
    if step == n_outbound - 1:
        write_memory(work.rows, results, first, n_here)


@lane_function
def write_sample(sample, results, first, n_here, step):
    """Heading and position."""
    for lane in range(n_here):
        index = (first + lane) * results.n_kept + step
        results.heading[index] = sample[lane]
        results.position[2 * index] = sample[LANES + lane]
        results.position[2 * index + 1] = sample[2 * LANES + lane]


@lane_function
def write_activity(rows, results, first, n_here, step):
    """Recorded rows of the activities."""
    for column in range(results.n_recorded):
        for lane in range(n_here):
            index = ((first + lane) * results.n_steps + step) * results.n_recorded + column
            results.activity[index] = rows[results.recorded_rows[column] * LANES + lane]


@lane_function
def write_memory(rows, results, first, n_here):
    """Memory at the turning point."""
    for cell in range(16):
        for lane in range(n_here):
            results.memory_at_turn[16 * (first + lane) + cell] = rows[(MEMORY + cell) * LANES + lane]
