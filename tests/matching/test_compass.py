import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.matching import disk_turn_matrix, nearest_view, seqslam, turn_matrix, turns_of_matches
from insectnav.metrics.retrieval import position_error
from insectnav.vision.descriptors import wrap_to_disk
from real_routes import sussex

RNG = np.random.default_rng(0)
VIEWS = RNG.random((6, 9, 36))
COLUMN = 2 * np.pi / 36


def brute_force(references, queries):
    """Root mean square difference after each turn by whole columns, (reference, query, turn)."""
    turned = np.stack([np.roll(queries, -k, axis=-1) for k in range(queries.shape[-1])], axis=1)
    return np.sqrt(((references[:, None, None] - turned) ** 2).mean(axis=(-2, -1)))


def skies(n=5, rows=30, columns=120, seed=1):
    """Panoramas of bits, sky above a skyline."""
    rng = np.random.default_rng(seed)
    azimuth = (np.arange(columns) + 0.5) * 2 * np.pi / columns
    height = np.zeros((n, columns))
    for k in range(1, 7):
        height += rng.normal(size=(n, 1)) / k * np.cos(k * azimuth + rng.uniform(0, 6, (n, 1)))
    return np.arange(rows)[:, None] < rows * (0.7 + 0.08 * height[:, None])


@pytest.mark.parametrize("normalise", [False, True])
def test_agrees_with_trying_all_turns(normalise):
    queries = RNG.random((4, 9, 36))
    found = turn_matrix(VIEWS, queries, normalise=normalise)
    if normalise:
        scaled = [
            (v - v.mean(axis=(1, 2), keepdims=True)) / v.std(axis=(1, 2), keepdims=True) for v in (VIEWS, queries)
        ]
    else:
        scaled = [VIEWS, queries]
    expected = brute_force(*scaled)
    assert_allclose(found.difference, expected.min(axis=-1), atol=1e-12)
    assert_allclose(np.mod(found.turn, 2 * np.pi), expected.argmin(axis=-1) * COLUMN, atol=1e-12)
    assert found.turn.min() >= -np.pi
    assert found.turn.max() < np.pi


@pytest.mark.parametrize("turn", range(-18, 18, 5))
def test_a_turned_view_is_turned_back(turn):
    # an eye that has turned to the left by k columns sees its views k columns further to the right
    found = nearest_view(turn_matrix(VIEWS, np.roll(VIEWS, turn, axis=-1)))
    assert_array_equal(found.reference, range(6))
    assert_allclose(found.turn, turn * COLUMN, atol=1e-12)
    assert_allclose(found.difference, 0, atol=1e-7)


@settings(deadline=None, max_examples=20)
@given(st.floats(0.01, 100), st.floats(-10, 10))
def test_light_changes_nothing_if_normalised(gain, offset):
    still, lit = turn_matrix(VIEWS, VIEWS), turn_matrix(VIEWS, gain * VIEWS + offset)
    assert_allclose(lit.difference, still.difference, atol=1e-5)
    assert_array_equal(lit.turn, still.turn)


def test_skies_of_bits_differ_by_the_root_of_the_share_that_differs():
    bits = skies()
    found = turn_matrix(bits, bits[:, :, ::-1], normalise=False)
    turned = np.stack([np.roll(bits[:, :, ::-1], -k, axis=-1) for k in range(120)], axis=1)
    expected = (bits[:, None, None] != turned).mean(axis=(-2, -1)).min(axis=-1)
    assert_allclose(found.difference**2, expected, atol=1e-12)


def test_threads_and_blocks_change_nothing():
    queries = RNG.random((40, 9, 36))
    one, three = turn_matrix(VIEWS, queries, workers=1), turn_matrix(VIEWS, queries, workers=3)
    alone = turn_matrix(VIEWS, queries[17:18])
    for a, b, c in zip(one, three, alone, strict=True):
        assert_array_equal(a, b)
        assert_allclose(a[:, 17:18], c, atol=1e-12)


def test_disks_agree_with_trying_all_turns():
    disks = wrap_to_disk(skies(), 60) > 0.5
    quarters = np.array(
        [np.rot90(disk, k) for k, disk in enumerate(disks[:4])]
    )  # an eye that turned right by k quarters
    found = disk_turn_matrix(disks[:4], quarters, 4)
    assert_array_equal(np.diag(found.difference), 0)
    assert_allclose(np.mod(-np.diag(found.turn), 2 * np.pi), np.arange(4) * np.pi / 2, atol=1e-12)
    place = (np.arange(60) + 0.5) / 30 - 1
    n_inside = (np.hypot(*np.meshgrid(place, place)) <= 1).sum()
    turned = np.stack([np.rot90(quarters, k, axes=(1, 2)) for k in range(4)])  # turned right by k quarters more
    expected = (disks[None, :4, None] != turned[:, None]).sum(axis=(-2, -1)).min(axis=0) / n_inside
    assert_allclose(found.difference, expected, rtol=1e-12)


def test_disks_and_panoramas_agree_on_the_turn():
    views = skies()
    turned = np.roll(views, 17, axis=-1)
    by_panorama = nearest_view(turn_matrix(views, turned, normalise=False))
    by_disk = nearest_view(disk_turn_matrix(wrap_to_disk(views, 121) > 0.5, wrap_to_disk(turned, 121) > 0.5, 120))
    for found in (by_panorama, by_disk):
        assert_array_equal(found.reference, range(5))
        assert_allclose(found.turn, 17 * 2 * np.pi / 120, atol=1e-9)
    assert by_disk.difference.max() < 0.02


def test_seqslam_first_and_then_the_compass():
    route = np.cumsum(RNG.normal(size=(60, 9, 36)), axis=0)
    drive, turn = route[10:40].copy(), RNG.integers(-18, 18, 30)
    for i in range(30):
        drive[i] = np.roll(drive[i] + 0.1 * RNG.normal(size=(9, 36)), turn[i], axis=-1)
    turns = turn_matrix(route, drive)
    matches = seqslam(turns.difference)
    found = turns_of_matches(route, drive, matches.reference)
    inner = slice(5, -5)
    assert_array_equal(matches.reference[inner], np.arange(15, 35))
    assert_allclose(found.turn[inner], turn[inner] * COLUMN, atol=1e-12)
    assert np.isnan(found.turn[:5]).all()
    assert_array_equal(found.turn[inner], turns.turn[matches.reference[inner], np.arange(5, 25)])


def test_missing_views_are_nan_and_alone():
    queries = VIEWS.copy()
    queries[2] = np.nan
    references = VIEWS.copy()
    references[4] = np.nan
    turns = turn_matrix(references, queries)
    whole = turn_matrix(VIEWS, VIEWS)
    is_known = ~np.isnan(turns.difference)
    assert is_known.sum() == 25
    assert_array_equal(turns.difference[is_known], whole.difference[is_known])
    found = nearest_view(turns)
    assert_array_equal(found.reference == -1, [False, False, True, False, False, False])
    assert_array_equal(np.isnan(found.turn), found.reference == -1)
    assert_array_equal(np.isnan(turns_of_matches(references, queries, [0, 1, 2, 3, 4, 5]).turn), [0, 0, 1, 0, 1, 0])


def test_a_constant_view_resembles_none():
    views = np.concatenate([np.full((1, 9, 36), 0.7), VIEWS])
    turns = turn_matrix(views, views)
    assert_allclose(turns.difference[0], np.sqrt(2), rtol=1e-12)
    assert_array_equal(nearest_view(turns).reference[1:], range(1, 7))
    assert (nearest_view(turn_matrix(views, RNG.random((9, 9, 36)))).reference > 0).all()


@pytest.mark.data
def test_a_real_robot_finds_its_place_on_a_route():
    (references, where), (queries, there) = sussex("snapshot"), sussex("test")
    found = nearest_view(turn_matrix(references, queries))
    error = position_error(where, there, found.reference)
    error = error[np.isfinite(error)]
    assert len(error) == 94
    assert np.median(error) < 19  # [cm] known of these recordings: median 18 cm, all within 50
    assert error.max() < 50


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: turn_matrix(VIEWS[0], VIEWS), r"references have shape \(9, 36\) and type float64, expected real"),
        (lambda: turn_matrix(VIEWS, VIEWS[:, :, :30]), r"references are of \(9, 36\) rows and columns and queries of"),
        (lambda: turn_matrix(VIEWS, np.where(VIEWS > 0.99, np.nan, VIEWS)), "view 0 of the queries is NaN or infinite"),
        (lambda: disk_turn_matrix(VIEWS, VIEWS), r"references have shape \(6, 9, 36\), expected \(sky, size, size\)"),
        (lambda: disk_turn_matrix(VIEWS[:, :, :9], VIEWS[:, :, :9]), "references hold values other than 0 and 1"),
        (lambda: disk_turn_matrix(VIEWS[:, :, :9] > 0.5, VIEWS[:, :8, :8] > 0.5), "references have shape .* one size"),
        (lambda: turns_of_matches(VIEWS, VIEWS, [0, 1]), r"matched has shape \(2,\), expected \(6,\)"),
        (lambda: turns_of_matches(VIEWS, VIEWS, [0, 1, 2, 3, 4, 6]), "matched reaches 6, expected -1 to 5: .* map"),
        (lambda: turns_of_matches(VIEWS, VIEWS, np.zeros(6)), "matched holds float64 values, expected whole numbers"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(call, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        call()


def test_of_equal_turns_the_first_is_taken():
    sky = np.ones((1, 20, 20), bool)
    found = disk_turn_matrix(sky, sky, 8)
    assert (found.difference[0, 0], found.turn[0, 0]) == (0.0, 0.0)
    opposite = np.zeros((1, 20, 20), bool)
    opposite[:, 10] = opposite[:, 9] = True  # a bar across, the same after half a turn
    assert disk_turn_matrix(opposite, opposite, 8).turn[0, 0] == 0.0
