"""Random outbound routes, compiled."""

from insectnav.agents.motion_kernel import accelerate
from insectnav.agents.turns import LARGEST_NORMAL
from insectnav.lanes import LANES
from insectnav.lanes.compiled import kernel, lane_function
from insectnav.lanes.functions import wrap
from insectnav.lanes.random import fetch_streams, next_words, normal_pair, uniform
from insectnav.lanes.vector import address, fill, fma, load, store

SERIES_SCALE = 2.0 / LARGEST_NORMAL**2  # maps z² to 0…2, from which 1 is taken


@lane_function
def von_mises_turn(normal, series, n_terms):
    """The turn with the quantile of ``normal``, by Clenshaw's recurrence: see `insectnav.agents.turns`."""
    x = fma(normal * normal, SERIES_SCALE, -1.0)
    one_before, two_before = 0.0 * normal, 0.0 * normal
    for k in range(n_terms - 1, 0, -1):
        one_before, two_before = fma(2.0 * x, one_before, series[k] - two_before), one_before
    return normal * fma(x, one_before, series[0] - two_before)


@lane_function
def bend_spline(values, bends, ratios, n_knots):
    """Second derivatives ``bends`` at the evenly spaced knots of the not-a-knot cubic spline through ``values``.

    Notes
    -----
    de Boor (1978), A Practical Guide to Splines, ch. IV. The third derivative is the same on both sides of the second
    knot, which makes the bend there a sixth of the right-hand side; likewise at the last but one. Between them stands
    a tridiagonal system, solved by elimination.
    """
    for knot in range(1, n_knots - 1):
        second_difference = load(values, knot + 1) - 2.0 * load(values, knot) + load(values, knot - 1)
        store(bends, knot, 6.0 * second_difference)
    store(bends, 1, load(bends, 1) * (1.0 / 6.0))
    store(bends, n_knots - 2, load(bends, n_knots - 2) * (1.0 / 6.0))
    ratio = 0.0
    for knot in range(2, n_knots - 2):
        ratio = 1.0 / (4.0 - ratio)
        store(ratios, knot, ratio)
        store(bends, knot, (load(bends, knot) - load(bends, knot - 1)) * ratio)
    for knot in range(n_knots - 3, 1, -1):
        store(bends, knot, load(bends, knot) - load(ratios, knot) * load(bends, knot + 1))
    store(bends, 0, 2.0 * load(bends, 1) - load(bends, 2))
    store(bends, n_knots - 1, 2.0 * load(bends, n_knots - 2) - load(bends, n_knots - 3))


@lane_function
def evaluate_spline(values, bends, n_knots, place):
    """The spline at ``place``, counted in knots from 0."""
    knot = min(int(place), n_knots - 2)
    after = place - knot
    before = 1.0 - after
    straight = load(values, knot) * before + load(values, knot + 1) * after
    bend = load(bends, knot) * (before**3 - before) + load(bends, knot + 1) * (after**3 - after)
    return fma(bend, 1.0 / 6.0, straight)


@kernel
def make_routes(
    first, last, streams, series, n_knots, low, high, persistence, drag, work, words, heading_out, velocity_out
):
    """Write headings (trial, step) and velocities (trial, step, 2) of the trials from ``first`` up to ``last``.

    ``n_knots`` random accelerations, evenly spaced over the route, are joined by a spline. ``work`` (3 n_knots + 3,
    LANES) and ``words`` (4, LANES) are work space.
    """
    n_steps = heading_out.shape[1]
    values, bends = address(work), address(work[n_knots:])
    ratios, sample = address(work[2 * n_knots :]), address(work[3 * n_knots :])
    series_at = address(series)
    words_at = address(words)
    like = load(values, 0)
    for block in range(first, last, LANES):
        n_here = min(LANES, last - block)
        fetch_streams(streams, block, n_here, words_at)
        a, b, c, d = load(words_at, 0), load(words_at, 1), load(words_at, 2), load(words_at, 3)
        for knot in range(n_knots):
            bits, a, b, c, d = next_words(a, b, c, d)
            store(values, knot, fma(uniform(bits, like), high - low, low))
        bend_spline(values, bends, ratios, n_knots)
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
                place = step * (n_knots - 1) / (n_steps - 1)
                acceleration = evaluate_spline(values, bends, n_knots, place)
                velocity_x, velocity_y = accelerate(heading, velocity_x, velocity_y, acceleration, drag)
            store(sample, 0, heading)
            store(sample, 1, velocity_x)
            store(sample, 2, velocity_y)
            for lane in range(n_here):
                heading_out[block + lane, step] = sample[lane]
                velocity_out[block + lane, step, 0] = sample[LANES + lane]
                velocity_out[block + lane, step, 1] = sample[2 * LANES + lane]
