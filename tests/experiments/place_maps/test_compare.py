"""Views compared after all turns: along routes, across their borders, and one by one."""

from pathlib import Path

import numpy as np
from numpy.testing import assert_array_equal

from insectnav.experiments.place_maps.compare import compare
from insectnav.experiments.place_maps.describe import DescribeParams, describe
from insectnav.experiments.place_maps.view_cameras import view_camera
from insectnav.matching import difference_matrix, seqslam
from insectnav.matching.places import MapAbout, PlaceMap
from insectnav.matching.seqslam import SeqSlamParams
from place_scenes import panoramas

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
    place_map = made(tmp_path / "m", whole[:20], whole[20:])
    queries = features(whole[12:28])  # runs across the border, which a robot cannot
    found = compare(place_map, queries, PARAMS, SeqSlamParams(), "auto", None)
    routes = np.asarray(place_map.routes)
    n_across = 0
    for query in np.flatnonzero(found.matches.reference >= 0):
        ends = found.matches.reference[query] + np.array([-5, 5]) * found.matches.speed[query]
        inside = (np.round(ends) >= 0) & (np.round(ends) < 40)
        n_across += inside.all() and routes[int(round(ends[0]))] != routes[int(round(ends[1]))]
    alone = made(tmp_path / "alone", whole)
    joined = compare(alone, queries, PARAMS, SeqSlamParams(), "auto", None)
    assert_array_equal(joined.matches.reference[5:-5], np.arange(17, 23))
    assert n_across < 6


def test_without_turns_it_is_seqslam_on_normalised_views(tmp_path: Path):
    views = panoramas(30)
    flat = views.reshape(30, -1).astype(float)
    normal = (flat - flat.mean(axis=1, keepdims=True)) / flat.std(axis=1, keepdims=True)
    plain = seqslam(difference_matrix(normal, normal, "euclidean"))
    found = compare(made(tmp_path / "m", views), features(views), PARAMS, SeqSlamParams(), "auto", None)
    assert_array_equal(found.matches.reference, plain.reference)


def test_missing_views_have_no_match_one_by_one(tmp_path: Path):
    views = panoramas(12)
    queries = features(views)
    queries[3] = np.nan
    found = compare(made(tmp_path / "m", views), queries, PARAMS, SeqSlamParams(sequence_length=1), "auto", None)
    assert_array_equal(found.matches.reference, [0, 1, 2, -1, *range(4, 12)])
    assert np.isnan(found.matches.score[3])
    assert found.matches.score[4] < 0.1
