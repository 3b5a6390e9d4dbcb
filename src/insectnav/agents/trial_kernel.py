"""Whole trials, compiled: out along a route, then home as the circuit steers."""

from insectnav.agents.motion_kernel import accelerate
from insectnav.central_complex.circuit_kernel import MEMORY, advance_circuit
from insectnav.central_complex.layers import N_NOISY, N_ROWS
from insectnav.central_complex.packing import Wiring
from insectnav.lanes import LANES
from insectnav.lanes.compiled import kernel, lane_function
from insectnav.lanes.functions import wrap
from insectnav.lanes.random import fetch_streams
from insectnav.lanes.vector import address, fill, fma, load, minimum, square_root, store


@lane_function
def leave_nest(rows, memory_start):
    """Activities at the start of a trial: nothing but an even memory."""
    for row in range(N_ROWS):
        store(rows, row, 0.0)
    for cell in range(16):
        store(rows, MEMORY + cell, memory_start)


@lane_function
def read_route(sample, heading, velocity, first, n_here, step):
    """Heading and velocity of 16 trials at one step of their routes; surplus lanes repeat the last trial."""
    for lane in range(LANES):
        trial = first + min(lane, n_here - 1)
        sample[lane] = heading[trial, step]
        sample[LANES + lane] = velocity[trial, step, 0]
        sample[2 * LANES + lane] = velocity[trial, step, 1]
    return load(sample, 0), load(sample, 1), load(sample, 2)


@lane_function
def write_sample(sample, heading, x, y, heading_out, position_out, first, n_here, step):
    """Put heading and position of 16 trials where they belong in the results."""
    store(sample, 0, heading)
    store(sample, 1, x)
    store(sample, 2, y)
    for lane in range(n_here):
        heading_out[first + lane, step] = sample[lane]
        position_out[first + lane, step, 0] = sample[LANES + lane]
        position_out[first + lane, step, 1] = sample[2 * LANES + lane]


@lane_function
def write_record(rows, recorded, record_out, first, n_here, step):
    """Put the recorded rows of the activities where they belong in the results."""
    for column in range(recorded.shape[0]):
        for lane in range(n_here):
            record_out[first + lane, step, column] = rows[recorded[column] * LANES + lane]


@lane_function
def hold_cells(held, clamps, step):
    """Which cells are held at what rate in this step; later clamps win."""
    for row in range(N_NOISY):
        held[row] = -1.0
    for clamp in range(clamps.first_step.shape[0]):
        if clamps.first_step[clamp] <= step < clamps.end_step[clamp]:
            held[clamps.row[clamp]] = clamps.rate[clamp]


@kernel
def run_trials_kernel(
    first,
    last,
    heading,
    velocity,
    streams,
    memory_start,
    acceleration,
    drag,
    wiring_arrays,
    constants,
    noise,
    clamps,
    recorded,
    held,
    work,
    words,
    heading_out,
    position_out,
    memory_out,
    closest_out,
    record_out,
):
    """Run the trials from ``first`` up to ``last``: see `insectnav.agents.run_trials` for what the arrays hold.

    ``held`` (N_NOISY,), ``work`` (N_ROWS + 8 + 3, LANES) and ``words`` (4, LANES) are work space of this call alone.
    """
    n_outbound, n_steps = heading.shape[1], heading_out.shape[1]
    wiring = Wiring(
        address(wiring_arrays[0]),
        address(wiring_arrays[1]),
        address(wiring_arrays[2]),
        address(wiring_arrays[3]),
        address(wiring_arrays[4]),
    )
    rows, lateral, sample = address(work), address(work[N_ROWS:]), address(work[N_ROWS + 8 :])
    words_at, noise_at, held_at = address(words), address(noise), address(held)
    hold_cells(held, clamps, -1)
    like = load(rows, 0)
    for block in range(first, last, LANES):
        n_here = min(LANES, last - block)
        leave_nest(rows, memory_start)
        fetch_streams(streams, block, n_here, words_at)
        x, y, closest = fill(0.0, like), fill(0.0, like), fill(0.0, like)
        theta, velocity_x, velocity_y = fill(0.0, like), fill(0.0, like), fill(0.0, like)
        for step in range(n_steps):
            is_outbound = step < n_outbound
            if is_outbound:
                theta, velocity_x, velocity_y = read_route(sample, heading, velocity, block, n_here, step)
                theta = wrap(theta)
            if clamps.first_step.shape[0] > 0:
                hold_cells(held, clamps, step)
            turn = advance_circuit(
                rows, words_at, lateral, theta, velocity_x, velocity_y, wiring, constants, noise_at, held_at
            )
            if not is_outbound:
                theta = wrap(theta + turn)
                velocity_x, velocity_y = accelerate(theta, velocity_x, velocity_y, acceleration, drag)
            x, y = x + velocity_x, y + velocity_y
            distance = square_root(fma(x, x, y * y))
            closest = distance if step < n_outbound else minimum(closest, distance)
            write_sample(sample, theta, x, y, heading_out, position_out, block, n_here, step)
            write_record(rows, recorded, record_out, block, n_here, step)
            if step == n_outbound - 1:
                for cell in range(16):
                    for lane in range(n_here):
                        memory_out[block + lane, cell] = rows[(MEMORY + cell) * LANES + lane]
        store(sample, 0, closest)
        for lane in range(n_here):
            closest_out[block + lane] = sample[lane]
