"""A map searched by a Dask cluster, each worker some pieces of it; the answers are those of one machine, to the bit."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav import __version__
from insectnav.checks import InputError, quoted
from insectnav.matching.place_arrays import read_places
from insectnav.matching.place_exact_search import (
    Landscape,
    known_frames,
    landscape_of,
    lines_of_pieces,
    matches_of_lines,
)
from insectnav.matching.place_pieces import Lines, Piece, PieceLines, join_pieces, joined_blocks, map_pieces
from insectnav.matching.place_record import MapRecord, read_record
from insectnav.matching.place_store import shown
from insectnav.matching.seqslam import Matches, SeqSlamParams
from insectnav.workers import cluster_client

MOST_TASKS = 1024  # at a time
SEQUENCES_AT_ONCE = 2**14  # whose lines are kept until they are joined


def cluster_matches(
    path: Path, record: MapRecord, landscape: Landscape, queries: NDArray[Any], params: SeqSlamParams, cluster: Any
) -> Matches:
    """Matches of queries as of `exact_matches`, by a cluster whose workers see the folder of the map.

    Parameters
    ----------
    path : of the map, which is frozen
    record : MapRecord
    landscape : of the map
    queries : (query, feature) array
    params : SeqSlamParams
    cluster : address of a Dask scheduler, or a client

    Raises
    ------
    InputError
        If there is no such cluster, its workers see another map or none, or it is lost.
    """
    if record.places is None:
        raise InputError(f"the map {shown(path)} can still be added to, expected a frozen one for a cluster: freeze()")
    pieces = map_pieces(landscape.places.routes, params)
    n_sequences = len(queries) - params.n_steps
    blocks = []
    with _client(cluster) as client:
        for first in range(0, n_sequences, SEQUENCES_AT_ONCE):
            part = queries[first : min(first + SEQUENCES_AT_ONCE, n_sequences) + params.n_steps]
            blocks.append(_lines(client, path.resolve(), record.places, pieces, part, params))
    return matches_of_lines(joined_blocks(blocks), known_frames(landscape, queries), params)


@contextmanager
def _client(cluster: Any) -> Iterator[Any]:
    if isinstance(cluster, str):
        with cluster_client(cluster) as client:
            yield client
    elif hasattr(cluster, "submit") and hasattr(cluster, "gather"):
        yield cluster
    else:
        raise InputError(f"cluster is {quoted(cluster)}, expected the address of a Dask scheduler or a client")


def _lines(
    client: Any, path: Path, name: str, pieces: Sequence[Piece], queries: NDArray[Any], params: SeqSlamParams
) -> Lines:
    """The best line of the map for each sequence of queries, some pieces for each task."""
    size = -(-len(pieces) // MOST_TASKS)
    shards = [pieces[k : k + size] for k in range(0, len(pieces), size)]
    try:
        shared = client.scatter([queries], hash=False)[0]
        tasks = [
            client.submit(shard_lines, str(path), name, __version__, s, shared, params, pure=False) for s in shards
        ]
        found = client.gather(tasks)
    except InputError:
        raise
    except Exception as error:  # whatever a cluster may die of
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        raise InputError(f"the cluster gave up the search of {shown(path)} ({reason[:200]}): is it alive?") from None
    return join_pieces([lines for shard in found for lines in shard], params)


def shard_lines(
    folder: str, name: str, version: str, pieces: Sequence[Piece], queries: NDArray[Any], params: SeqSlamParams
) -> list[PieceLines]:
    """What some pieces of a map know of the sequences of queries; a worker of a cluster calls this.

    Parameters
    ----------
    folder : of the map
    name : of the folder in it with its places, by which the worker knows that it is the same map
    version : of insectnav that asks
    pieces : of the map
    queries : (query, feature) array
    params : SeqSlamParams

    Raises
    ------
    InputError
        If this is another version, or sees another map in the folder, or none.
    """
    if version != __version__:
        raise InputError(f"a worker has insectnav {__version__}, expected {version} as where the search was started")
    return lines_of_pieces(_landscape(folder, name), pieces, np.asarray(queries), params, workers=1)


@lru_cache(maxsize=4)
def _landscape(folder: str, name: str) -> Landscape:
    record = read_record(Path(folder))
    if record.places != name:
        raise InputError(f"a worker sees another map in {shown(Path(folder))}: does it share the disk?")
    return landscape_of(read_places(Path(folder) / name, record.about), record.about.metric)
