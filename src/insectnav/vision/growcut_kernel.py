"""GrowCut, compiled: where the cellular automaton comes to rest, found cell by cell, the strongest first.

A cell ends with the strength of the best path from any seed: the product of g along it. Minus the logarithm of that is
a length, so that this is a search for shortest paths, and Dijkstra's order visits each cell once. Lengths are whole
numbers of 2⁻³⁶: sums of them do not depend on their order, so that paths that are equally strong are so exactly.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from insectnav.lanes.compiled import kernel, lane_function

UNITS = 2.0**36  # of length, in the natural logarithm of strength; a step is shorter than 37 · UNITS
UNREACHED = 2**62  # length, where no path leads
STEP = 2**32  # `order` is this times the number of steps of the path, plus its label
BUCKET_BITS = 28  # of length, 2⁻⁸ of strength: in the queue sorted by a heap, the others by buckets
N_BUCKETS = 2**14  # a ring: 64 · UNITS in all, more than a step
CAPACITY = 4096  # of lists and heap at first
WAITING, IN_HEAP, USED, FREE = range(4)  # places in `count`


class Lists(NamedTuple):
    """Pixels whose time has not come, in one linked list for each bucket; -1 ends a list."""

    head: Any  # (bucket,) first entry
    pixel: Any  # (entry,)
    following: Any  # (entry,) next entry of the same list


class Heap(NamedTuple):
    """Pixels of the present bucket; an entry is before those at twice its place plus 1 and 2."""

    length: Any
    order: Any
    pixel: Any


@lane_function
def step_length(image, p, q, greatest, limit):
    """−log g of the step between two pixels, g(x) = 1 − x / max‖C‖; UNREACHED if it is certainly above the limit."""
    total = 0.0
    for band in range(image.shape[1]):
        difference = np.float64(image[p, band]) - np.float64(image[q, band])
        total += difference * difference
    if total == 0.0:
        return 0
    share = math.sqrt(total) / greatest
    if share >= 1.0 or UNITS * share > limit + 1.0:  # −log(1 − x) is more than x
        return UNREACHED
    return int(0.5 - UNITS * math.log1p(-share))


@lane_function
def is_before(length, order, other_length, other_order):
    """Whether a path is stronger; of equal ones the one that arrives earlier, then the one of the lower label."""
    return length < other_length or (length == other_length and order < other_order)


@lane_function
def doubled(array):
    """The same with room for twice as much."""
    larger = np.empty(2 * array.size, array.dtype)
    larger[: array.size] = array
    return larger


@lane_function
def push(heap, n, length, order, pixel):
    """Add to a heap of n entries that has room."""
    place = n
    while place > 0:
        above = (place - 1) >> 1
        if not is_before(length, order, heap.length[above], heap.order[above]):
            break
        heap.length[place], heap.order[place], heap.pixel[place] = (
            heap.length[above],
            heap.order[above],
            heap.pixel[above],
        )
        place = above
    heap.length[place], heap.order[place], heap.pixel[place] = length, order, pixel


@lane_function
def drop_first(heap, n):
    """Take the first entry out of a heap of n entries, which leaves n − 1."""
    last = n - 1
    length, order, pixel = heap.length[last], heap.order[last], heap.pixel[last]
    place, below = 0, 1
    while below < last:
        right = below + 1
        if right < last and is_before(heap.length[right], heap.order[right], heap.length[below], heap.order[below]):
            below = right
        if not is_before(heap.length[below], heap.order[below], length, order):
            break
        heap.length[place], heap.order[place], heap.pixel[place] = (
            heap.length[below],
            heap.order[below],
            heap.pixel[below],
        )
        place, below = below, 2 * below + 1
    heap.length[place], heap.order[place], heap.pixel[place] = length, order, pixel


@lane_function
def put(lists, count, bucket, pixel):
    """Add a pixel to the list of a bucket; there is room."""
    entry = count[FREE]
    if entry >= 0:
        count[FREE] = lists.following[entry]
    else:
        entry = count[USED]
        count[USED] += 1
    slot = bucket & (N_BUCKETS - 1)
    lists.pixel[entry], lists.following[entry] = pixel, lists.head[slot]
    lists.head[slot] = entry
    count[WAITING] += 1


@lane_function
def open_bucket(lists, heap, count, bucket, length, order):
    """Move the pixels of a bucket to the heap, but those that a better path has reached earlier; gives the heap."""
    slot = bucket & (N_BUCKETS - 1)
    entry = lists.head[slot]
    lists.head[slot] = -1
    while entry >= 0:
        pixel, following = lists.pixel[entry], lists.following[entry]
        lists.following[entry], count[FREE] = count[FREE], entry
        count[WAITING] -= 1
        if length[pixel] >> BUCKET_BITS == bucket:
            if count[IN_HEAP] == heap.pixel.size:
                heap = Heap(doubled(heap.length), doubled(heap.order), doubled(heap.pixel))
            push(heap, count[IN_HEAP], length[pixel], order[pixel], pixel)
            count[IN_HEAP] += 1
        entry = following
    return heap


@lane_function
def attack(image, columns, greatest, steps, here, bucket, lists, heap, count, length, order):
    """Let a pixel that has come to rest attack its neighbours; there is room for all of them."""
    rows, row, column = length.size // columns, here // columns, here % columns
    here_length, next_order = length[here], order[here] + STEP
    for k in range(len(steps)):
        r, c = row + steps[k, 0], column + steps[k, 1]
        there = r * columns + c
        if r < 0 or r >= rows or c < 0 or c >= columns or length[there] < here_length:
            continue
        limit = length[there] - here_length
        next_length = here_length + step_length(image, here, there, greatest, limit)
        if not is_before(next_length, next_order, length[there], order[there]):
            continue
        length[there], order[there] = next_length, next_order
        if next_length >> BUCKET_BITS == bucket:
            push(heap, count[IN_HEAP], next_length, next_order, there)
            count[IN_HEAP] += 1
        else:
            put(lists, count, next_length >> BUCKET_BITS, there)


@kernel
def grow(image, columns, greatest, steps, seeds, length, order):
    """Let labels grow from the seeds until nothing changes.

    ``image`` is (pixel, band); ``length`` and ``order`` are (pixel,) and changed in place: on entry they hold those of
    the seeds, and elsewhere UNREACHED, or what earlier seeds have led to. ``steps`` is (neighbour, 2): rows, columns.
    """
    lists = Lists(
        np.full(N_BUCKETS, -1, np.int32),
        np.empty(seeds.size + CAPACITY, np.int32),
        np.empty(seeds.size + CAPACITY, np.int32),
    )
    heap = Heap(np.empty(CAPACITY, np.int64), np.empty(CAPACITY, np.int64), np.empty(CAPACITY, np.int32))
    count = np.array((0, 0, 0, -1))
    for seed in seeds:
        put(lists, count, length[seed] >> BUCKET_BITS, seed)
    bucket = 0
    while count[WAITING] + count[IN_HEAP] > 0:
        if count[IN_HEAP] == 0:
            while lists.head[bucket & (N_BUCKETS - 1)] < 0:
                bucket += 1
            heap = open_bucket(lists, heap, count, bucket, length, order)
            continue
        here, here_length, here_order = heap.pixel[0], heap.length[0], heap.order[0]
        drop_first(heap, count[IN_HEAP])
        count[IN_HEAP] -= 1
        if length[here] != here_length or order[here] != here_order:
            continue  # a better path was found since
        if count[USED] + 8 > lists.pixel.size:
            lists = Lists(lists.head, doubled(lists.pixel), doubled(lists.following))
        if count[IN_HEAP] + 8 > heap.pixel.size:
            heap = Heap(doubled(heap.length), doubled(heap.order), doubled(heap.pixel))
        attack(image, columns, greatest, steps, here, bucket, lists, heap, count, length, order)
