"""Maps of places: what goes in comes out, and is found as by `seqslam`."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from insectnav.checks import InputError
from insectnav.matching import (
    METRICS,
    OPENSEQSLAM_V1,
    MapAbout,
    PlaceMap,
    SeqSlamParams,
    difference_matrix,
    enhance_contrast,
    merge_maps,
    seqslam,
)
from insectnav.matching.place_arrays import new_places
from insectnav.matching.place_exact_search import (
    landscape_of,
    lines_of_pieces,
    matches_of_differences,
    matches_of_lines,
)
from insectnav.matching.place_pieces import join_pieces, map_pieces

RNG = np.random.default_rng(0)
ROUTE = np.cumsum(RNG.normal(size=(300, 24)), axis=0)
QUERIES = ROUTE[40:110] + 0.3 * RNG.normal(size=(70, 24))
ABOUT = MapAbout(descriptor="walk", metric="euclidean", n_features=24)


def of_kind(metric, vectors):
    if metric == "hamming":
        return vectors > 0
    return np.clip(vectors + 128, 0, 255).astype(np.uint8) if metric == "openseqslam-v1" else vectors


def same(found, expected):
    for ours, theirs in zip(found, expected, strict=True):
        assert_array_equal(ours, theirs)


@pytest.mark.parametrize("metric", METRICS)
@pytest.mark.parametrize("params", [SeqSlamParams(), SeqSlamParams(sequence_length=1), OPENSEQSLAM_V1])
def test_one_route_is_matched_as_by_seqslam_to_the_bit(tmp_path, metric, params):
    route, queries = of_kind(metric, ROUTE), of_kind(metric, QUERIES)
    about = MapAbout(descriptor="x", metric=metric, n_features=24)
    found = PlaceMap.build(tmp_path / "map", route, about).locate(queries, params)
    same(found, seqslam(difference_matrix(route, queries, metric), params))
    assert (found.reference >= 0).any()


@pytest.mark.parametrize("n_features", [24, 600])
def test_missing_frames_are_bridged_as_by_seqslam(tmp_path, n_features):
    route = np.cumsum(RNG.normal(size=(60, n_features)), axis=0)
    queries = route[10:50] + 0.1 * RNG.normal(size=(40, n_features))
    route[[20, 21, 40]], queries[[3, 22]] = np.nan, np.nan
    found = PlaceMap.build(tmp_path / "map", route, MapAbout(descriptor="x", metric="euclidean", n_features=n_features))
    same(found.locate(queries), seqslam(difference_matrix(route, queries, "euclidean")))
    lost = PlaceMap.build(tmp_path / "lost", np.full((60, 24), np.nan), ABOUT).locate(QUERIES)
    assert (lost.reference == -1).all()


def plain_search(routes, difference, params):
    """Best and next best line of each sequence, one start and speed at a time, on several routes."""
    offsets, half, n = params.offsets, params.unique_window // 2, params.n_steps
    contrast = np.concatenate([enhance_contrast(difference[routes == k], params) for k in np.unique(routes)])
    reference, score = [], []
    for i in range(difference.shape[1] - n):
        sums = np.full(len(routes), np.inf)
        for s in range(len(routes)):
            for offset in offsets:
                end = s + offset[-1]
                if end < len(routes) and routes[end] == routes[s]:
                    sums[s] = min(sums[s], sum(contrast[s + offset[k], i + k] for k in range(n + 1)))
        best = int(np.argmin(sums))
        is_near = (np.abs(np.arange(len(routes)) - best) <= half) & (routes == routes[best])
        reference.append(best)
        score.append(sums[best] / sums[~is_near].min())
    return np.array(reference), np.array(score)


def test_lines_and_windows_do_not_reach_across_a_seam(tmp_path):
    params = SeqSlamParams(sequence_length=4, contrast_window=6, unique_window=8, place="start")
    routes = np.repeat([0, 1, 2, 3], [23, 14, 5, 18])
    made = PlaceMap.create(tmp_path / "map", ABOUT)
    for k in range(4):
        made.add(ROUTE[:60][routes == k], new_route=True)
    assert_array_equal(made.routes, routes)
    found = made.locate(ROUTE[:60], params)
    reference, score = plain_search(routes, difference_matrix(ROUTE[:60], ROUTE[:60], "euclidean"), params)
    assert_array_equal(found.reference[2:-2], reference + 2)
    np.testing.assert_allclose(found.score[2:-2], score, rtol=1e-12)
    starts = found.reference[2:-2] - 2
    assert_array_equal(routes[starts + np.rint(4 * found.speed[2:-2]).astype(int)], routes[starts])


@pytest.mark.parametrize("params", [SeqSlamParams(sequence_length=4), OPENSEQSLAM_V1])
def test_differences_that_are_known_are_matched_as_on_the_routes_of_a_map(tmp_path, params):
    """With one baseline for all routes, also where it is the least contrast that was observed."""
    route, queries = ROUTE[:150].copy(), QUERIES.copy()
    route[[20, 90]], queries[[3, 22]] = np.nan, np.nan
    made = PlaceMap.create(tmp_path / "map", ABOUT)
    for k, part in enumerate(np.split(route, [60, 100])):
        made.add(part + 5.0 * k, new_route=True)
    difference = difference_matrix(np.asarray(made.descriptors, float), queries, "euclidean")
    found = made.locate(queries, params)
    for workers in (1, 2):
        known = matches_of_differences(difference, np.asarray(made.routes), params, workers)
        assert_array_equal(known.reference, found.reference)
        np.testing.assert_allclose(known.score, found.score, rtol=1e-9)
    assert len(np.unique(np.asarray(made.routes)[found.reference[found.reference >= 0]])) > 1


@settings(max_examples=40, deadline=None)
@given(
    lengths=st.lists(st.integers(1, 40), min_size=1, max_size=4).filter(lambda lengths: sum(lengths) > 12),
    size=st.integers(1, 50),
    ds=st.sampled_from([1, 4, 10]),
    window=st.integers(0, 30),
    baseline=st.sampled_from(["bound", "observed"]),
    seed=st.integers(0, 2**31),
)
def test_pieces_of_any_size_give_the_bits_of_the_whole(lengths, size, ds, window, baseline, seed):
    rng = np.random.default_rng(seed)
    route = rng.integers(0, 3, (sum(lengths), 2)).astype(float)  # with many equal sums
    params = SeqSlamParams(sequence_length=ds, unique_window=window, contrast_window=6, baseline=baseline)
    places = places_on(route, np.repeat(np.arange(len(lengths)), lengths))
    landscape = landscape_of(places, "euclidean")
    queries = rng.integers(0, 3, (15, 2)).astype(float)

    def search(size):
        lines = lines_of_pieces(landscape, map_pieces(places.routes, params, size), queries, params, 1)
        return matches_of_lines(join_pieces(lines, params), np.ones(15, bool), params)

    same(search(size), search(10**6))


def places_on(route, routes):
    about = MapAbout(descriptor="x", metric="euclidean", n_features=route.shape[1])
    return replace(new_places(about, route), routes=routes)


def test_threads_and_blocks_change_nothing(tmp_path, monkeypatch):
    made = PlaceMap.build(tmp_path / "map", ROUTE, ABOUT)
    expected = made.locate(QUERIES, workers=1)
    monkeypatch.setattr("insectnav.matching.place_exact_search.SEQUENCES_PER_BLOCK", 7)
    monkeypatch.setattr("insectnav.matching.place_exact_search.TASKS_AT_ONCE", 3)
    same(made.locate(QUERIES, workers=3), expected)


def test_what_was_added_comes_back(tmp_path):
    made = PlaceMap.create(tmp_path / "map", ABOUT)
    assert (made.n_places, made.names, made.descriptors.shape) == (0, (), (0, 24))
    names = [f"véu{i}.png" for i in range(300)]
    positions = RNG.normal(size=(300, 3))
    for first in range(0, 300, 7):
        of = slice(first, first + 7)
        made.add(
            ROUTE[of],
            names=names[of],
            times=np.arange(300.0)[of],
            positions=positions[of],
            new_route=first == 140,
        )
    for kept in (made, PlaceMap.open(tmp_path / "map")):
        assert_array_equal(kept.descriptors, ROUTE)
        assert_array_equal(kept.times, np.arange(300))
        assert_array_equal(kept.positions, positions)
        assert_array_equal(kept.routes, np.arange(300) >= 140)
        assert (kept.names, kept.n_places, kept.is_frozen) == (tuple(names), 300, False)
    assert len(list((tmp_path / "map" / "segments").iterdir())) < 16  # small ones were merged
    made.freeze()
    for kept in (made, PlaceMap.open(tmp_path / "map")):
        assert_array_equal(kept.descriptors, ROUTE)
        assert (kept.names, kept.is_frozen) == (tuple(names), True)
    with pytest.raises(InputError, match=r"is frozen, expected one that can be added to$"):
        made.add(ROUTE)


@pytest.mark.parametrize("dtype", [bool, np.uint8, np.float32, np.float64])
def test_numbers_stay_of_their_type(tmp_path, dtype):
    values = (RNG.random((20, 13)) * 2).astype(dtype)
    about = MapAbout(descriptor="x", metric="hamming" if dtype is bool else "absolute", n_features=13)
    PlaceMap.build(tmp_path / "map", values, about).add(values)
    found = PlaceMap.open(tmp_path / "map").descriptors
    assert found.dtype == dtype
    assert_array_equal(found, np.concatenate([values, values]))


def test_the_arrays_are_zarr(tmp_path):
    import zarr

    PlaceMap.build(tmp_path / "map", ROUTE, ABOUT, times=np.zeros(300))
    group = zarr.open_group(tmp_path / "map" / "segments" / "00000000-00000000", mode="r")
    assert_array_equal(group["descriptors"][...], ROUTE)
    assert_array_equal(group["times"][...], np.zeros(300))
    assert group["descriptors"].metadata.dimension_names == ("place", "feature")


def test_maps_merge_and_keep_their_routes(tmp_path):
    first = PlaceMap.build(tmp_path / "a", ROUTE[:100], ABOUT, names=["a"] * 100)
    second = PlaceMap.create(tmp_path / "b", ABOUT)
    for k in range(2):
        second.add(ROUTE[100 + 50 * k : 150 + 50 * k], new_route=True)
    second.freeze()
    whole = merge_maps(tmp_path / "whole", [first, PlaceMap.create(tmp_path / "empty", ABOUT), second])
    assert_array_equal(whole.descriptors, ROUTE[:200])
    assert_array_equal(whole.routes, np.repeat([0, 1, 2], [100, 50, 50]))
    assert whole.names == ("a",) * 100 + ("",) * 100


SETTINGS = {"size": 64, "sky": "otsu"}


@pytest.mark.parametrize(
    ("other", "sentence"),
    [
        ({"descriptor": "zernike"}, "descriptor of the queries is 'zernike', expected 'walk' as of the map"),
        ({"metric": "cosine"}, "metric of the queries is 'cosine', expected 'euclidean'"),
        ({"n_features": 23}, "n_features of the queries is '23', expected '24'"),
        ({"camera": "fisheye"}, "camera of the queries is 'fisheye', expected 'panorama'"),
        ({"settings": {"size": 32, "sky": "otsu"}}, "setting 'size' of the queries is '32', expected '64'"),
        ({"settings": {"size": 64}}, "setting 'sky' of the queries is 'None', expected 'otsu'"),
    ],
)
def test_what_was_described_in_another_way_is_refused(tmp_path, other, sentence):
    given = {"descriptor": "walk", "metric": "euclidean", "n_features": 24, "camera": "panorama", "settings": SETTINGS}
    made = PlaceMap.build(tmp_path / "map", ROUTE, MapAbout(**given))
    assert made.locate(QUERIES, about=MapAbout(**given | {"camera": "", "origin_deg": (1.0, 2.0)})).reference.max() > 0
    with pytest.raises(InputError, match=f"^{sentence}"):
        made.locate(QUERIES, about=MapAbout(**given | other))


def refused(call):
    with pytest.raises(InputError) as caught:
        call()
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_bad_input_is_refused_in_a_sentence(tmp_path):
    made = PlaceMap.build(tmp_path / "map", ROUTE.astype(np.float32), ABOUT)
    before = made.n_places
    assert refused(lambda: made.locate(QUERIES[:10])).startswith("there are 10 queries, expected at least 11")
    assert refused(lambda: made.locate(QUERIES[:, :9])).startswith("queries have 9 features, expected 24")
    assert refused(lambda: made.locate(QUERIES, search="fast")).startswith("search 'fast' is unknown")
    assert refused(lambda: made.locate(QUERIES, search="index")).endswith(
        "freeze() makes it: search='exact' needs none"
    )
    assert refused(lambda: made.add(ROUTE)).startswith("descriptors are float64, expected float32 as those in the map")
    assert refused(lambda: made.add(ROUTE[:, :3])).startswith("descriptors have 3 features, expected 24")
    assert refused(lambda: made.add(ROUTE.astype(int))).startswith("descriptors hold int64 values")
    assert refused(lambda: made.add(ROUTE[0])).startswith("descriptors have shape (24,)")
    single = ROUTE[:3].astype(np.float32)
    assert refused(lambda: made.add(single, times=[1.0])).startswith("times has shape (1,), expected (3,)")
    assert refused(lambda: made.add(single, positions=np.zeros((3, 2)))).startswith("positions has shape (3, 2)")
    assert refused(lambda: made.add(single, times=[1, 2, np.inf])).startswith("times or positions are infinite")
    assert refused(lambda: made.add(single, names=["a"])).startswith("there are 1 names, expected one for each of 3")
    assert refused(lambda: made.add(single, names=["a", 2, "c"])).startswith("name 1 is '2', expected text")
    assert PlaceMap.open(made.path).n_places == before
    short = PlaceMap.build(tmp_path / "short", ROUTE[:8].astype(np.float32), ABOUT)
    assert refused(lambda: short.locate(QUERIES)).startswith(
        "the longest route of the map has 8 places, expected at least 9 for sequences of 10 steps"
    )
    empty = PlaceMap.create(tmp_path / "empty", ABOUT)
    assert refused(lambda: empty.locate(QUERIES)).endswith("is empty, expected one with places to compare with")
    assert refused(empty.freeze).endswith("is empty, expected one with places, not yet frozen")
    assert refused(lambda: PlaceMap.create(tmp_path, ABOUT)).endswith("expected a new or empty folder for the map")
    assert refused(lambda: merge_maps(tmp_path / "m", [])).startswith("there are no maps to merge")
    elsewhere = PlaceMap.create(tmp_path / "e", MapAbout(**ABOUT.as_json() | {"origin_deg": (1.0, 2.0)}))
    assert "positions from one origin?" in refused(lambda: merge_maps(tmp_path / "m", [made, elsewhere]))
    bits = MapAbout(descriptor="x", metric="hamming", n_features=24)
    assert refused(lambda: PlaceMap.build(tmp_path / "b", ROUTE, bits)).startswith("descriptors hold values other than")
    assert not (tmp_path / "b").exists()


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"metric": "manhattan"}, "metric 'manhattan' is unknown"),
        ({"descriptor": ""}, "descriptor is an empty word"),
        ({"n_features": 0}, "n_features is 0, expected a whole number"),
        ({"n_features": 2**40}, "n_features is 1099511627776, expected at most"),
        ({"settings": {"a": [1]}}, r"setting 'a' is '\[1\]', expected text"),
        ({"settings": {"a": float("nan")}}, "setting 'a' is 'nan', expected text"),
        ({"settings": {3: 1}}, "name of a setting is '3', expected text"),
        ({"camera": "x" * 2000}, "camera has 2000 characters"),
        ({"origin_deg": (91.0, 0.0)}, "latitude of origin_deg is 91"),
        ({"origin_deg": 3}, "origin_deg is '3', expected latitude and longitude"),
    ],
)
def test_what_a_map_cannot_be_about_is_refused(wrong, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        MapAbout(**{"descriptor": "x", "metric": "cosine", "n_features": 3} | wrong)
