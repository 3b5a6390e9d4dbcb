"""Random numbers in lanes: the published generator, and the distributions made from it."""

import numpy as np
import pytest
from scipy import stats

from insectnav.lanes import LANES
from insectnav.lanes.compiled import kernel
from insectnav.lanes.random import fetch_streams, next_words, normal_pair, uniform
from insectnav.lanes.vector import address, fill, load, store

PRECISIONS = ("float32", "float64")
# First numbers after the state 1, 2, 3, 4, from the authors' C program (prng.di.unimi.it/xoshiro128plusplus.c), as
# the tests of the Rust crate rand_xoshiro give them.
REFERENCE = [
    641, 1573767, 3222811527, 3517856514, 836907274, 4247214768, 3867114732, 1355841295, 495546011, 621204420,
]  # fmt: skip
N_ROWS = 1 << 14  # of pairs of normal numbers in 16 lanes
SIGMAS = 5.0  # a fair test fails once in a million seeds


@kernel
def draw_words(states, drawn):
    """Fill ``drawn`` (n, LANES) and leave the generators ``states`` (4, LANES) where they have got to."""
    at, out = address(states), address(drawn)
    a, b, c, d = load(at, 0), load(at, 1), load(at, 2), load(at, 3)
    for row in range(drawn.shape[0]):
        bits, a, b, c, d = next_words(a, b, c, d)
        store(out, row, bits)
    store(at, 0, a)
    store(at, 1, b)
    store(at, 2, c)
    store(at, 3, d)


@kernel
def make_uniform(words, numbers):
    like = load(address(numbers), 0)
    for row in range(words.shape[0]):
        store(address(numbers), row, uniform(load(address(words), row), like))


@kernel
def make_normal(words, sigma, numbers):
    """Pairs of normal numbers (2, n, LANES), as rows, from pairs of rows of words."""
    like, n = load(address(numbers), 0), numbers.shape[0] // 2
    for row in range(n):
        first, second = normal_pair(load(address(words), row), load(address(words), row + n), fill(sigma, like))
        store(address(numbers), row, first)
        store(address(numbers), row + n, second)


@kernel
def fetch(streams, first, count, words):
    fetch_streams(streams, first, count, address(words))


def xoshiro128_plus_plus(state: list[int]) -> int:
    """Next number; Blackman & Vigna (2021), doi 10.1145/3460772, Fig. 1 and Table 2, in whole numbers without bound."""

    def rotate(word: int, n_bits: int) -> int:
        return (word << n_bits | word >> (32 - n_bits)) % 2**32

    s0, s1, s2, s3 = state
    number = (rotate((s0 + s3) % 2**32, 7) + s0) % 2**32
    t = s1 << 9
    s2, s3 = s2 ^ s0, s3 ^ s1
    s1, s0 = s1 ^ s2, s0 ^ s3
    state[:] = s0, s1, (s2 ^ t) % 2**32, rotate(s3, 11)
    return number


def normals(words: np.ndarray, precision: str, sigma: float = 1.0) -> np.ndarray:
    """Both numbers of each pair, (2, n), from words (2, n)."""
    rows = words.reshape(2, -1, LANES)
    numbers = np.zeros(rows.shape, precision)
    make_normal(rows.reshape(-1, LANES), sigma, numbers.reshape(-1, LANES))
    return numbers.reshape(2, -1)


def uniforms(words: np.ndarray, precision: str) -> np.ndarray:
    rows = np.resize(words, (-(-words.size // LANES), LANES))
    numbers = np.zeros(rows.shape, precision)
    make_uniform(rows, numbers)
    return numbers.reshape(-1)[: words.size]


@pytest.fixture(scope="module")
def drawn_words() -> np.ndarray:
    """Words of 16 independent generators, (2 n, LANES)."""
    states = np.random.default_rng(1).integers(1, 2**32, (4, LANES), np.uint32)
    drawn = np.empty((2 * N_ROWS, LANES), np.uint32)
    draw_words(states, drawn)
    return drawn


@pytest.fixture(scope="module", params=PRECISIONS)
def pairs(request: pytest.FixtureRequest, drawn_words: np.ndarray) -> np.ndarray:
    """Pairs of standard normal numbers, (2, n)."""
    return normals(drawn_words, request.param)


def test_generator_gives_the_reference_numbers() -> None:
    states = np.repeat(np.array([[1], [2], [3], [4]], np.uint32), LANES, axis=1)
    drawn = np.empty((len(REFERENCE), LANES), np.uint32)
    draw_words(states, drawn)
    assert drawn.T.tolist() == [REFERENCE] * LANES


def test_generator_agrees_with_whole_number_arithmetic_in_every_lane() -> None:
    states = np.random.default_rng(2).integers(0, 2**32, (4, LANES), np.uint32)
    expected_states = [[int(word) for word in states[:, lane]] for lane in range(LANES)]
    drawn = np.empty((1000, LANES), np.uint32)
    draw_words(states, drawn)
    for lane, state in enumerate(expected_states):
        assert drawn[:, lane].tolist() == [xoshiro128_plus_plus(state) for _ in range(1000)]
        assert states[:, lane].tolist() == state


@pytest.mark.parametrize(("first", "count"), [(0, 16), (5, 16), (16, 7), (20, 1)])
def test_streams_are_copied_to_lanes_and_the_last_fills_up(first: int, count: int) -> None:
    streams = np.arange(4 * 30, dtype=np.uint32).reshape(30, 4)
    before = streams.copy()
    words = np.zeros((4, LANES), np.uint32)
    fetch(streams, first, count, words)
    trials = [first + min(lane, count - 1) for lane in range(LANES)]
    np.testing.assert_array_equal(words.T, before[trials])
    np.testing.assert_array_equal(streams, before)


@pytest.mark.parametrize("precision", PRECISIONS)
def test_uniform_number_is_the_middle_of_its_31_bit_cell(precision: str) -> None:
    words = np.array([0, 1, 2, 3, 2**31, 2**32 - 1, *range(10, 4000, 77)], np.uint32)
    expected = ((words >> 1).astype("float64") + 0.5) / 2.0**31
    rounding = np.finfo(precision).eps
    np.testing.assert_allclose(uniforms(words, precision), expected, rtol=rounding, atol=0)


@pytest.mark.parametrize("precision", PRECISIONS)
def test_uniform_number_is_never_zero_nor_above_one(precision: str, drawn_words: np.ndarray) -> None:
    extremes = np.array([0, 1, 2**32 - 1, 2**32 - 2, 2**32 - 200], np.uint32)
    numbers = uniforms(np.concatenate([extremes, drawn_words.ravel()]), precision)
    assert numbers.min() == 2.0**-32
    assert numbers.max() <= 1


@pytest.mark.parametrize("precision", PRECISIONS)
def test_uniform_numbers_are_uniform(precision: str, drawn_words: np.ndarray) -> None:
    numbers = uniforms(drawn_words[:4096], precision)
    assert stats.kstest(numbers, "uniform").pvalue > 1e-4
    assert abs(numbers.mean() - 0.5) < SIGMAS / np.sqrt(12 * numbers.size)


def test_normal_pair_is_the_box_muller_transform(drawn_words: np.ndarray) -> None:
    words = np.ascontiguousarray(drawn_words[:64]).reshape(2, -1)
    radius = np.sqrt(-2 * np.log(((words[0] >> 1) + 0.5) / 2.0**31))
    angle = np.pi / 2**31 * words[1].view(np.int32)
    expected = 0.1 * radius * [np.sin(angle), np.cos(angle)]
    np.testing.assert_allclose(normals(words, "float64", 0.1), expected, rtol=0, atol=2e-15)
    np.testing.assert_allclose(normals(words, "float32", 0.1), expected, rtol=0, atol=4e-7)


def test_normal_moments(pairs: np.ndarray) -> None:
    for numbers in pairs.astype("float64"):
        n = numbers.size
        assert abs(numbers.mean()) < SIGMAS / np.sqrt(n)
        assert abs(numbers.var() - 1) < SIGMAS * np.sqrt(2 / n)
        assert abs(stats.skew(numbers)) < SIGMAS * np.sqrt(6 / n)
        assert abs(stats.kurtosis(numbers)) < SIGMAS * np.sqrt(24 / n)


def test_normal_numbers_follow_the_normal_distribution(pairs: np.ndarray) -> None:
    for numbers in pairs.astype("float64"):
        assert stats.kstest(numbers, "norm").pvalue > 1e-4


def test_tails_hold_as_many_as_they_should(pairs: np.ndarray) -> None:
    for numbers in pairs:
        for limit in (2, 3, 4):
            expected = 2 * stats.norm.sf(limit)
            found = np.mean(np.abs(numbers) > limit)
            assert abs(found - expected) < SIGMAS * np.sqrt(expected / numbers.size)


@pytest.mark.parametrize("precision", PRECISIONS)
def test_no_normal_number_exceeds_what_31_bits_allow(precision: str) -> None:
    extremes = np.array([0, 1, 2, 2**31 - 1, 2**31, 2**31 + 1, 2**32 - 2, 2**32 - 1], np.uint32)
    first, second = np.meshgrid(extremes, extremes)
    numbers = normals(np.stack([first.ravel(), second.ravel()]), precision)
    assert np.all(np.isfinite(numbers))
    assert np.abs(numbers).max() == pytest.approx(np.sqrt(64 * np.log(2)), rel=1e-6)  # 6.66


def test_the_two_of_a_pair_are_independent(pairs: np.ndarray) -> None:
    first, second = pairs.astype("float64")
    bound = SIGMAS / np.sqrt(first.size)
    assert abs(np.corrcoef(first, second)[0, 1]) < bound
    assert abs(np.corrcoef(first**2, second**2)[0, 1]) < bound
    counts = np.histogram2d(first > 0, second > 0, bins=2)[0]
    larger = np.histogram2d(np.abs(first) > 1, np.abs(second) > 1, bins=2)[0]
    for table in (counts, larger):
        assert stats.chi2_contingency(table).pvalue > 1e-4


def test_one_number_says_nothing_of_the_next_nor_of_other_lanes(pairs: np.ndarray) -> None:
    lanes = pairs[0].reshape(-1, LANES).astype("float64")
    bound = SIGMAS / np.sqrt(len(lanes))
    for lag in (1, 2, 3):
        for lane in range(LANES):
            assert abs(np.corrcoef(lanes[lag:, lane], lanes[:-lag, lane])[0, 1]) < bound
    between = np.corrcoef(lanes, rowvar=False) - np.eye(LANES)
    assert np.abs(between).max() < bound


@pytest.mark.parametrize("precision", PRECISIONS)
def test_standard_deviation_scales_the_numbers(precision: str, drawn_words: np.ndarray) -> None:
    words = drawn_words[:128].reshape(2, -1)
    standard, half = normals(words, precision), normals(words, precision, 0.5)
    np.testing.assert_array_equal(half, standard * np.dtype(precision).type(0.5))
    assert np.all(normals(words, precision, 0.0) == 0)
