"""Maps of hardly any places, where exact ties abound: every way of searching breaks them as `seqslam` does."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from insectnav.matching import MapAbout, PlaceMap, SeqSlamParams, difference_matrix, seqslam
from insectnav.matching.place_arrays import new_places
from insectnav.matching.place_exact_search import exact_matches, landscape_of
from insectnav.matching.place_index import METRICS_WITH_INDEX, PlaceIndex, build_index
from insectnav.matching.place_index_search import indexed_matches
from insectnav.matching.place_stream import MapStream, begin_map_stream

pytest.importorskip("faiss")
FEW = st.integers(0, 2)  # of which descriptors are made, so that many are alike, turned over or a multiple


@st.composite
def _scenes(draw):
    """Descriptors of places and queries, the length of the first route, and how they are searched."""
    n_features, n_places = draw(st.integers(1, 3)), draw(st.integers(1, 4))
    sequence_length = draw(st.sampled_from([1, 2, 4]))
    n_queries = draw(st.integers(sequence_length + 1, 8))

    def frames(n):
        rows = st.lists(FEW, min_size=n_features, max_size=n_features)
        made = draw(st.lists(st.one_of(rows, rows, rows, st.none()), min_size=n, max_size=n))
        values = np.array([[np.nan] * n_features if row is None else row for row in made])
        return values * draw(st.sampled_from([1.0, 0.1, 1 / 3]))

    slowest = draw(st.sampled_from([0.0, 0.5, 0.8, 1.0]))
    params = SeqSlamParams(
        sequence_length=sequence_length,
        slowest=slowest,
        fastest=slowest + draw(st.sampled_from([0.0, 0.4, 1.0])),
        contrast_window=draw(st.sampled_from([2, 3, 10])),
        unique_window=draw(st.sampled_from([0, 1, 2, 10])),
    )
    return frames(n_places), frames(n_queries), draw(st.integers(1, n_places)), params


def _streamed(stream: MapStream, queries: np.ndarray) -> np.ndarray:
    """Reference, score and speed of the queries that have a whole sequence about them, one after the other."""
    rows, n_steps = [], stream.params.n_steps
    for frame in queries:
        stream, match = stream.locate_next(None if np.isnan(frame).any() else frame)
        rows.append((match.reference, match.score, match.speed))
    return np.array(rows[n_steps:]).T


def _same(found, expected) -> None:
    for ours, theirs in zip(found, expected, strict=True):
        assert_array_equal(ours, theirs)


@settings(max_examples=150, deadline=None)
@given(scene=_scenes(), metric=st.sampled_from(METRICS_WITH_INDEX))
def test_ties_among_few_places_are_broken_alike_by_every_search(scene, metric: str):
    vectors, queries, n_first, params = scene
    about = MapAbout(descriptor="x", metric=metric, n_features=vectors.shape[1])
    places = replace(new_places(about, vectors), routes=(np.arange(len(vectors)) >= n_first).astype(np.int64))
    landscape, half = landscape_of(places, metric), params.n_steps // 2
    inner = slice(half, len(queries) - half)
    exact = exact_matches(landscape, queries, params, 1)
    if n_first == len(vectors) and len(vectors) > params.n_steps:
        _same(exact, seqslam(difference_matrix(vectors, queries, metric), params))
    _same(exact_matches(landscape, queries, params, 2), exact)
    _same(_streamed(begin_map_stream(landscape, params, None), queries), [one[inner] for one in exact])
    if np.isnan(vectors).any():  # an index does not propose what is missing, which may be another's rival
        return
    sizes, arrays = build_index(places, metric)
    index = PlaceIndex({name: values for name, (_, values) in arrays.items()}, metric, sizes)
    _same(indexed_matches(landscape, index, queries, params, 1), exact)
    _same(_streamed(begin_map_stream(landscape, params, index), queries), [one[inner] for one in exact])


@pytest.mark.parametrize("search", ["exact", "index"])
def test_the_first_of_places_that_are_the_same_is_taken(tmp_path: Path, search: str):
    places = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 1.0], [1.0, 0.0]])
    made = PlaceMap.build(tmp_path / "map", places, MapAbout(descriptor="x", metric="euclidean", n_features=2))
    made.freeze()
    params = SeqSlamParams(sequence_length=1, unique_window=0)
    assert made.locate(places, params, search=search).reference.tolist() == [0, 1, 1, 0]
