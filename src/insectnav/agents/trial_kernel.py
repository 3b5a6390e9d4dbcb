"""Whole trials, compiled: out along a route, then home as the circuit steers."""

from insectnav.agents.motion_kernel import accelerate
from insectnav.central_complex.circuit_kernel import MEMORY, advance_circuit, locate_circuit, locate_workspace
from insectnav.central_complex.layers import N_NOISY, N_ROWS
from insectnav.lanes import LANES
from insectnav.lanes.compiled import kernel, lane_function
from insectnav.lanes.functions import wrap
from insectnav.lanes.random import fetch_streams
from insectnav.lanes.vector import address, fill, fma, load, minimum, square_root, store


@kernel
def run_trials_kernel(first, last, heading, velocity, streams, circuit_arrays, motion, clamps, work_arrays, results):
    """Run the trials from ``first`` up to ``last``; arrays and results as in `insectnav.agents.simulation`."""
    n_outbound, n_steps = heading.shape[1], results.heading.shape[1]
    circuit, work = locate_circuit(circuit_arrays), locate_workspace(work_arrays)
    rows, sample = work.rows, work.sample
    heading_at, velocity_at = address(heading), address(velocity)
    heading_out, position_out = address(results.heading), address(results.position)
    recorded_rows, activity_out = results.recorded_rows, results.activity
    n_clamps, n_recorded = clamps.row.shape[0], recorded_rows.shape[0]
    like = load(rows, 0)
    for block in range(first, last, LANES):
        n_here = min(LANES, last - block)
        leave_nest(rows, motion.memory_start)
        fetch_streams(streams, block, n_here, work.stream)
        x, y, closest = fill(0.0, like), fill(0.0, like), fill(0.0, like)
        theta, velocity_x, velocity_y = fill(0.0, like), fill(0.0, like), fill(0.0, like)
        for step in range(n_steps):
            if step < n_outbound:
                read_route(sample, heading_at, velocity_at, block, n_here, step, n_outbound)
                theta, velocity_x, velocity_y = wrap(load(sample, 0)), load(sample, 1), load(sample, 2)
            if n_clamps > 0:
                hold_cells(work.held, clamps, step)
            turn = advance_circuit(circuit, work, theta, velocity_x, velocity_y)
            if step >= n_outbound:
                theta = wrap(theta + turn)
                velocity_x, velocity_y = accelerate(theta, velocity_x, velocity_y, motion.acceleration, motion.drag)
            x, y = x + velocity_x, y + velocity_y
            distance = square_root(fma(x, x, y * y))
            closest = distance if step < n_outbound else minimum(closest, distance)
            store(sample, 0, theta)
            store(sample, 1, x)
            store(sample, 2, y)
            write_sample(sample, heading_out, position_out, block, n_here, step, n_steps)
            if n_recorded > 0:
                write_activity(rows, recorded_rows, activity_out, block, n_here, step)
            if step == n_outbound - 1:
                write_memory(rows, results.memory_at_turn, block, n_here)
        store(sample, 0, closest)
        for lane in range(n_here):
            results.closest_distance[block + lane] = sample[lane]


@lane_function
def leave_nest(rows, memory_start):
    """Activities at the start of a trial: nothing but an even memory."""
    for row in range(N_ROWS):
        store(rows, row, 0.0)
    for cell in range(16):
        store(rows, MEMORY + cell, memory_start)


@lane_function
def hold_cells(held, clamps, step):
    """Which cells are held at what rate in this step; later clamps win."""
    for row in range(N_NOISY):
        held[row] = -1.0
    for clamp in range(clamps.row.shape[0]):
        if clamps.first_step[clamp] <= step < clamps.end_step[clamp]:
            held[clamps.row[clamp]] = clamps.rate[clamp]


@lane_function
def read_route(sample, heading_at, velocity_at, first, n_here, step, n_outbound):
    """Heading and velocity of 16 trials at one step of their routes; surplus lanes repeat the last trial."""
    for lane in range(LANES):
        index = (first + min(lane, n_here - 1)) * n_outbound + step
        sample[lane] = heading_at[index]
        sample[LANES + lane] = velocity_at[2 * index]
        sample[2 * LANES + lane] = velocity_at[2 * index + 1]


@lane_function
def write_sample(sample, heading_out, position_out, first, n_here, step, n_steps):
    """Put heading and position of 16 trials where they belong in the results."""
    for lane in range(n_here):
        index = (first + lane) * n_steps + step
        heading_out[index] = sample[lane]
        position_out[2 * index] = sample[LANES + lane]
        position_out[2 * index + 1] = sample[2 * LANES + lane]


@lane_function
def write_activity(rows, recorded_rows, activity_out, first, n_here, step):
    """Put the recorded rows of the activities where they belong in the results."""
    for column in range(recorded_rows.shape[0]):
        for lane in range(n_here):
            activity_out[first + lane, step, column] = rows[recorded_rows[column] * LANES + lane]


@lane_function
def write_memory(rows, memory_out, first, n_here):
    """Put the memory of 16 trials where it belongs in the results."""
    for cell in range(16):
        for lane in range(n_here):
            memory_out[first + lane, cell] = rows[(MEMORY + cell) * LANES + lane]
