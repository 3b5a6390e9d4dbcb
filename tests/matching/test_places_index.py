"""Large maps: an index proposes lines, which are scored as by comparing with all; and one frame at a time."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from dask_cluster import environment
from insectnav.checks import InputError
from insectnav.matching import METRICS, OPENSEQSLAM_V1, MapAbout, PlaceMap, SeqSlamParams
from insectnav.matching.place_arrays import new_places
from insectnav.matching.place_index import build_index
from insectnav.matching.place_index_search import coarse_speeds
from insectnav.matching.place_vote_kernel import propose_starts

RNG = np.random.default_rng(2)
N, FEATURES = 6000, 32


def made_route(n: int) -> np.ndarray:
    """Features that forget half of what they were within seven frames, on four traverses' worth of places."""
    route = RNG.normal(size=(n, FEATURES))
    for i in range(1, n):
        route[i] = 0.9 * route[i - 1] + np.sqrt(1 - 0.9**2) * route[i]
    return (8.0 + route).astype(np.float32)


ROUTE = made_route(N)
PLACE = np.linspace(3000.0, 3110.0, 100)  # 1.11 frames of the map a frame, across no seam
QUERIES = np.stack([np.interp(PLACE, np.arange(N), column) for column in ROUTE.T], axis=1)
QUERIES = (QUERIES + 0.6 * RNG.normal(size=QUERIES.shape)).astype(np.float32)


def of_kind(metric, vectors):
    return (16 * vectors).astype(np.uint8) if metric == "openseqslam-v1" else vectors


def frozen(folder: Path, metric: str = "euclidean", route: np.ndarray = ROUTE, n_routes: int = 4) -> PlaceMap:
    made = PlaceMap.create(folder, MapAbout(descriptor="x", metric=metric, n_features=route.shape[1]))
    for part in np.array_split(of_kind(metric, route), n_routes):
        made.add(part, new_route=True)
    made.freeze()
    return made


@pytest.fixture(scope="module")
def shared(tmp_path_factory):
    return frozen(tmp_path_factory.mktemp("places") / "map")


def same(found, expected):
    for ours, theirs in zip(found, expected, strict=True):
        assert_array_equal(ours, theirs)


@pytest.mark.parametrize("metric", [metric for metric in METRICS if metric != "hamming"])
@pytest.mark.parametrize("ds", [4, 10, 20])
def test_matches_are_those_of_exact_search_and_scores_no_higher(tmp_path, metric, ds):
    made, params, queries = (
        frozen(tmp_path / "map", metric),
        SeqSlamParams(sequence_length=ds),
        of_kind(metric, QUERIES),
    )
    exact, indexed = (made.locate(queries, params, search=search) for search in ("exact", "index"))
    inner = slice(ds // 2, 100 - ds // 2)
    is_right = np.abs(exact.reference - PLACE)[inner] <= 1.5
    is_same = (indexed.reference == exact.reference)[inner]
    assert is_right.mean() > (0.9 if ds > 4 else 0.3)
    assert is_same[is_right].mean() > 0.95
    assert_array_equal(indexed.speed[inner][is_same], exact.speed[inner][is_same])
    assert (indexed.score[inner][is_same] <= exact.score[inner][is_same]).all()


def test_scores_are_the_same_bits_where_the_same_lines_are_found(tmp_path):
    route = ROUTE.copy()
    route[1000:1200] = route[3000:3200] + 0.05 * RNG.normal(size=(200, FEATURES)).astype(np.float32)  # a rival
    made = frozen(tmp_path / "map", route=route)
    queries = route[3020:3120] + 0.1 * RNG.normal(size=(100, FEATURES)).astype(np.float32)
    exact, indexed = (made.locate(queries, search=search) for search in ("exact", "index"))
    same(indexed, exact)
    assert np.nanmedian(exact.score) > 0.9


def test_all_places_proposed_give_exact_search(tmp_path):
    made = frozen(tmp_path / "map", route=ROUTE[:48], n_routes=3)  # neighbourhoods cover all of it
    same(made.locate(ROUTE[:40], search="index"), made.locate(ROUTE[:40], search="exact"))


def test_threads_batches_and_streams_give_the_same_bits(shared):
    expected = shared.locate(QUERIES, search="index", workers=1)
    same(shared.locate(QUERIES, search="index", workers=3), expected)
    part = shared.locate(QUERIES[13:40], search="index")
    assert_array_equal(part.score[5:-5], expected.score[18:35])
    import faiss

    before = faiss.omp_get_max_threads()
    try:
        for n in (1, 4):
            faiss.omp_set_num_threads(n)
            same(shared.locate(QUERIES, search="index"), expected)
            assert faiss.omp_get_max_threads() == n
    finally:
        faiss.omp_set_num_threads(before)


@pytest.mark.parametrize("search", ["exact", "index"])
@pytest.mark.parametrize("ds", [1, 10])
@pytest.mark.parametrize("metric", ["euclidean", "openseqslam-v1", "cosine"])
def test_a_stream_gives_the_bits_of_all_frames_together(tmp_path, search, ds, metric):
    made, params = frozen(tmp_path / "map", metric), SeqSlamParams(sequence_length=ds)
    queries, half = of_kind(metric, QUERIES[:40]), params.n_steps // 2
    expected = made.locate(queries, params, search=search)
    stream, found = made.stream(params, search=search), []
    for i, frame in enumerate(queries):
        stream, match = stream.locate_next(frame, time=0.5 * i)
        found.append(match)
    assert [match.query for match in found] == [max(i - half, -1) for i in range(40)]
    inner = slice(half, 40 - half)
    for name in ("reference", "score", "speed"):
        assert_array_equal([getattr(match, name) for match in found[2 * half :]], getattr(expected, name)[inner])
    assert {(match.latency_frames, match.latency) for match in found[2 * half :]} == {(half, half / 2)}
    now = np.array([match.reference_now for match in found[2 * half :]])
    if ds > 1:
        assert np.median(np.abs(now - PLACE[2 * half : 40])) <= 1.5


@pytest.mark.parametrize("search", ["exact", "index"])
def test_missing_frames_are_bridged(tmp_path, search):
    route = ROUTE.copy()
    route[[3040, 3041, 500]] = np.nan
    made, queries = frozen(tmp_path / "map", route=route), QUERIES.copy()
    queries[[20, 21, 50]] = np.nan
    found = made.locate(queries, search=search)
    assert np.mean(np.abs(found.reference - PLACE)[5:-5] <= 1.5) > 0.95
    stream, ours = made.stream(search=search), []
    for frame in queries:
        stream, match = stream.locate_next(None if np.isnan(frame).any() else frame)
        ours.append(match.score)
    assert_array_equal(ours[10:], found.score[5:-5])
    lost = made.locate(np.full((12, FEATURES), np.nan), search=search)
    assert (lost.reference == -1).all()


def test_missing_bytes_are_bridged_on_the_move(tmp_path):
    made = frozen(tmp_path / "map", "openseqslam-v1")
    for search in ("exact", "index"):
        stream = made.stream(search=search)
        for i, frame in enumerate(of_kind("openseqslam-v1", QUERIES[:20])):
            stream, match = stream.locate_next(None if i in (3, 9) else frame)
        assert abs(match.reference - PLACE[match.query]) <= 1.5


@settings(max_examples=30, deadline=None)
@given(ds=st.integers(1, 40), slowest=st.floats(0.0, 2.0), span=st.floats(0.0, 2.0))
def test_every_line_ends_near_one_that_is_voted_for(ds, slowest, span):
    offsets = SeqSlamParams(sequence_length=ds, slowest=slowest, fastest=slowest + span).offsets
    chosen = coarse_speeds(offsets)
    assert np.abs(offsets[:, None] - chosen).max(axis=-1).min(axis=1).max() <= 1


INDEX = """
import sys
import numpy as np
from insectnav.matching import MapAbout
from insectnav.matching.place_arrays import new_places
from insectnav.matching.place_index import build_index

route = np.random.default_rng(3).normal(size=(4000, 24)).astype(np.float32)
about = MapAbout(descriptor="x", metric="euclidean", n_features=24)
_, arrays = build_index(new_places(about, route), "euclidean")
sys.stdout.buffer.write(b"".join(values.tobytes() for _, values in arrays.values()))
"""


def test_an_index_has_the_same_bits_whatever_the_number_of_threads():
    made = [
        subprocess.run(
            [sys.executable, "-c", INDEX],
            capture_output=True,
            check=True,
            env=environment() | dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), n),
        ).stdout
        for n in ("1", "3")
    ]
    assert len(made[0]) > 4000 * 24
    assert made[0] == made[1]


def test_a_small_map_is_indexed_without_a_word(tmp_path, capfd):
    place_map = PlaceMap.build(
        tmp_path / "m", ROUTE[:12].astype(np.float32), MapAbout(descriptor="x", metric="euclidean", n_features=FEATURES)
    )
    place_map.freeze()
    assert capfd.readouterr() == ("", "")


def test_an_index_lists_each_place_once():
    route = ROUTE.copy()
    route[7] = np.nan
    about = MapAbout(descriptor="x", metric="euclidean", n_features=FEATURES)
    sizes, arrays = build_index(new_places(about, route), "euclidean")
    values = {name: array for name, (_, array) in arrays.items()}
    assert_array_equal(np.sort(values["places"]), np.delete(np.arange(N), 7))
    assert values["sizes"].sum() == N - 1
    assert len(values["centres"]) == sizes.n_lists == round((N - 1) ** 0.5)
    # a place lies within half a step of 8 bits of what is listed for it
    low, span = values["scale"]
    listed = low + span * (values["codes"] + 0.5) / 255
    assert np.abs(listed - route[values["places"]]).max() < span.max() / 255 * 1.01 + 1e-3 * span.max()


def test_a_small_map_is_frozen_without_a_word_on_the_terminal(tmp_path, capfd):
    frozen(tmp_path / "map", route=ROUTE[:5], n_routes=1)
    assert capfd.readouterr() == ("", "")


def test_a_start_at_the_end_of_a_route_is_proposed_once():
    """Windows of one place: starts 3 (the last of route 0), 8 and 5 have three, two and one vote."""
    places = np.array([[3, 8, 5], [3, 8, -1], [3, -1, -1]])
    weights, routes = np.ones(places.shape), np.repeat([0, 1], [4, 20])
    proposed = np.full(8, -1)
    n = propose_starts(places, weights, routes, np.zeros((1, 3), np.int64), 1, proposed)
    assert_array_equal(proposed[:n], [3, 9, 6])


def test_a_start_on_another_route_is_proposed_however_near_its_number():
    """The window of a start ends with its route, as in exact search: 3 and 4 are on two routes, 10 and 12 on one."""
    places = np.array([[3, 4, 10, 12], [3, 4, 10, -1], [3, -1, 10, -1], [3, -1, -1, -1]])
    weights, routes = np.ones(places.shape), np.repeat([0, 1], [4, 20])
    proposed = np.full(8, -1)
    n = propose_starts(places, weights, routes, np.zeros((1, 4), np.int64), 6, proposed)
    assert_array_equal(proposed[:n], [3, 11, 5])


def test_a_line_has_the_votes_of_its_start_and_of_the_two_places_after_it():
    """Candidates at starts 10 and 12 are one line of two votes, which is more than a single one of one and a half."""
    places, weights = np.array([[10, 50], [13, -1]]), np.array([[1.0, 1.5], [1.0, 0.0]])
    proposed = np.full(8, -1)
    n = propose_starts(places, weights, np.zeros(60, np.int64), np.array([[0, 1]]), 6, proposed)
    assert_array_equal(proposed[:n], [11, 51])


def test_no_line_is_proposed_that_runs_from_one_route_into_the_next():
    places, routes, proposed = np.array([[-1], [11]]), np.repeat([0, 1], 10), np.full(8, -1)
    assert propose_starts(places, np.ones((2, 1)), routes, np.array([[0, 5]]), 1, proposed) == 0
    assert propose_starts(places, np.ones((2, 1)), routes, np.array([[0, 1]]), 1, proposed) == 1


@pytest.mark.parametrize("magnitude", [1e-25, 1e25])
def test_an_index_by_cosine_does_not_see_the_unit(tmp_path, magnitude):
    queries = np.float32(magnitude) * QUERIES[:12]
    made = frozen(tmp_path / "map", "cosine", np.float32(magnitude) * ROUTE[2980:3120], n_routes=1)
    same(made.locate(queries, search="index"), made.locate(queries, search="exact"))


def test_where_there_is_no_candidate_none_is_near(tmp_path):
    few = frozen(tmp_path / "map", route=ROUTE[:30], n_routes=1)
    index = few._index("index")
    places, distances = index.candidates(QUERIES[:4])
    assert_array_equal((places >= 0).sum(axis=1), 30)
    assert_array_equal(np.isinf(distances), places < 0)


def refused(call) -> str:
    with pytest.raises(InputError) as caught:
        call()
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("name", ["centres", "sizes", "places", "codes", "scale"])
def test_an_index_that_is_damaged_is_told_and_made_anew(tmp_path, name):
    made = frozen(tmp_path / "map", route=ROUTE[:500])
    expected = made.locate(QUERIES, search="index")
    (array,) = (tmp_path / "map").glob(f"index-*/{name}")
    (chunk,) = array.glob("c.0*")
    whole = bytearray(chunk.read_bytes())
    whole[len(whole) // 2] ^= 4  # one bit
    chunk.write_bytes(whole)
    found = PlaceMap.open(tmp_path / "map")
    sentence = refused(lambda: found.locate(QUERIES, search="index"))
    assert sentence.endswith("search='exact' needs none, and freeze() makes it anew")
    chunk.unlink()
    assert "is damaged" in refused(lambda: found.stream(search="index"))
    assert found.locate(QUERIES, search="exact").reference.max() > 0
    found.freeze()
    same(PlaceMap.open(tmp_path / "map").locate(QUERIES, search="index"), expected)
    assert len(list((tmp_path / "map").glob("index-*"))) == 1


@pytest.mark.parametrize(
    "change",
    [{"n_lists": 2}, {"n_lists": 2**40}, {"n_probes": 0}, {"n_candidates": 10**9}, {"sha256": "x"}, {"folder": "../x"}],
)
def test_an_index_of_other_sizes_is_refused(tmp_path, change):
    frozen(tmp_path / "map", route=ROUTE[:500])
    file = tmp_path / "map" / "map.json"
    record = json.loads(file.read_text())
    record["index"] |= change
    file.write_text(json.dumps(record))
    assert "damaged" in refused(lambda: PlaceMap.open(tmp_path / "map").locate(QUERIES, search="index"))


def test_what_an_index_cannot_do_is_told(shared, tmp_path, monkeypatch):
    sentence = refused(lambda: shared.locate(QUERIES, OPENSEQSLAM_V1, search="index"))
    assert sentence.startswith("baseline is 'observed', expected 'bound'")
    bits = PlaceMap.build(tmp_path / "bits", ROUTE > 8, MapAbout(descriptor="x", metric="hamming", n_features=FEATURES))
    bits.freeze()
    assert "there is none for bits" in refused(lambda: bits.locate(QUERIES > 8, search="index"))
    assert bits.locate(ROUTE[3000:3040] > 8).reference[20] == 3020
    assert "one frame at a time" in refused(lambda: shared.stream().locate_next(QUERIES))
    monkeypatch.setitem(sys.modules, "faiss", None)
    assert refused(lambda: PlaceMap.open(shared.path).locate(QUERIES, search="index")).startswith(
        "an index needs FAISS, which is not installed"
    )


def test_auto_takes_the_index_of_large_maps_alone(shared, monkeypatch):
    same(shared.locate(QUERIES), shared.locate(QUERIES, search="exact"))
    monkeypatch.setattr("insectnav.matching.places.EXACT_UP_TO", N - 1)
    same(shared.locate(QUERIES), shared.locate(QUERIES, search="index"))
