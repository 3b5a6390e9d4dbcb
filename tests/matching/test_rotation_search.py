"""The coarse search: sums over the overlap by Fourier transform are plain sums, and the search leaves no gap."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from bumpy_skies import bumpy_sky, cap, cap_without_sector
from insectnav.matching.rotation_matches import rotation_between
from insectnav.matching.rotation_refinement import Candidate, refined, seen_points
from insectnav.matching.rotation_search import (
    KINDS,
    best_rotations,
    ring_grid,
    ring_spectra,
    rotation_of,
    tilt_rotations,
)
from insectnav.matching.view_maps import blur_to_cube, look_up
from insectnav.vision import to_eye
from insectnav.vision.sphere import equirectangular, rotation_matrix

GRID = equirectangular(5.0)
BLUR = blur_to_cube(GRID, np.deg2rad(5.0), "coarse_blur")
N_TURNS = 24
TILTS = tilt_rotations(np.deg2rad(30.0), np.deg2rad(60.0))
MASKS = [cap(GRID.directions), cap_without_sector(GRID.directions, 20, 70), cap(GRID.directions, 105.0)]
SKIES = np.array([bumpy_sky(seed)(GRID.directions) for seed in range(4)], np.float32)


def maps_of(skies, masks):
    return BLUR(np.asarray(skies, np.float32), np.asarray(masks))


def plain_scores(query, reference, kind, least):
    """Best score over tilts and turns and its place, by lookups of the query at every rotation: no transform."""
    rings, weights = ring_grid(N_TURNS)
    r = look_up(reference[None], BLUR.n_cells, rings)[0]
    scores = np.full((len(TILTS), N_TURNS), -np.inf)
    for place in range(scores.size):
        rotation = rotation_of(place, TILTS, N_TURNS)
        q = look_up(query[None], BLUR.n_cells, to_eye(rings, rotation))[0]
        w = np.broadcast_to(weights[:, None], q.shape)[np.isfinite(q) & np.isfinite(r)]
        here, there = q[np.isfinite(q) & np.isfinite(r)].astype(float), r[np.isfinite(q) & np.isfinite(r)].astype(float)
        if w.sum() < least:
            continue
        if kind == "difference":
            score = 1.0 - np.average((here - there) ** 2, weights=w)
        else:
            a, b = here - np.average(here, weights=w), there - np.average(there, weights=w)
            score = np.sum(w * a * b) / np.sqrt(np.sum(w * a * a) * np.sum(w * b * b))
        scores.flat[place] = score
    return scores


@pytest.mark.parametrize("kind", ["difference", "correlation"])
@pytest.mark.parametrize("query_mask", [0, 1])
def test_scores_are_those_of_plain_sums_whatever_the_masks(kind, query_mask):
    references = maps_of(SKIES[:3], MASKS)
    query = maps_of(SKIES[3:], MASKS[query_mask : query_mask + 1])[0]
    least = np.full(3, 1.0)
    spectra = ring_spectra(references, BLUR.n_cells, N_TURNS)
    assert spectra.masks.shape[-1] == 3
    scores, places = best_rotations(query, BLUR.n_cells, TILTS, spectra, least, kind)
    for k in range(3):
        expected = plain_scores(query, references[k], kind, 1.0)
        # Directions are rounded otherwise here, and a lookup at the edge of a mask may fall either way.
        assert scores[k] == pytest.approx(expected.max(), abs=2e-3)
        assert expected.flat[places[k]] == pytest.approx(expected.max(), abs=4e-3)


@pytest.mark.parametrize("kind", ["difference", "correlation"])
def test_a_shared_mask_gives_what_masks_of_their_own_give(kind):
    shared = ring_spectra(maps_of(SKIES, [MASKS[0]] * 4), BLUR.n_cells, N_TURNS)
    assert shared.masks.shape[-1] == 1
    own = replace(shared, masks=np.repeat(shared.masks, 4, axis=-1), mask_of=np.arange(4))
    query, least = maps_of(SKIES[:1], MASKS[1:2])[0], np.full(4, 1.0)
    one = best_rotations(query, BLUR.n_cells, TILTS, shared, least, kind)
    other = best_rotations(query, BLUR.n_cells, TILTS, own, least, kind)
    assert_allclose(one[0], other[0], rtol=1e-5)
    assert_array_equal(one[1], other[1])


def test_more_references_than_are_searched_at_once():
    many = np.tile(np.arange(4), 40)
    masks = [MASKS[k % 2] for k in many]
    spectra = ring_spectra(maps_of(SKIES[many], masks), BLUR.n_cells, N_TURNS)
    query, least = maps_of(SKIES[1:2], MASKS[:1])[0], np.full(160, 1.0)
    scores, places = best_rotations(query, BLUR.n_cells, TILTS, spectra, least, "difference")
    assert_allclose(scores.reshape(40, 4), np.tile(scores[:4], (40, 1)), rtol=1e-5)
    assert_array_equal(places.reshape(40, 4), np.tile(places[:4], (40, 1)))


def test_what_overlaps_too_little_has_no_place():
    spectra = ring_spectra(maps_of(SKIES[:2], MASKS[:2]), BLUR.n_cells, N_TURNS)
    scores, places = best_rotations(
        maps_of(SKIES[:1], MASKS[:1])[0], BLUR.n_cells, TILTS, spectra, np.array([1.0, 13.0]), "difference"
    )
    assert np.isfinite(scores[0])
    assert (scores[1], places[1]) == (-np.inf, -1)


@pytest.mark.parametrize(("spacing_deg", "max_deg"), [(10, 90), (10, 180), (20, 60)])
def test_every_rotation_is_near_one_that_is_searched(spacing_deg, max_deg):
    tilts = tilt_rotations(np.deg2rad(spacing_deg), np.deg2rad(max_deg))
    assert_allclose(tilts[0], np.eye(3))
    assert_allclose(tilts @ tilts.transpose(0, 2, 1), np.broadcast_to(np.eye(3), tilts.shape), atol=1e-12)
    upward = tilts[:, :, 2]
    assert np.rad2deg(np.arccos(np.clip(upward[:, 2].min(), -1, 1))) == pytest.approx(max_deg)
    axes = Rotation.random(2000, random_state=3).as_matrix()[:, :, 2]
    axes = axes[axes[:, 2] >= np.cos(np.deg2rad(max_deg))]
    nearest = np.rad2deg(np.arccos(np.clip((axes @ upward.T).max(axis=1), -1, 1)))
    assert nearest.max() < 0.8 * spacing_deg  # half the diagonal of a square is 0.71 of its side


def test_a_tilt_turns_the_upward_axis_alone():
    # The shortest rotation to a direction turns about a horizontal axis: no twist is left when it is undone.
    for tilt in tilt_rotations(np.deg2rad(30.0), np.deg2rad(150.0))[1:]:
        assert Rotation.from_matrix(tilt).as_rotvec()[2] == pytest.approx(0.0, abs=1e-9)


def test_a_turn_is_clockwise():
    place = 6  # no tilt, a quarter of 24 turns
    assert_allclose(rotation_of(place, TILTS, N_TURNS) @ [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], atol=1e-12)


def test_a_rotation_with_little_overlap_is_refined_all_the_same():
    """It may keep the overlap that it starts with, here less than what is asked for."""
    view = maps_of(SKIES[:1], MASKS[:1])[0]
    points = seen_points(view, BLUR.n_cells, 2000)
    start = rotation_matrix(np.deg2rad(4.0)) @ rotation_matrix(0.0, np.deg2rad(3.0))
    candidate = Candidate(0, start, 0.0, 0.0)
    steps = np.deg2rad(5.0), np.deg2rad(0.1)
    least = np.array([1.5 * points.area])
    found = refined([candidate], points, view[None], BLUR.n_cells, KINDS["difference"], least, steps)[0]
    assert np.rad2deg(rotation_between(found.rotation, np.eye(3))) < 0.5
    assert_array_equal(candidate.rotation, start)


def test_candidates_come_out_best_first():
    views = maps_of(SKIES[:2], [MASKS[0], MASKS[0]])
    points = seen_points(views[0], BLUR.n_cells, 2000)
    candidates = [Candidate(1, np.eye(3), 0.9, 0.0), Candidate(0, np.eye(3), 0.1, 0.0)]
    steps = np.deg2rad(5.0), np.deg2rad(0.5)
    found = refined(candidates, points, views, BLUR.n_cells, KINDS["difference"], np.zeros(2), steps)
    assert [candidate.reference for candidate in found] == [0, 1]
    assert found[0].score > found[1].score
