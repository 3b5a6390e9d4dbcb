"""Random numbers in kernels: one xoshiro128++ generator per trial, advanced in step.

A stream is four unsigned words; an array (4, LANES) holds those of 16 trials. `insectnav.rng` makes them from a seed.
"""

import math

from insectnav.lanes import LANES
from insectnav.lanes.compiled import lane_function
from insectnav.lanes.functions import log, sin_cos
from insectnav.lanes.vector import fma, square_root, to_real

UNIT = 2.0**-31


@lane_function
def next_words(a, b, c, d):
    """32 fresh random bits per lane and the four words of the generators after it.

    Notes
    -----
    xoshiro128++ 1.0, Blackman & Vigna (2021), ACM Trans. Math. Softw. 47:36, doi 10.1145/3460772.
    """
    total = a + d
    words = ((total << 7) | (total >> 25)) + a
    shifted = b << 9
    c = c ^ a
    d = d ^ b
    b = b ^ c
    a = a ^ d
    c = c ^ shifted
    d = (d << 11) | (d >> 21)
    return words, a, b, c, d


@lane_function
def uniform(words, like):
    """Numbers in 0 … 1 in the precision of ``like``, from 31 of the random bits; never 0."""
    return fma(to_real(words >> 1, like), UNIT, 0.5 * UNIT)


@lane_function
def normal_pair(words, more_words, sigma):
    """Two independent normal numbers per lane with standard deviation ``sigma``, in its precision.

    Notes
    -----
    Box & Muller (1958), Ann. Math. Stat. 29:610, doi 10.1214/aoms/1177706645. From 31 bits, none exceeds 6.7 sigma.
    """
    radius = sigma * square_root(-2.0 * log(uniform(words, sigma)))
    sine, cosine = sin_cos(to_real(more_words, sigma) * (math.pi * UNIT))
    return radius * sine, radius * cosine


@lane_function
def fetch_streams(streams, first, count, words):
    """Copy the generators of trials ``first``…``first + count − 1``, rows of ``streams`` (n, 4), to lanes.

    ``words`` is the address of an array (4, LANES); surplus lanes repeat the last trial.
    """
    for lane in range(LANES):
        trial = first + min(lane, count - 1)
        for word in range(4):
            words[word * LANES + lane] = streams[trial, word]
