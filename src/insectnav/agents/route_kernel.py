"""Random outbound routes, compiled."""

from insectnav.agents.motion_kernel import accelerate
from insectnav.lanes import LANES
from insectnav.lanes.compiled import kernel, lane_function
from insectnav.lanes.functions import wrap
from insectnav.lanes.random import fetch_streams, next_words, normal_pair, uniform
from insectnav.lanes.vector import address, fill, fma, load, store

SERIES_SCALE = 2.0 / 6.8**2  # maps z² to −1…1: see turns.LARGEST_NORMAL


@lane_function
def von_mises_turn(normal, series, n_terms):
    """The turn with the quantile of ``normal``, by Clenshaw's recurrence: see `insectnav.agents.turns`."""
    x = fma(normal * normal, SERIES_SCALE, -1.0)
    one_before, two_before = 0.0 * normal, 0.0 * normal
    for k in range(n_terms - 1, 0, -1):
        one_before, two_before = fma(2.0 * x, one_before, series[k] - two_before), one_before
    return normal * fma(x, one_before, series[0] - two_before)


@kernel
def make_routes(
    first, last, streams, series, basis, low, high, persistence, drag, work, words, heading_out, velocity_out
):
    """Write headings (trial, step) and velocities (trial, step, 2) of the trials from ``first`` up to ``last``.

    ``basis`` (step, knot) interpolates accelerations between knots; ``work`` (at least knot + 3, LANES) and
    ``words`` (4, LANES) are work space.
    """
    n_steps, n_knots = basis.shape
    knots, sample = address(work), address(work[n_knots:])
    series_at, basis_at = address(series), address(basis)
    words_at = address(words)
    like = load(knots, 0)
    for block in range(first, last, LANES):
        n_here = min(LANES, last - block)
        fetch_streams(streams, block, n_here, words_at)
        a, b, c, d = load(words_at, 0), load(words_at, 1), load(words_at, 2), load(words_at, 3)
        for knot in range(n_knots):
            bits, a, b, c, d = next_words(a, b, c, d)
            store(knots, knot, fma(uniform(bits, like), high - low, low))
        heading, velocity_x, velocity_y, rotation = fill(0.0, like), fill(0.0, like), fill(0.0, like), fill(0.0, like)
        spare = fill(0.0, like)
        for step in range(n_steps):
            if step % 2 == 0:
                bits, a, b, c, d = next_words(a, b, c, d)
                more_bits, a, b, c, d = next_words(a, b, c, d)
                normal, spare = normal_pair(bits, more_bits, fill(1.0, like))
            else:
                normal = spare
            rotation = fma(rotation, persistence, von_mises_turn(normal, series_at, series.shape[0]))
            if step > 0:  # the first turn goes into the filter only: the agent starts at rest, heading 0
                heading = wrap(heading + rotation)
                acceleration = fill(0.0, like)
                for knot in range(n_knots):
                    acceleration = fma(load(knots, knot), basis_at[step * n_knots + knot], acceleration)
                velocity_x, velocity_y = accelerate(heading, velocity_x, velocity_y, acceleration, drag)
            store(sample, 0, heading)
            store(sample, 1, velocity_x)
            store(sample, 2, velocity_y)
            for lane in range(n_here):
                heading_out[block + lane, step] = sample[lane]
                velocity_out[block + lane, step, 0] = sample[LANES + lane]
                velocity_out[block + lane, step, 1] = sample[2 * LANES + lane]
