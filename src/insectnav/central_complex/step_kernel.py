"""One time step of any number of circuits, compiled, for callers that move the agents themselves."""

from insectnav.central_complex.circuit_kernel import MEMORY, TB1, advance_circuit, locate_circuit, locate_workspace
from insectnav.central_complex.layers import N_ROWS
from insectnav.lanes import LANES
from insectnav.lanes.compiled import kernel
from insectnav.lanes.functions import wrap
from insectnav.lanes.random import fetch_streams
from insectnav.lanes.vector import load


@kernel
def step_circuits(heading, velocity, tb1, memory, streams, activity, circuit_arrays, work_arrays):
    """Advance n circuits by one step: ``activity`` (n, N_ROWS) receives the result, ``streams`` (n, 4) move on."""
    n_circuits = heading.shape[0]
    circuit, work = locate_circuit(circuit_arrays), locate_workspace(work_arrays)
    rows, sample = work.rows, work.sample
    for first in range(0, n_circuits, LANES):
        n_here = min(LANES, n_circuits - first)
        fetch_streams(streams, first, n_here, work.stream)
        for lane in range(LANES):
            current = first + min(lane, n_here - 1)  # surplus lanes repeat the last circuit
            sample[lane] = heading[current]
            sample[LANES + lane] = velocity[current, 0]
            sample[2 * LANES + lane] = velocity[current, 1]
            for cell in range(8):
                rows[(TB1 + cell) * LANES + lane] = tb1[current, cell]
            for cell in range(16):
                rows[(MEMORY + cell) * LANES + lane] = memory[current, cell]
        theta, gain = wrap(load(sample, 0)), circuit.constants.memory_gain
        advance_circuit(circuit, work, theta, load(sample, 1), load(sample, 2), gain)
        for lane in range(n_here):
            for row in range(N_ROWS):
                activity[first + lane, row] = rows[row * LANES + lane]
            for word in range(4):
                streams[first + lane, word] = work.stream[word * LANES + lane]
