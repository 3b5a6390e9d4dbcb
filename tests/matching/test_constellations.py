import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scipy.ndimage import gaussian_filter1d

from insectnav.checks import InputError
from insectnav.matching import ConstellationParams, constellation_index, locate_by_constellations
from insectnav.matching.constellations import Hits, _best_place, _constellations, _peaks

N, FEATURES = 1200, 60


def spectra(seed=0, n=N):
    """Amplitudes that change along a route over some frames, each by itself; low ones are larger."""
    smooth = gaussian_filter1d(np.random.default_rng(seed).normal(size=(n, FEATURES)), 3, axis=0)
    return (5 + smooth / smooth.std()) / (1 + np.arange(FEATURES))


def drive(speed, start=300.0, n=120, noise=0.0):
    """Spectra along a part of the route at a speed, and the true reference of each."""
    route, place = spectra(), start + speed * np.arange(n)
    low = np.floor(place).astype(int)
    share = (place - low)[:, None]
    between = route[low] * (1 - share) + route[low + 1] * share
    scatter = np.random.default_rng(1).normal(size=between.shape) / (1 + np.arange(FEATURES))
    return between + noise * scatter, place


INDEX = constellation_index(spectra())


@pytest.mark.parametrize("speed", [0.7, 0.85, 1.0, 1.15, 1.4])
@pytest.mark.parametrize("noise", [0.0, 0.2])
def test_a_drive_is_found_at_any_speed(speed, noise):
    queries, place = drive(speed, noise=noise)
    found = locate_by_constellations(INDEX, queries)
    inner = slice(20, -20)
    right = np.abs(found.reference - place)[inner] <= 5
    assert right.mean() > 0.9
    assert np.median(found.score[inner]) < 0.6
    assert abs(np.log(np.median(found.speed[inner]) / speed)) < np.log(1.11)


def test_a_tight_allowance_for_speed_loses_other_speeds():
    index = constellation_index(spectra(), ConstellationParams(slowest=0.95, fastest=1.05, longest=30))
    queries, place = drive(1.4)
    strict, lenient = locate_by_constellations(index, queries), locate_by_constellations(INDEX, queries)
    assert (np.abs(strict.reference - place) <= 2).mean() < (np.abs(lenient.reference - place) <= 2).mean() - 0.2


def test_another_route_is_not_recognised():
    found = locate_by_constellations(INDEX, spectra(seed=9, n=120))
    foreign, own = (
        np.where(m.reference >= 0, m.score, 1) for m in (found, locate_by_constellations(INDEX, drive(1.0)[0]))
    )
    assert np.median(foreign) > 0.6
    assert np.median(own) < 0.2


def test_the_route_itself_is_found_everywhere():
    found = locate_by_constellations(INDEX, spectra())
    assert (np.abs(found.reference - np.arange(N)) <= 2)[10:-10].mean() > 0.99


def test_light_and_scale_of_each_feature_change_nothing():
    gain = np.random.default_rng(2).uniform(0.1, 10, FEATURES)
    scaled = constellation_index(spectra() * gain)
    assert_array_equal(np.sort(scaled.constellations.key), np.sort(INDEX.constellations.key))


def test_peaks_are_the_highest_of_their_neighbours():
    values = np.random.default_rng(3).normal(size=(40, 30))
    params = ConstellationParams(peak_frames=2, peak_features=1)
    expected = [
        (i, j)
        for i in range(40)
        for j in range(30)
        if values[i, j] > 0 and values[i, j] == values[max(0, i - 2) : i + 3, max(0, j - 1) : j + 2].max()
    ]
    assert_array_equal(np.stack(_peaks(values, params), axis=-1), expected)


def test_missing_and_constant_frames_have_no_peaks():
    queries, place = drive(1.0)
    queries[50:55] = np.nan
    found = locate_by_constellations(INDEX, queries)
    assert (np.abs(found.reference - place)[20:-20] <= 5).mean() > 0.9
    lost = locate_by_constellations(INDEX, np.full((30, FEATURES), np.nan))
    assert_array_equal(lost.reference, -1)
    assert np.isnan(lost.score).all()
    constant = constellation_index(np.ones((50, FEATURES)))
    assert_array_equal(locate_by_constellations(constant, np.ones((50, FEATURES))).reference, -1)


def test_a_peak_is_higher_than_the_mean():
    values = np.full((9, 9), -5.0)
    values[4, 4] = -1.0  # higher than all about it, and yet below the mean
    assert_array_equal(_peaks(values, ConstellationParams())[0], [])
    values[4, 4] = 1.0
    assert_array_equal(_peaks(values, ConstellationParams()), [[4], [4]])


def test_a_constellation_spans_at_most_the_longest_time():
    values = np.full((40, 9), -1.0)
    values[[2, 9, 32], [1, 4, 7]] = 1.0
    found = _constellations(values, ConstellationParams(longest=30))
    assert (found.frame.tolist(), found.span.tolist()) == ([2], [30])
    assert not len(_constellations(values, ConstellationParams(longest=29)).key)


def test_a_rival_lies_farther_than_the_window():
    def hits(rival):
        reference = np.array([100, 100, 100, rival, rival])
        return Hits(np.full(5, 20), reference, np.full(5, 0.9), np.full(5, 1.1))

    params = ConstellationParams(unique_window=10, place_frames=0)
    assert _best_place(hits(110), 20, 500, params)[:2] == (100, 0.0)
    assert _best_place(hits(111), 20, 500, params)[:2] == (100, pytest.approx(2 / 3))


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: constellation_index(np.full((9, 9), np.nan)), "all references are missing"),
        (
            lambda: locate_by_constellations(INDEX, np.ones((9, 5))),
            "queries have 5 features, expected 60 as the references",
        ),
        (lambda: ConstellationParams(slowest=3), "fastest is 2, expected 3 to 100: slowest and fastest interchanged"),
        (lambda: ConstellationParams(ratio_bins=0), "ratio_bins is 0, expected a whole number of at least 1"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(call, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        call()
