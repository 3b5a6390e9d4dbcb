"""A map searched by a Dask cluster gives the bits of one machine."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from insectnav import __version__
from insectnav.checks import InputError
from insectnav.matching import MapAbout, PlaceMap, SeqSlamParams
from insectnav.matching.place_cluster_search import shard_lines
from insectnav.matching.place_pieces import map_pieces

RNG = np.random.default_rng(4)
ROUTE = np.cumsum(RNG.normal(size=(300, 8)), axis=0)
ABOUT = MapAbout(descriptor="walk", metric="euclidean", n_features=8)


@pytest.fixture
def made(tmp_path):
    made = PlaceMap.build(tmp_path / "map", ROUTE, ABOUT)
    made.add(ROUTE[100:200], new_route=True)
    made.freeze(index=False)
    return made


@pytest.fixture(scope="module")
def client():
    from distributed import Client, LocalCluster

    options = {"n_workers": 2, "threads_per_worker": 1, "processes": False, "host": "127.0.0.1"}
    with (
        LocalCluster(**options, dashboard_address="127.0.0.1:0", protocol="tcp://") as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        yield client


@pytest.mark.parametrize("window", [10, 60])  # the second straddles whole pieces
def test_a_cluster_gives_the_bits_of_one_machine(made, client, monkeypatch, window):
    params = SeqSlamParams(unique_window=window)
    queries = ROUTE[90:150] + 0.5 * RNG.normal(size=(60, 8))
    queries[[8, 40]] = np.nan
    expected = made.locate(queries, params)
    monkeypatch.setattr("insectnav.matching.place_cluster_search.MOST_TASKS", 5)
    monkeypatch.setattr("insectnav.matching.place_cluster_search.SEQUENCES_AT_ONCE", 17)
    monkeypatch.setattr(
        "insectnav.matching.place_cluster_search.map_pieces", lambda routes, params: map_pieces(routes, params, 23)
    )
    for cluster in (client, client.scheduler.address):
        found = made.locate(queries, params, cluster=cluster)
        for ours, theirs in zip(found, expected, strict=True):
            assert_array_equal(ours, theirs)
    assert (expected.reference >= 0).any()


def refused(call) -> str:
    with pytest.raises(InputError) as caught:
        call()
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_what_a_cluster_cannot_do_is_told(made, client, tmp_path, monkeypatch):
    still_open = PlaceMap.build(tmp_path / "open", ROUTE, ABOUT)
    told = refused(lambda: still_open.locate(ROUTE[:20], cluster=client))
    assert told.endswith("expected a frozen one for a cluster: freeze()")
    assert "give it alone" in refused(lambda: made.locate(ROUTE[:20], cluster=client, workers=2))
    assert "give it alone" in refused(lambda: made.locate(ROUTE[:20], cluster=client, search="index"))
    assert refused(lambda: made.locate(ROUTE[:20], cluster=3)).startswith("cluster is '3', expected the address")
    monkeypatch.setattr("insectnav.workers.CONNECT_SECONDS", 0.5)
    told = refused(lambda: made.locate(ROUTE[:20], cluster="tcp://127.0.0.1:1"))
    assert told.startswith("no Dask scheduler answers at 'tcp://127.0.0.1:1'")


def test_a_worker_that_sees_another_map_or_version_says_so(made):
    pieces, params = map_pieces(made.routes, SeqSlamParams()), SeqSlamParams()
    given = (pieces, ROUTE[:20], params)
    told = refused(lambda: shard_lines(str(made.path), "places-00000000", __version__, *given))
    assert told.endswith("does it share the disk?")
    told = refused(lambda: shard_lines(str(made.path), "places-00000000", "0.0", *given))
    assert told == f"a worker has insectnav {__version__}, expected 0.0 as where the search was started"
    told = refused(lambda: shard_lines("/nowhere", "places-00000000", __version__, *given))
    assert told.startswith("'/nowhere' does not exist, expected the folder of a map")
