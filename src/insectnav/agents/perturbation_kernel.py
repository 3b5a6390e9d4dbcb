"""Perturbations in a trial, compiled: what the records of `insectnav.agents.perturbations` do to 16 trials.

Arrays and their meaning as in `insectnav.agents.perturbation_packing`.
"""

import math

from insectnav.agents.perturbation_packing import Notebook
from insectnav.central_complex.circuit_kernel import MEMORY
from insectnav.central_complex.layers import N_NOISY
from insectnav.lanes import LANES
from insectnav.lanes.compiled import lane_function
from insectnav.lanes.functions import clip_to_unit, wrap
from insectnav.lanes.random import fetch_streams, next_words, normal_pair, uniform
from insectnav.lanes.vector import address, fill, fma, load, maximum, minimum, store

BODY_OFFSET, LAST_TURN, LAST_HEADING = range(3)  # rows of the notebook's ``turning``


@lane_function
def locate(notebook):
    """A notebook with addresses in place of its arrays."""
    return Notebook(
        address(notebook.turning), address(notebook.words), address(notebook.place), address(notebook.sides)
    )


@lane_function
def prepare(notebook, disturbances, weight, block, n_here):
    """Draw the weights of 16 trials, and forget the trials before."""
    if disturbances.weights.is_noisy:
        draw_weights(weight, notebook.words, disturbances.weights, block, n_here)
    if disturbances.body.redraw_every > 0:
        fetch_streams(disturbances.body.streams, block, n_here, notebook.words)
    for row in range(3):
        store(notebook.turning, row, 0.0)
    for i in range(disturbances.obstacles.shape[0] * LANES):
        notebook.sides[i] = 0


@lane_function
def draw_weights(weight, words, changes, block, n_here):
    """Weights W · max(1 + sd · normal number, lowest factor), one number for each synapse whether it is used or not."""
    fetch_streams(changes.streams, block, n_here, words)
    a, b, c, d = load(words, 0), load(words, 1), load(words, 2), load(words, 3)
    like, n_synapses = load(weight, 0), changes.mean.shape[0]
    for synapse in range(0, n_synapses, 2):
        bits, a, b, c, d = next_words(a, b, c, d)
        more_bits, a, b, c, d = next_words(a, b, c, d)
        first, second = normal_pair(bits, more_bits, fill(1.0, like))
        store_weight(weight, synapse, first, changes)
        if synapse + 1 < n_synapses:
            store_weight(weight, synapse + 1, second, changes)


@lane_function
def store_weight(weight, synapse, normal, changes):
    """Put the weights of a synapse in 16 trials in their place."""
    factor = maximum(fma(normal, changes.sd[synapse], 1.0), changes.lowest_factor)
    store(weight, synapse, factor * changes.mean[synapse])


@lane_function
def hold_cells(held, clamps, step):
    """Which cells are held at what rate in this step; later clamps win."""
    for row in range(N_NOISY):
        held[row] = -1.0
    for clamp in range(clamps.row.shape[0]):
        if clamps.first_step[clamp] <= step < clamps.end_step[clamp]:
            held[clamps.row[clamp]] = clamps.rate[clamp]


@lane_function
def displace(x, y, displacements, step):
    """Position after all displacements of this step."""
    for i in range(displacements.step.shape[0]):
        if displacements.step[i] == step:
            x = fma(x, displacements.keep[i], displacements.change[i, 0])
            y = fma(y, displacements.keep[i], displacements.change[i, 1])
    return x, y


@lane_function
def set_memory(rows, sample, memories, block, n_here, step):
    """Change the memory of 16 trials as asked for at this step."""
    for i in range(memories.step.shape[0]):
        if memories.step[i] == step:
            for cell in range(16):
                for lane in range(LANES):
                    trial = block + min(lane, n_here - 1)
                    row = memories.first_row[i] + memories.row_of_trial[i] * trial
                    sample[lane] = memories.change[row, cell]
                kept = load(rows, MEMORY + cell) * memories.keep[i]
                store(rows, MEMORY + cell, clip_to_unit(kept + load(sample, 0)))


@lane_function
def memory_gain(gain, freezes, step):
    """Gain of the memory in this step: 0 while it is frozen."""
    for i in range(freezes.first_step.shape[0]):
        if freezes.first_step[i] <= step < freezes.end_step[i]:
            gain = 0.0
    return gain


@lane_function
def turn_senses(notebook, disturbances, theta, step, n_outbound):
    """Own heading, and the heading that the circuit is given."""
    turning, body, compass = notebook.turning, disturbances.body, disturbances.compass
    if body.is_on:
        theta = turn_body(turning, notebook.words, body, theta, step)
    perceived = body_heading(notebook, theta)
    if compass.is_on:
        note_turn(turning, theta, step, n_outbound)
        if compass.first_step <= step < compass.end_step:
            sign = minimum(maximum(load(turning, LAST_TURN) * 1e30, -1.0), 1.0)
            perceived = wrap(fma(sign, compass.angle, perceived))
    return theta, perceived


@lane_function
def body_heading(notebook, theta):
    """Own heading plus the offset of the body."""
    return wrap(theta + load(notebook.turning, BODY_OFFSET))


@lane_function
def turn_body(turning, words, body, theta, step):
    """Set the offset of this step, and return the own heading: that of the body once its leg is over."""
    if step == body.end_step:
        theta = wrap(theta + load(turning, BODY_OFFSET))
        store(turning, BODY_OFFSET, 0.0)
    elif body.first_step <= step < body.end_step:
        if body.redraw_every == 0:
            store(turning, BODY_OFFSET, body.angle)
        elif (step - body.first_step) % body.redraw_every == 0:
            bits, a, b, c, d = next_words(load(words, 0), load(words, 1), load(words, 2), load(words, 3))
            store(turning, BODY_OFFSET, fma(uniform(bits, theta), 2.0 * math.pi, -math.pi))
            store(words, 0, a)
            store(words, 1, b)
            store(words, 2, c)
            store(words, 3, d)
    return theta


@lane_function
def note_turn(turning, theta, step, n_outbound):
    """Keep the last turn: on the way out that of the route; none before the first step home."""
    if step < n_outbound:
        if step > 0:
            store(turning, LAST_TURN, wrap(theta - load(turning, LAST_HEADING)))
        store(turning, LAST_HEADING, theta)
    elif step == n_outbound:
        store(turning, LAST_TURN, 0.0)
