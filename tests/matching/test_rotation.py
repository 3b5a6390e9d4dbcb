"""Place and orientation of made-up views: the laws, a brute search as oracle, cameras, bad input."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation
from threadpoolctl import threadpool_limits

from bumpy_skies import bumpy_sky, cap, cap_without_sector, plain_score, seen_by
from insectnav.checks import InputError
from insectnav.matching import RotationParams, build_rotation_index, rotation_between
from insectnav.vision import fisheye, resampler, rotation_matrix, to_world
from insectnav.vision.sphere import equirectangular, fibonacci

GRID = equirectangular(3.0)
PARAMS = RotationParams(fine_blur=np.deg2rad(3.0), n_refined=5)
SKIES = [bumpy_sky(seed) for seed in range(6)]
SEEN = cap(GRID.directions)
LEVEL = np.array([seen_by(sky, GRID, np.eye(3)) for sky in SKIES])
INDEX = build_rotation_index(LEVEL, SEEN, GRID, PARAMS)
FIELDS = ("reference", "rotation", "score", "runner_up", "ratio", "overlap")


def degrees(first, second):
    return np.rad2deg(rotation_between(first, second))


def query(number, rotation, grid=GRID):
    return seen_by(SKIES[number], grid, rotation)


def assert_same(one, other):
    for field in FIELDS:
        assert_array_equal(getattr(one, field), getattr(other, field))


def test_the_same_view_is_itself_and_not_turned():
    match = INDEX.match(LEVEL, SEEN)
    assert_array_equal(match.reference, range(6))
    assert_allclose(match.score, 1.0, atol=1e-9)
    assert_allclose(match.overlap, 1.0)
    assert_allclose(match.ratio, 0.0, atol=1e-6)
    assert degrees(match.rotation, np.eye(3)).max() < 1e-6
    assert (match.runner_up != match.reference).all()


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 5), st.floats(-3.1, 3.1), st.floats(0.0, 1.2), st.floats(-3.1, 3.1))
def test_place_and_rotation_are_found_at_any_turn_and_tilt(number, heading, tilt, towards):
    rotation = (
        rotation_matrix(towards) @ rotation_matrix(0.0, tilt) @ rotation_matrix(-towards) @ rotation_matrix(heading)
    )
    match = INDEX.match(query(number, rotation), SEEN)
    assert match.reference == number
    assert degrees(match.rotation, rotation) < 0.5
    assert match.score > 0.998
    assert match.tilt == pytest.approx(tilt, abs=np.deg2rad(0.5))
    assert match.overlap == pytest.approx(1.0 - tilt / np.pi, abs=0.03)  # two halves of a sphere


def test_turning_the_query_turns_what_is_found_and_keeps_the_score():
    first = rotation_matrix(0.4, 0.3, -0.2)
    base = INDEX.match(query(2, first), SEEN)
    for turn in (rotation_matrix(2.0), rotation_matrix(-1.0, 0.4), rotation_matrix(0.3, -0.2, 0.5)):
        match = INDEX.match(query(2, first @ turn), SEEN)
        assert match.reference == base.reference
        assert degrees(match.rotation, base.rotation @ turn) < 0.4
        assert match.score == pytest.approx(base.score, abs=1e-3)


def test_query_and_reference_may_change_places():
    # Places a little apart, so that the score is not 1: a sky and the same with other bumps mixed in.
    def other(directions):
        return 0.8 * SKIES[0](directions) + 0.2 * SKIES[5](directions)

    rotation = rotation_matrix(1.0, 0.35, 0.1)
    tilted = other(to_world(GRID.directions, rotation))
    there = build_rotation_index(LEVEL[:1], SEEN, GRID, PARAMS).match(tilted, SEEN)
    back = build_rotation_index(tilted[None], SEEN, GRID, PARAMS).match(LEVEL[0], SEEN)
    assert there.score == pytest.approx(back.score, abs=1e-3)
    assert there.score < 0.997
    assert there.overlap == pytest.approx(back.overlap, abs=0.01)
    assert degrees(back.rotation, there.rotation.T) < 2.0  # within which the score is flat


MASKS = {
    "half": cap,
    "all": lambda directions: np.ones(directions.shape[:-1], bool),
    "a sector is hidden": lambda directions: cap_without_sector(directions, 30.0, 80.0),
    "a panorama": lambda directions: cap(directions, 105.0),
}


@pytest.mark.parametrize("kind", ["difference", "correlation"])
@pytest.mark.parametrize(
    ("query_mask", "reference_mask"),
    [
        ("half", "half"),
        ("half", "all"),
        ("a panorama", "half"),
        ("a sector is hidden", "a panorama"),
        ("a sector is hidden", "a sector is hidden"),
    ],
)
def test_a_brute_search_over_all_rotations_finds_nothing_better(kind, query_mask, reference_mask):
    params = replace(PARAMS, score=kind)
    index = build_rotation_index(LEVEL[:3], MASKS[reference_mask](GRID.directions), GRID, params)
    truth = rotation_matrix(2.2, 0.6, -0.3)
    match = index.match(query(1, truth), MASKS[query_mask](GRID.directions))

    def score(number, rotation, n=400):
        here = (lambda d: SKIES[1](to_world(d, truth)), MASKS[query_mask])
        return plain_score(here, (SKIES[number], MASKS[reference_mask]), rotation, kind, n)

    found = score(int(match.reference), match.rotation)
    turns = Rotation.random(1500, random_state=5).as_matrix()
    turns = turns[turns[:, 2, 2] >= 0.0]  # tilts of up to 90°, as are searched
    assert found >= max(score(k, turn) for k in range(3) for turn in turns[::3])
    near = [Rotation.from_rotvec(v).as_matrix() @ truth for v in np.random.default_rng(1).normal(0, 0.05, (100, 3))]
    assert found >= max(score(1, turn) for turn in near) - 1e-3
    assert match.reference == 1
    assert degrees(match.rotation, truth) < 0.5
    assert match.score == pytest.approx(score(1, match.rotation, 3000), abs=5e-3)


def test_views_that_differ_score_as_a_plain_mean_over_the_overlap():
    # The best rotation of two different places, at which the plain score on the true functions is about the same.
    index = build_rotation_index(LEVEL[3:4], SEEN, GRID, PARAMS)
    match = index.match(LEVEL[4], SEEN)
    expected = plain_score((SKIES[4], cap), (SKIES[3], cap), match.rotation)
    assert match.score == pytest.approx(expected, abs=0.01)
    turns = Rotation.random(6000, random_state=6).as_matrix()
    turns = turns[turns[:, 2, 2] >= 0.0]
    overlap = 1.0 - np.arccos(turns[:, 2, 2]) / np.pi
    scores = [plain_score((SKIES[4], cap), (SKIES[3], cap), turn, n=300) for turn in turns[overlap >= 0.5][:1500]]
    assert match.score > max(scores) - 0.01


def test_what_was_not_seen_does_not_matter():
    rotation = rotation_matrix(1.0, 0.5, -0.1)
    view = query(3, rotation)
    rubbish = np.random.default_rng(0).normal(size=view.shape) * 1e6
    rubbish[::2] = np.nan
    base = INDEX.match(view, SEEN)
    assert_same(base, INDEX.match(np.where(SEEN, view, rubbish), SEEN))
    other = build_rotation_index(np.where(SEEN, LEVEL, rubbish), SEEN, GRID, PARAMS)
    assert_same(base, other.match(view, SEEN))


def test_a_batch_is_a_loop_to_the_bit_and_threads_change_nothing():
    rng = np.random.default_rng(4)
    turns = [rotation_matrix(*rng.uniform(-0.6, 0.6, 3)) for _ in range(6)]
    views = np.array([query(k, turn) for k, turn in enumerate(turns)])
    together = INDEX.match(views.reshape(2, 3, *GRID.shape), SEEN.reshape(GRID.shape))
    assert together.rotation.shape == (2, 3, 3, 3)
    assert together.heading.shape == together.reference.shape == (2, 3)
    with ThreadPoolExecutor(3) as pool:
        alone = list(pool.map(lambda view: INDEX.match(view, SEEN), views))
    for number in (1, 2):
        with threadpool_limits(number, user_api="blas"):
            alone += [INDEX.match(view, SEEN) for view in views]
    for k, match in enumerate(alone):
        for field in FIELDS:
            assert_array_equal(getattr(match, field), getattr(together, field)[k % 6 // 3, k % 3])


def test_masks_may_differ_from_view_to_view():
    rotation = rotation_matrix(-0.8, 0.4)
    masks = np.array([cap_without_sector(GRID.directions, 60 * k, 50) for k in range(6)])
    index = build_rotation_index(LEVEL, masks, GRID, PARAMS)
    assert index.rings.masks.shape[-1] == 6
    match = index.match(np.array([query(k, rotation) for k in range(6)]), masks[::-1])
    assert_array_equal(match.reference, range(6))
    assert degrees(match.rotation, rotation).max() < 0.5


def test_overlap_is_a_share_of_what_the_matched_reference_saw():
    """A cap of 40° lies within the query's of 90°: all of it is shared, whatever the other reference saw."""
    masks = np.stack([cap(GRID.directions, 40.0), SEEN])
    index = build_rotation_index(LEVEL[:2], masks, GRID, PARAMS)
    first, second = index.match(LEVEL[0], SEEN), index.match(LEVEL[1], SEEN)
    assert (first.reference, second.reference) == (0, 1)
    assert first.overlap == pytest.approx(1.0, abs=0.01)
    assert second.overlap == pytest.approx(1.0, abs=0.01)


def test_correlation_takes_no_notice_of_brightness_and_contrast():
    index = build_rotation_index(LEVEL, SEEN, GRID, replace(PARAMS, score="correlation"))
    rotation = rotation_matrix(0.7, -0.5, 0.2)
    plain, changed = (index.match(view, SEEN) for view in (query(4, rotation), 40.0 * query(4, rotation) - 700.0))
    assert (plain.reference, changed.reference) == (4, 4)
    assert_allclose(changed.rotation, plain.rotation, atol=1e-3)
    assert changed.score == pytest.approx(plain.score, abs=1e-5)
    assert plain.score > 0.995
    negative = index.match(1.0 - LEVEL[0], SEEN)
    assert negative.score < plain.score


def test_a_fisheye_camera_finds_a_panorama():
    camera = fisheye((60, 60), np.pi)
    truth = rotation_matrix(-1.4, 0.35, 0.25)
    looks = camera.pixel_directions()
    image = np.where(np.isfinite(looks[..., 0]), SKIES[5](to_world(np.nan_to_num(looks), truth)), np.nan)
    see = resampler(camera, GRID)
    panoramas = build_rotation_index(LEVEL, cap(GRID.directions, 105.0), GRID, PARAMS)
    match = panoramas.match(see(np.nan_to_num(image)), see.seen)
    assert match.reference == 5
    assert degrees(match.rotation, truth) < 0.7
    assert (match.heading, match.pitch, match.roll) == pytest.approx((-1.4, 0.35, 0.25), abs=0.02)


def test_bytes_and_bools_count_as_zero_to_one():
    grey = np.rint(255 * LEVEL).astype(np.uint8)
    index = build_rotation_index(grey, SEEN, GRID, PARAMS)
    assert_allclose(index.match(LEVEL, SEEN).score, 1.0, atol=1e-4)
    is_sky = LEVEL > 0.5
    index = build_rotation_index(is_sky, SEEN, GRID, PARAMS)
    assert_same(index.match(is_sky, SEEN), index.match(is_sky.astype(float), SEEN))


def test_rounding_beyond_one_is_forgiven():
    rounded = np.where(LEVEL > 0.5, np.float32(1.0000002), np.float32(-1e-7))
    assert_allclose(build_rotation_index(rounded, SEEN, GRID, PARAMS).match(rounded[2], SEEN).score, 1.0, atol=1e-6)


def test_the_ratio_tells_how_distinct_a_match_is():
    assert np.isnan(build_rotation_index(LEVEL[:1], SEEN, GRID, PARAMS).match(LEVEL[0], SEEN).ratio)
    alone = build_rotation_index(LEVEL[:1], SEEN, GRID, PARAMS).match(LEVEL[0], SEEN)
    assert alone.runner_up == -1
    twice = build_rotation_index(LEVEL[[0, 0, 1]], SEEN, GRID, PARAMS).match(query(0, rotation_matrix(0.3, 0.2)), SEEN)
    assert {int(twice.reference), int(twice.runner_up)} == {0, 1}
    assert twice.ratio == pytest.approx(1.0)


def test_tilts_beyond_half_a_turn_are_searched_if_asked_for():
    everywhere = np.ones(GRID.n_directions, bool)
    index = build_rotation_index(LEVEL, everywhere, GRID, replace(PARAMS, max_tilt=np.pi))
    upside_down = rotation_matrix(0.5, 0.1, np.pi - 0.2)
    match = index.match(query(2, upside_down), everywhere)
    assert match.reference == 2
    assert degrees(match.rotation, upside_down) < 0.5


def test_nothing_given_is_changed():
    views, mask = LEVEL.copy(), SEEN.copy()
    views.setflags(write=False)
    mask.setflags(write=False)
    build_rotation_index(views, mask, GRID, PARAMS).match(views[0], mask)
    assert_array_equal(views, LEVEL)


DOWN = -GRID.directions[:, 2] >= 0.5
BRIGHT = np.where(SEEN, 1.0, 0.0)


@pytest.mark.parametrize(
    ("views", "seen", "sentence"),
    [
        (LEVEL[0, :-1], SEEN[:-1], r"views have shape \(7199,\), expected \(\.\.\., 7200\) or \(\.\.\., 60, 120\), as"),
        (LEVEL[:0], SEEN, r"views have shape \(0, 7200\), expected at least one view"),
        (LEVEL, SEEN[:-1], r"seen has shape \(7199,\), expected to broadcast to the views, \(6, 7200\)"),
        (LEVEL, SEEN.astype(float), "seen holds float64 values, expected True and False"),
        (LEVEL * 1j, SEEN, "views holds complex128 values, expected real numbers"),
        (LEVEL, np.zeros_like(SEEN), "query 0 has no direction that was seen, expected some"),
        (np.where(SEEN, np.nan, LEVEL), SEEN, r"query 0, where seen, is nan at index 0 \("),
        (255.0 * LEVEL, SEEN, "query 0 reaches 2.*, expected 0 to 1: bytes as floats, or meant for the score 'corr"),
        (BRIGHT, SEEN, "query 0 has one value, 1, in all that was seen, which fits at every rotation"),
        (np.stack([LEVEL[0], BRIGHT]), SEEN, "query 1 has one value"),
        (LEVEL[0], DOWN, "query 0 shares less than 0.25 of what was seen with every reference at all tilts up to 60°"),
    ],
)
def test_bad_queries_are_refused_in_a_sentence(views, seen, sentence):
    index = build_rotation_index(
        LEVEL[:2], cap(GRID.directions, 40.0), GRID, replace(PARAMS, max_tilt=np.deg2rad(60.0))
    )
    with pytest.raises(InputError, match=f"^{sentence}") as caught:
        index.match(views, seen)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (
            lambda: build_rotation_index(LEVEL[0], SEEN, GRID, PARAMS),
            r"views have shape \(7200,\), expected one axis of",
        ),
        (
            lambda: build_rotation_index(LEVEL, SEEN, GRID),
            "the directions of equirectangular 3° are 3° apart, expected",
        ),
        (lambda: build_rotation_index(BRIGHT[None], SEEN, GRID, PARAMS), "reference 0 has one value"),
        (lambda: RotationParams(score="xor"), "score 'xor' is unknown: expected one of difference, correlation"),
        (lambda: RotationParams(max_tilt=90.0), "max_tilt is 90, expected 0 to 3.14159 rad: degrees"),
        (lambda: RotationParams(n_turns=45), "n_turns is 45, expected an even number"),
        (lambda: RotationParams(n_refined=0), "n_refined is 0, expected a whole number of at least 1"),
        (lambda: RotationParams(fine_blur=4.0), "fine_blur is 4, expected 0.001 to 0.6 rad: degrees"),
        (lambda: RotationParams(least_overlap=0.0), "least_overlap is 0, expected 0.01 to 1"),
    ],
)
def test_bad_references_and_parameters_are_refused_in_a_sentence(call, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        call()


def test_points_without_rows_will_do():
    points = fibonacci(6000)
    seen = cap(points.directions)
    index = build_rotation_index(np.array([seen_by(sky, points, np.eye(3)) for sky in SKIES]), seen, points, PARAMS)
    rotation = rotation_matrix(0.9, 0.5)
    match = index.match(query(1, rotation, points), seen)
    assert match.reference == 1
    assert degrees(match.rotation, rotation) < 0.5
    assert index.n_references == 6
    assert index.n_bytes > 6 * index.fine.n_nodes * 4


def test_differences_to_every_reference_are_those_of_the_best_plain_score():
    truth = rotation_matrix(1.1, 0.4, 0.2)
    views = np.stack([query(3, truth), query(0, np.eye(3))])
    match, differences = INDEX.match_and_compare(views, SEEN)
    assert_same(match, INDEX.match(views, SEEN))
    assert_array_equal(differences, INDEX.compare(views, SEEN))
    assert differences.shape == (2, 6)
    assert_array_equal(np.argmin(differences, axis=1), [3, 0])
    assert differences[1, 0] < 1e-6
    # The coarse search blurs by 4°, and so sees less of a difference than there is, but most of it.
    turns = Rotation.random(4000, random_state=2).as_matrix()
    turns = turns[np.arccos(np.clip(turns[:, 2, 2], -1.0, 1.0)) < np.pi / 2][:600]
    for number in (1, 5):
        here = (lambda d: SKIES[3](to_world(d, truth)), cap)
        best = max(plain_score(here, (SKIES[number], cap), turn, n=300) for turn in turns)
        assert 0.6 * (1.0 - best) < differences[0, number] < 1.0 - best + 0.01
    with pytest.raises(InputError):
        INDEX.match_and_compare(views[:, :-1], SEEN)


def test_a_reference_that_shares_too_little_is_the_most_different():
    apart = build_rotation_index(
        np.stack([LEVEL[0], seen_by(SKIES[1], GRID, np.eye(3))]),
        np.stack([SEEN, GRID.directions[:, 2] < -0.4]),
        GRID,
        replace(PARAMS, max_tilt=np.deg2rad(10.0)),
    )
    _, differences = apart.match_and_compare(LEVEL[0], SEEN)
    assert_allclose(differences, [0.0, 1.0], atol=1e-6)


def test_a_part_of_the_references_gives_what_these_give():
    truth = rotation_matrix(1.1, 0.4, 0.2)
    view = query(3, truth)
    whole, part = INDEX.match(view, SEEN), INDEX.part([5, 3, 1]).match(view, SEEN)
    assert part.reference == 1
    assert_array_equal(part.rotation, whole.rotation)
    assert_array_equal(part.score, whole.score)
    alone = INDEX.part(np.array([2])).match(view, SEEN)
    assert (alone.reference, alone.runner_up) == (0, -1)
    assert_same(alone, build_rotation_index(LEVEL[2:3], SEEN, GRID, PARAMS).match(view, SEEN))


@pytest.mark.parametrize(
    ("references", "sentence"),
    [
        ([], r"references have shape \(0,\) and type float64, expected some whole numbers"),
        ([0.5], r"references have shape \(1,\) and type float64, expected some whole numbers"),
        ([[1]], r"references have shape \(1, 1\)"),
        ([2, 6], "references"),
        ([-1], "references"),
    ],
)
def test_a_part_of_what_is_not_there_is_refused(references, sentence):
    with pytest.raises(InputError, match=sentence):
        INDEX.part(references)
