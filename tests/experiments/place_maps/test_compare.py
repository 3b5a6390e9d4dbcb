"""Views compared after all turns: along routes, across their borders, and one by one."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.experiments.place_maps.compare import compare
from insectnav.experiments.place_maps.describe import DescribeParams, describe
from insectnav.experiments.place_maps.view_cameras import grid, grid_resampler, view_camera
from insectnav.matching import build_rotation_index, seqslam, turn_matrix
from insectnav.matching.places import MapAbout, PlaceMap
from insectnav.matching.seqslam import SeqSlamParams
from place_scenes import panoramas, sky_disk, skylines

PARAMS = DescribeParams(descriptor="turned-views", camera=view_camera("panorama")).settled(panoramas(1)[0])


def features(views: np.ndarray) -> np.ndarray:
    return np.stack([describe(view, PARAMS) for view in views])


def made(folder: Path, *routes: np.ndarray) -> PlaceMap:
    about = MapAbout(
        descriptor="turned-views", metric="euclidean", n_features=3600, camera="panorama", settings=PARAMS.settings()
    )
    place_map = PlaceMap.create(folder, about)
    for number, views in enumerate(routes):
        place_map.add(features(views), new_route=number > 0)
    return place_map


def test_sequences_of_turned_views_are_found_on_their_own_route(tmp_path: Path):
    first, second = panoramas(25, seed=1), panoramas(25, seed=2)
    place_map = made(tmp_path / "m", first, second)
    queries = np.roll(second, -10, axis=2)  # turned to the right by 30°
    found = compare(place_map, features(queries), PARAMS, SeqSlamParams(), "auto", None)
    assert_array_equal(found.matches.reference[5:-5], np.arange(30, 45))
    assert found.angles_deg is not None
    assert np.abs(found.angles_deg[5:-5, 0] - 30.0).max() < 1e-9
    assert np.isnan(found.angles_deg[5:-5, 1:]).all()


def test_no_line_leads_from_one_route_into_the_next(tmp_path: Path):
    whole = panoramas(40)
    queries = features(whole[12:28])  # run across the border, which a robot cannot
    joined = compare(made(tmp_path / "one", whole), queries, PARAMS, SeqSlamParams(), "auto", None)
    assert_array_equal(joined.matches.reference[5:-5], np.arange(17, 23))
    parted = compare(made(tmp_path / "two", whole[:20], whole[20:]), queries, PARAMS, SeqSlamParams(), "auto", None)
    for query in range(5, 11):
        reference, speed = parted.matches.reference[query], parted.matches.speed[query]
        first, last = reference - 5 * speed, reference + 5 * speed
        assert (first > -1 and last < 20) or (first > 19 and last < 40)


@pytest.mark.parametrize("missing", [(), (3, 4), (20,)])
def test_on_one_route_it_is_seqslam(tmp_path: Path, missing: tuple[int, ...]):
    views = panoramas(40)
    known, seen = features(views), features(np.roll(views[4:34], -7, axis=2))
    seen[list(missing)] = np.nan
    place_map = made(tmp_path / "m", views)
    difference = turn_matrix(known.reshape(-1, 30, 120), seen.reshape(-1, 30, 120)).difference
    for params in (SeqSlamParams(), SeqSlamParams(sequence_length=6, slowest=0.5, fastest=2.0, unique_window=4)):
        plain = seqslam(difference, params)
        found = compare(place_map, seen, PARAMS, params, "auto", None).matches
        assert_array_equal(found.reference, plain.reference)
        assert_allclose(found.score, plain.score, rtol=1e-9)
        assert_array_equal(found.speed, plain.speed)


@pytest.mark.parametrize("n_short", [9, 10])
def test_a_route_that_only_slow_lines_fit_on_is_found(tmp_path: Path, n_short: int):
    """Nine places hold a line of ten steps at 0.8 places per query, as in maps that are searched otherwise."""
    long, short = panoramas(30, seed=4), panoramas(n_short, seed=3)
    slow = short[np.floor(0.8 * np.arange(11)).astype(int)]
    place_map, queries = made(tmp_path / "m", long, short), features(np.roll(slow, -10, axis=2))
    found = compare(place_map, queries, PARAMS, SeqSlamParams(), "auto", None)
    assert found.matches.reference[5] == 30 + 4
    assert found.matches.speed[5] == pytest.approx(0.8)
    assert found.angles_deg is not None
    assert found.angles_deg[5, 0] == pytest.approx(30.0)
    one_by_one = SeqSlamParams(unique_window=0)  # else the other place of ten is no rival to tell from
    alone = compare(made(tmp_path / "alone", short), queries, PARAMS, one_by_one, "auto", None).matches
    assert alone.reference[5] == (4 if n_short == 10 else -1)  # of nine places there is one line alone


def test_missing_views_have_no_match_one_by_one(tmp_path: Path):
    views = panoramas(12)
    queries = features(views)
    queries[3] = np.nan
    found = compare(made(tmp_path / "m", views), queries, PARAMS, SeqSlamParams(sequence_length=1), "auto", None)
    assert_array_equal(found.matches.reference, [0, 1, 2, -1, *range(4, 12)])
    assert np.isnan(found.matches.score[3])
    assert found.matches.score[4] < 0.1


@pytest.mark.parametrize("metric", ["euclidean", "cosine", "absolute"])
def test_single_frames_are_matched_with_the_most_alike_place(tmp_path: Path, metric: str):
    rng = np.random.default_rng(5)
    known = rng.normal(size=(30, 8))
    seen = rng.normal(size=(20, 8))
    seen[4] = np.nan
    place_map = PlaceMap.build(tmp_path / "m", known, MapAbout(descriptor="mine", metric=metric, n_features=8))
    params = SeqSlamParams(sequence_length=1, unique_window=4)
    own = DescribeParams(descriptor="mine", metric=metric, is_vectors=True)
    found = compare(place_map, seen.astype(np.float32), own, params, "auto", None).matches
    plain = {
        "euclidean": lambda a, b: np.linalg.norm(a - b),
        "cosine": lambda a, b: 1 - a @ b / np.linalg.norm(a) / np.linalg.norm(b),
        "absolute": lambda a, b: np.abs(a - b).mean(),
    }[metric]
    for k, query in enumerate(seen):
        if k == 4:
            assert found.reference[k] == -1
            continue
        apart = np.array([plain(place, query) for place in known])
        best = apart.argmin()
        others = np.abs(np.arange(30) - best) > 2
        assert found.reference[k] == best
        assert found.score[k] == pytest.approx(apart[best] / apart[others].min(), rel=1e-4)


def test_the_score_of_a_single_sky_is_told_from_places_outside_the_window(tmp_path: Path):
    camera = view_camera("fisheye:180")
    skies = [sky_disk(one, turn_deg=turn) for one in skylines()[::10] for turn in (0.0, 1.0)]  # each place twice
    params = DescribeParams(descriptor="rotations", camera=camera, sky="mask").settled(skies[0])
    views = np.stack([describe(sky, params) for sky in skies])
    queries = np.stack([describe(sky_disk(one + 3.0), params) for one in skylines()[::10]])
    about = MapAbout(
        descriptor="rotations",
        metric=params.used_metric,
        n_features=views.shape[1],
        camera=camera.text,
        settings=params.settings(),
    )
    place_map = PlaceMap.create(tmp_path / "m", about)
    place_map.add(views)
    near, far = (
        compare(
            place_map, queries, params, SeqSlamParams(sequence_length=1, unique_window=window), "auto", None
        ).matches
        for window in (0, 2)
    )
    assert_array_equal(near.reference, far.reference)
    assert_array_equal(far.reference // 2, np.arange(4))
    assert (far.score < 0.8 * near.score).all()
    index = build_rotation_index(views, grid_resampler(camera, params.view_size).seen, grid())
    difference = index.match_and_compare(queries, grid_resampler(camera, params.view_size).seen)[1]
    for query, match in enumerate(far.reference):
        for found, window in ((near, 0), (far, 1)):
            others = [difference[query, k] for k in range(8) if abs(k - match) > window]
            # differences are of the order of 0.1, and good to 1e-5 by transforms in single precision
            assert_allclose(found.score[query], min(difference[query, match] / min(others), 1.0), atol=1e-3)
