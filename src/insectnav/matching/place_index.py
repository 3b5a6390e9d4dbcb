"""An index of places: for each frame the few that are nearest, without comparing with all. By FAISS.

What is stored are plain arrays, from which the index is put together again: no file of FAISS's own is ever read.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, check_count
from insectnav.matching.difference import checked_vectors, unit_vectors
from insectnav.matching.place_arrays import PlaceArrays
from insectnav.matching.place_store import Arrays, DamagedError, arrays_digest, read_arrays
from insectnav.workers import run_blocks

Reals = NDArray[np.floating[Any]]
Integers = NDArray[np.int64]
METRICS_WITH_INDEX = ("cosine", "euclidean", "absolute", "openseqslam-v1")
DIMENSIONS = {
    "centres": ("list", "feature"),
    "sizes": ("list",),
    "places": ("entry",),
    "codes": ("entry", "feature"),
    "scale": ("end", "feature"),
}
TYPES = ("float32", "int64", "int64", "uint8", "float32")
PLACES_PER_CENTRE = 64  # that centres are trained with; FAISS asks for 39 at least and takes no more than 256
FEWEST_PER_LIST = 39
SEED = 1234
PLACES_AT_ONCE = 2**16
QUERIES_PER_BLOCK = 16


@dataclass(frozen=True, kw_only=True)
class IndexSizes:
    """How large an index is and how much of it is searched; kept with the map.

    Parameters
    ----------
    n_lists : neighbourhoods of descriptors in which places are listed
    n_probes : lists that are searched for each frame
    n_candidates : places that each frame proposes
    """

    n_lists: int
    n_probes: int
    n_candidates: int

    def __post_init__(self) -> None:
        check_count("n_lists", self.n_lists)
        check_count("n_probes", self.n_probes)
        check_count("n_candidates", self.n_candidates)
        if self.n_lists > 2**20 or self.n_probes > self.n_lists or self.n_candidates > 1024:
            raise InputError(
                f"an index of {self.n_lists} lists with {self.n_probes} probes and {self.n_candidates} candidates "
                "cannot be searched, expected at most 2^20 lists, as many probes, and 1024 candidates"
            )


def sizes_for(n_places: int) -> IndexSizes:
    """As many lists as there are places in a list, so that time grows with the root of the map.

    Notes
    -----
    64 probes and 64 candidates are assumed; benchmarks/places.py measures what they find.
    """
    n_lists = max(1, min(round(n_places**0.5), n_places // FEWEST_PER_LIST, 2**16))
    return IndexSizes(n_lists=n_lists, n_probes=min(64, n_lists), n_candidates=64)


@contextmanager
def _one_thread() -> Iterator[Any]:
    """FAISS on one thread, on which its results do not depend on how many there are."""
    try:
        import faiss
    except ImportError:
        raise InputError("an index needs FAISS, which is not installed: pip install faiss-cpu") from None
    before = faiss.omp_get_max_threads()
    faiss.omp_set_num_threads(1)
    try:
        yield faiss
    finally:
        faiss.omp_set_num_threads(before)


def index_vectors(descriptors: NDArray[Any], metric: str) -> tuple[Reals, NDArray[np.bool_]]:
    """Descriptors such that near ones have a small Euclidean distance, and which of them are missing."""
    vectors, is_missing = checked_vectors("descriptors", descriptors)
    values = unit_vectors(vectors, np.dtype(np.float32)) if metric == "cosine" else vectors.astype(np.float32)
    return np.ascontiguousarray(values), is_missing


def build_index(places: PlaceArrays, metric: str) -> tuple[IndexSizes, Arrays]:
    """Arrays of an index of all places that have a descriptor, by name.

    Raises
    ------
    InputError
        If FAISS is not installed, or all places are missing.

    Notes
    -----
    Lists about centres, of features in 8 bits each: Johnson, Douze & Jégou 2019, Billion-scale similarity search with
    GPUs, IEEE Transactions on Big Data 7, doi 10.1109/TBDATA.2019.2921572. Places are nearest by Euclidean distance,
    between unit vectors for "cosine"; for sums of absolute differences that is near enough to propose some.
    """
    is_missing = np.concatenate([missing for _, _, missing in _blocks(places, metric)])
    known = np.flatnonzero(~is_missing)
    if not len(known):
        raise InputError("all places of the map are missing frames, expected some with a descriptor")
    sizes = sizes_for(len(known))
    few = known[:: max(1, len(known) // (PLACES_PER_CENTRE * sizes.n_lists))]
    with _one_thread() as faiss:
        quantiser, index = _empty_index(faiss, sizes.n_lists, places.n_features)
        index.cp.seed, index.cp.min_points_per_centroid = SEED, 1  # FAISS would warn of small maps on the terminal
        index.train(index_vectors(places.descriptors(few), metric)[0])
        for first, vectors, missing in _blocks(places, metric):
            index.add_with_ids(vectors[~missing], first + np.flatnonzero(~missing))
        centres = quantiser.reconstruct_n(0, sizes.n_lists)
        scale = faiss.vector_to_array(index.sq.trained).reshape(2, -1)
        lists = [_list(faiss, index.invlists, k, places.n_features) for k in range(sizes.n_lists)]
    values = (
        centres,
        np.array([len(entries) for entries, _ in lists], np.int64),
        np.concatenate([entries for entries, _ in lists]),
        np.concatenate([codes for _, codes in lists]),
        scale,
    )
    return sizes, {name: (DIMENSIONS[name], array) for name, array in zip(DIMENSIONS, values, strict=True)}


def _blocks(places: PlaceArrays, metric: str) -> Iterator[tuple[int, Reals, NDArray[np.bool_]]]:
    for first in range(0, len(places.times), PLACES_AT_ONCE):
        yield first, *index_vectors(places.descriptors(slice(first, first + PLACES_AT_ONCE)), metric)


def _empty_index(faiss: Any, n_lists: int, n_features: int) -> tuple[Any, Any]:
    quantiser = faiss.IndexFlatL2(n_features)
    eight_bits, by_residual = faiss.ScalarQuantizer.QT_8bit, False
    return quantiser, faiss.IndexIVFScalarQuantizer(
        quantiser, n_features, n_lists, eight_bits, faiss.METRIC_L2, by_residual
    )


def _list(faiss: Any, lists: Any, number: int, n_features: int) -> tuple[Integers, NDArray[np.uint8]]:
    """Places in a list and their codes."""
    n = lists.list_size(number)
    if not n:
        return np.empty(0, np.int64), np.empty((0, n_features), np.uint8)
    places = faiss.rev_swig_ptr(lists.get_ids(number), n).copy()
    codes = faiss.rev_swig_ptr(lists.get_codes(number), n * n_features).copy()
    return places, codes.reshape(n, n_features)


class PlaceIndex:
    """An index in memory, put together from its arrays.

    Parameters
    ----------
    arrays : of `read_index`
    metric : of the map
    sizes : IndexSizes
    """

    def __init__(self, arrays: Mapping[str, NDArray[Any]], metric: str, sizes: IndexSizes) -> None:
        self.metric, self.sizes = metric, sizes
        centres, n_entries = np.ascontiguousarray(arrays["centres"]), len(arrays["places"])
        places, codes = np.ascontiguousarray(arrays["places"]), arrays["codes"]
        with _one_thread() as faiss:
            self._quantiser, self._index = _empty_index(faiss, *centres.shape)
            self._quantiser.add(centres)
            faiss.copy_array_to_vector(np.ascontiguousarray(arrays["scale"]).ravel(), self._index.sq.trained)
            self._index.is_trained = True
            first = 0
            for number, n in enumerate(arrays["sizes"].tolist()):
                entries, rows = places[first : first + n], np.ascontiguousarray(codes[first : first + n])
                if n:
                    self._index.invlists.add_entries(number, n, faiss.swig_ptr(entries), faiss.swig_ptr(rows))
                first += n
            self._index.ntotal = n_entries
            self._options = faiss.SearchParametersIVF(nprobe=sizes.n_probes)

    def candidates(self, descriptors: NDArray[Any], workers: int | None = None) -> tuple[Integers, Reals]:
        """The nearest places of each frame and their squared distances, (frame, candidate); −1 where there is none.

        Notes
        -----
        Frames are searched for one by one: FAISS takes another way for many at a time, with other rounding.
        """
        vectors, is_missing = index_vectors(descriptors, self.metric)
        shape = (len(vectors), self.sizes.n_candidates)
        places, distances = np.full(shape, -1, np.int64), np.full(shape, np.inf, np.float32)

        def run(first: int, last: int) -> None:
            with _one_thread():
                for k in first + np.flatnonzero(~is_missing[first:last]):
                    found = self._index.search(vectors[k : k + 1], shape[1], params=self._options)
                    distances[k], places[k] = found[0][0], found[1][0]

        run_blocks(run, len(vectors), QUERIES_PER_BLOCK, workers)
        distances[places < 0] = np.inf  # FAISS has the largest number there
        return places, distances


def read_index(folder: Path, digest: str, sizes: IndexSizes, n_places: int, n_features: int) -> dict[str, NDArray[Any]]:
    """Arrays of an index.

    Raises
    ------
    DamagedError
        If they are not as they were written.
    """
    arrays = read_arrays(folder, DIMENSIONS)
    places, sums = arrays["places"], arrays["sizes"]
    is_right = (
        tuple(arrays[name].dtype.name for name in DIMENSIONS) == TYPES
        and arrays["centres"].shape == (sizes.n_lists, n_features)
        and len(arrays["scale"]) == 2
        and 0 < len(places) <= n_places
        and bool((sums >= 0).all())
        and int(sums.sum()) == len(places)
        and bool(((places >= 0) & (places < n_places)).all())
        and bool(np.isfinite(arrays["centres"]).all() and np.isfinite(arrays["scale"]).all())
    )
    if not is_right or arrays_digest(folder, DIMENSIONS) != digest:
        raise DamagedError("its arrays are not as they were written")
    return arrays
