"""One time step of any number of circuits, compiled, for callers that move the agents themselves."""

from insectnav.central_complex.circuit_kernel import MEMORY, TB1, advance_circuit
from insectnav.central_complex.layers import N_ROWS
from insectnav.central_complex.packing import Wiring
from insectnav.lanes import LANES
from insectnav.lanes.compiled import kernel
from insectnav.lanes.vector import address, load


@kernel
def step_circuits(heading, velocity, tb1, memory, stream, activity, work, words, wiring_arrays, constants, noise, held):
    """Advance n circuits by one step: ``activity`` (n, N_ROWS) receives the result, ``stream`` (n, 4) moves on.

    ``work`` (N_ROWS + 8 + 3, LANES) and ``words`` (4, LANES) are work space.
    """
    n_circuits = heading.shape[0]
    wiring = Wiring(
        address(wiring_arrays[0]),
        address(wiring_arrays[1]),
        address(wiring_arrays[2]),
        address(wiring_arrays[3]),
        address(wiring_arrays[4]),
    )
    rows, lateral, senses = address(work), address(work[N_ROWS:]), address(work[N_ROWS + 8 :])
    for first in range(0, n_circuits, LANES):
        for lane in range(LANES):
            circuit = min(first + lane, n_circuits - 1)  # surplus lanes repeat the last circuit
            senses[lane] = heading[circuit]
            senses[LANES + lane] = velocity[circuit, 0]
            senses[2 * LANES + lane] = velocity[circuit, 1]
            for cell in range(8):
                rows[(TB1 + cell) * LANES + lane] = tb1[circuit, cell]
            for cell in range(16):
                rows[(MEMORY + cell) * LANES + lane] = memory[circuit, cell]
            for word in range(4):
                words[word, lane] = stream[circuit, word]
        advance_circuit(
            rows,
            address(words),
            lateral,
            load(senses, 0),
            load(senses, 1),
            load(senses, 2),
            wiring,
            constants,
            address(noise),
            address(held),
        )
        for lane in range(min(LANES, n_circuits - first)):
            for row in range(N_ROWS):
                activity[first + lane, row] = rows[row * LANES + lane]
            for word in range(4):
                stream[first + lane, word] = words[word, lane]
