"""One time step of the circuit, compiled: the only implementation of its mathematics.

Read it as the equations of one bee; every variable holds 16 of them (`insectnav.lanes`).
"""

from insectnav.central_complex.layers import N_NOISY, ROW
from insectnav.central_complex.packing import FIRST_TARGET, PackedCircuit, Wiring, Workspace
from insectnav.lanes.compiled import lane_function
from insectnav.lanes.functions import clip_to_unit, sigmoid_base_2, sin_cos
from insectnav.lanes.random import next_words, normal_pair
from insectnav.lanes.vector import address, fill, fma, load, store

TL, CL1, TB1, TN1, TN2 = ROW["tl"], ROW["cl1"], ROW["tb1"], ROW["tn1"], ROW["tn2"]
MEMORY, CPU4, PONTINE, CPU1, MOTOR = ROW["memory"], ROW["cpu4"], ROW["pontine"], ROW["cpu1"], ROW["motor"]

TL_TO_CL1, CL1_TO_TB1, TB1_TO_TB1 = FIRST_TARGET["tl_to_cl1"], FIRST_TARGET["cl1_to_tb1"], FIRST_TARGET["tb1_to_tb1"]
TN_TO_CPU4, TB1_TO_CPU4 = FIRST_TARGET["tn_to_cpu4"], FIRST_TARGET["tb1_to_cpu4"]
CPU4_TO_PONTINE, CPU4_TO_CPU1 = FIRST_TARGET["cpu4_to_pontine"], FIRST_TARGET["cpu4_to_cpu1"]
PONTINE_TO_CPU1, TB1_TO_CPU1 = FIRST_TARGET["pontine_to_cpu1"], FIRST_TARGET["tb1_to_cpu1"]
CPU1_TO_MOTOR = FIRST_TARGET["cpu1_to_motor"]

INHIBITED_FLOW, FLOW_TIMES_HEADING, BACKWARD_FLOW = range(3)  # as in parameters.MEMORY_RULES
SUBTRACT, GATE = range(2)  # as in parameters.STEERING_RULES


@lane_function
def locate_circuit(circuit):
    """A packed circuit with addresses in place of its arrays."""
    wiring = circuit.wiring
    wiring_at = Wiring(
        address(wiring.first),
        address(wiring.row),
        address(wiring.weight),
        address(wiring.preferred_cosine),
        address(wiring.preferred_sine),
    )
    return PackedCircuit(wiring_at, circuit.constants, address(circuit.noise))


@lane_function
def locate_workspace(work):
    """A work space with addresses in place of its arrays."""
    return Workspace(
        address(work.rows),
        address(work.lateral),
        address(work.sample),
        address(work.stream),
        address(work.held),
        address(work.flow),
    )


@lane_function
def advance_circuit(circuit, work, heading, velocity_x, velocity_y, memory_gain):
    """Update all activities by one time step and return the turn [rad], positive to the right.

    Parameters
    ----------
    circuit : PackedCircuit of addresses
    work : Workspace of addresses
        TB1 and memory of the step before are read from its rows; all rows are replaced, and its streams move on.
    heading, velocity_x, velocity_y : lanes
        Heading in −π … π [rad] and velocity [steps per time step].
    memory_gain : float [1/step]
        That of the circuit, or 0 for a memory that does not change.

    Notes
    -----
    Stone et al. 2017, Methods, in the order of the layers; doi 10.1016/j.cub.2017.08.052.
    """
    wiring, constants, activity, held = circuit.wiring, circuit.constants, work.rows, work.held
    for cell in range(8):  # inhibition by the TB1 rates of the step before, which are about to be replaced
        store(work.lateral, cell, synaptic_input(activity, wiring, TB1_TO_TB1 + cell, 0))
    put_noise(activity, work.stream, constants, circuit.noise)

    sine, cosine = sin_cos(heading)
    for cell in range(8):
        alignment = fma(cosine, wiring.preferred_cosine[cell], sine * wiring.preferred_sine[cell])
        drive = alignment if constants.is_sigmoid else fma(alignment, 0.5, 0.5)
        rate = respond(drive, constants.tl_slope, constants.tl_bias, constants)
        set_rate(activity, held, TL + cell, rate)
        set_rate(activity, held, TL + cell + 8, rate)
    for cell in range(16):
        drive = synaptic_input(activity, wiring, TL_TO_CL1 + cell, 0)
        drive = drive if constants.is_sigmoid else 1.0 + drive
        set_rate(activity, held, CL1 + cell, respond(drive, constants.cl1_slope, constants.cl1_bias, constants))
    for cell in range(8):
        drive = synaptic_input(activity, wiring, CL1_TO_TB1 + cell, 0) - load(work.lateral, cell)
        set_rate(activity, held, TB1 + cell, respond(drive, constants.tb1_slope, constants.tb1_bias, constants))

    sense_flow(work, sine, cosine, velocity_x, velocity_y, constants)
    for cell in range(16):
        store(activity, MEMORY + cell, update_memory(activity, wiring, constants, memory_gain, cell))
        drive = load(activity, MEMORY + cell)
        set_rate(activity, held, CPU4 + cell, respond(drive, constants.cpu4_slope, constants.cpu4_bias, constants))
    for cell in range(16):
        if constants.has_pontine:
            drive = synaptic_input(activity, wiring, CPU4_TO_PONTINE + cell, 0)
            rate = respond(drive, constants.pontine_slope, constants.pontine_bias, constants)
            set_rate(activity, held, PONTINE + cell, rate)
        else:
            store(activity, PONTINE + cell, max(held[PONTINE + cell], 0.0))
    for cell in range(16):
        drive = synaptic_input(activity, wiring, CPU4_TO_CPU1 + cell, 0)
        drive = drive - synaptic_input(activity, wiring, PONTINE_TO_CPU1 + cell, 0)
        inhibition = synaptic_input(activity, wiring, TB1_TO_CPU1 + cell, 0)
        drive = drive - inhibition if constants.steering_rule == SUBTRACT else drive * (1.0 - inhibition)
        set_rate(activity, held, CPU1 + cell, respond(drive, constants.cpu1_slope, constants.cpu1_bias, constants))

    right = synaptic_input(activity, wiring, CPU1_TO_MOTOR, 0)
    turn = right - synaptic_input(activity, wiring, CPU1_TO_MOTOR + 1, 0)
    store(activity, MOTOR, turn)
    return turn


@lane_function
def synaptic_input(activity, wiring, target, row_offset):
    """Sum over the synapses of one receiving cell of weight × rate of the sender, ``row_offset`` rows further on."""
    first = wiring.first[target]  # there is at least one, if need be of weight 0
    total = load(wiring.weight, first) * load(activity, wiring.row[first] + row_offset)
    for synapse in range(first + 1, wiring.first[target + 1]):
        total = fma(load(wiring.weight, synapse), load(activity, wiring.row[synapse] + row_offset), total)
    return total


@lane_function
def put_noise(activity, stream, constants, noise):
    """Fill the rows of all cells with a rate with this step's noise, to which the rates are then added."""
    if constants.is_noisy:
        a, b, c, d = load(stream, 0), load(stream, 1), load(stream, 2), load(stream, 3)
        like = load(activity, 0)
        for row in range(0, N_NOISY, 2):
            words, a, b, c, d = next_words(a, b, c, d)
            more_words, a, b, c, d = next_words(a, b, c, d)
            first, second = normal_pair(words, more_words, fill(noise[row], like))  # a pair is of one population
            store(activity, row, first)
            store(activity, row + 1, second)
        store(stream, 0, a)
        store(stream, 1, b)
        store(stream, 2, c)
        store(stream, 3, d)
    else:
        for row in range(N_NOISY):
            store(activity, row, 0.0)


@lane_function
def respond(drive, slope, bias, constants):
    """Noise-free response of a cell: σ(slope · drive − bias), or the drive itself in the idealised circuit.

    Slope and bias come in units of ln 2, which spares the change of base in every cell.
    """
    return sigmoid_base_2(fma(drive, slope, -bias)) if constants.is_sigmoid else drive


@lane_function
def set_rate(activity, held, row, rate):
    """Final rate of a cell: its response plus the noise that is in its row, between 0 and 1, unless it is held."""
    if held[row] < 0.0:
        store(activity, row, clip_to_unit(rate + load(activity, row)))
    else:
        store(activity, row, held[row])


@lane_function
def sense_flow(work, sine, cosine, velocity_x, velocity_y, constants):
    """Rates of TN2 and TN1: flow along directions φ_TN to the right (0) and left (1) of the heading θ.

    flow = v · (sin(θ ± φ), cos(θ ± φ))
    """
    activity, held = work.rows, work.held
    along = fma(velocity_x, sine, velocity_y * cosine)
    across = fma(velocity_x, cosine, -(velocity_y * sine))
    right = fma(along, constants.tn_cosine, across * constants.tn_sine)
    left = fma(along, constants.tn_cosine, -(across * constants.tn_sine))
    if constants.is_flow_averaged:
        right = 0.5 * (right + left)
        left = right
    if constants.flow_share < 1.0:
        right = filter_flow(work.flow, 0, right, load(activity, TN2), constants)
        left = filter_flow(work.flow, 1, left, load(activity, TN2 + 1), constants)
    set_rate(activity, held, TN2, right)
    set_rate(activity, held, TN2 + 1, left)
    set_rate(activity, held, TN1, fma(right, -0.5, 0.5))
    set_rate(activity, held, TN1 + 1, fma(left, -0.5, 0.5))


@lane_function
def filter_flow(filtered, side, flow, noise, constants):
    """Exponential moving average s of the flow on one side: s ← share · flow + (1 − share) · s.

    In the authors' 2017 code the noise of TN2 is then added to s itself, and so stays in it.
    """
    flow = fma(flow, constants.flow_share, (1.0 - constants.flow_share) * load(filtered, side))
    store(filtered, side, flow + noise if constants.is_filter_noisy else flow)
    return flow


@lane_function
def update_memory(activity, wiring, constants, gain, cell):
    """Charge of one CPU4 cell after this step, between 0 and 1.

    inhibited-flow:      M + h · clip(TN2 − TB1, 0, 1) − h · k
    flow-times-heading:  M + h · (½ − TN1) · (½ − TB1)
    backward-flow:       M + h · clip(½ − TN1, 0, 1) · (1 − TB1) − h/4 · TN2
    """
    memory = load(activity, MEMORY + cell)
    forward = synaptic_input(activity, wiring, TN_TO_CPU4 + cell, 0)
    direction = synaptic_input(activity, wiring, TB1_TO_CPU4 + cell, 0)
    if constants.memory_rule == INHIBITED_FLOW:
        memory = fma(clip_to_unit(forward - direction), gain, memory - gain * constants.memory_loss)
    else:
        backward = synaptic_input(activity, wiring, TN_TO_CPU4 + cell, TN1 - TN2)
        if constants.memory_rule == FLOW_TIMES_HEADING:
            memory = fma((0.5 - backward) * (0.5 - direction), gain, memory)
        else:
            charge = clip_to_unit(0.5 - backward) * (1.0 - direction) - 0.25 * forward
            memory = fma(charge, gain, memory)
    return clip_to_unit(memory)
