"""What a map on disk survives: being killed, two writers, a full disk; and queries change nothing."""

import fcntl
import hashlib
import shutil
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from command_line import PATIENCE, until
from dask_cluster import environment, kill, wait_for
from insectnav.checks import InputError
from insectnav.matching import MapAbout, PlaceMap

RNG = np.random.default_rng(1)
ROUTE = np.cumsum(RNG.normal(size=(400, 12)), axis=0)
ABOUT = MapAbout(descriptor="walk", metric="euclidean", n_features=12)
WRITER = """
import sys
import numpy as np
from insectnav.matching import PlaceMap

route = np.cumsum(np.random.default_rng(1).normal(size=(400, 12)), axis=0)
made = PlaceMap.open(sys.argv[1])
for i in range(300):
    made.add(route[i : i + 1], names=[f"frame {i}"])
    print(i + 1, flush=True)
"""


def digests(folder: Path) -> dict[str, str]:
    """Of all files, and the names of all folders."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""
        for path in sorted(folder.rglob("*"))
    }


@pytest.mark.parametrize("patience", [1, 20, 45])
def test_a_writer_that_is_killed_loses_nothing_that_was_acknowledged(tmp_path, patience):
    PlaceMap.create(tmp_path / "map", ABOUT)
    command = [sys.executable, "-c", WRITER, str(tmp_path / "map")]
    log = tmp_path / "log"
    with log.open("wb") as out:
        process = subprocess.Popen(command, stdout=out, env=environment())
        wait_for(lambda: log.read_bytes().count(b"\n") >= patience, process)
        kill(process)
    acknowledged = log.read_bytes().count(b"\n")
    found = PlaceMap.open(tmp_path / "map")
    assert acknowledged <= found.n_places <= acknowledged + 1  # one may have been on disk but not yet told
    assert_array_equal(found.descriptors, ROUTE[: found.n_places])
    assert found.names == tuple(f"frame {i}" for i in range(found.n_places))
    found.add(ROUTE[found.n_places :])
    assert_array_equal(PlaceMap.open(tmp_path / "map").descriptors, ROUTE)
    assert not list((tmp_path / "map").rglob("*.partial"))


KILLER = """
import os, shutil, sys
from pathlib import Path
import numpy as np
from insectnav.matching import PlaceMap

calls, last = 0, 0
route = np.load(sys.argv[2])

def counted(call):
    def counting(*given, **options):
        global calls
        calls += 1
        if calls == last:
            os._exit(9)
        return call(*given, **options)
    return counting

for name in ("rename", "replace", "fsync", "mkdir"):
    setattr(os, name, counted(getattr(os, name)))

def work(copy):
    global calls
    shutil.copytree(sys.argv[1], copy)
    made, calls = PlaceMap.open(copy), 0
    WORK

work(Path(sys.argv[1]).with_name("whole"))
total = calls
for last in range(1, total + 1, max(1, total // 12)):
    if (child := os.fork()) == 0:
        work(Path(sys.argv[1]).with_name(f"killed-{last}"))
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9
print(total)
"""


def every_kill(folder: Path, work: str) -> int:
    """Do the work on copies of a map, each ended without warning at another call to the system; how many there are.

    A process of its own does it, of one thread: what is forked from others may wait for locks that nobody holds.
    """
    np.save(folder.with_name("route.npy"), ROUTE)
    line = [sys.executable, "-c", KILLER.replace("WORK", work), str(folder), str(folder.with_name("route.npy"))]
    done = subprocess.run(line, env=environment(), capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return int(done.stdout)


@pytest.mark.parametrize("n_before", [3, 15])  # after 15 additions, one more makes 16 merge
def test_a_kill_at_any_step_of_adding_leaves_a_map_that_opens(tmp_path, n_before):
    made = PlaceMap.create(tmp_path / "map", ABOUT)
    for i in range(n_before):
        made.add(ROUTE[i : i + 1])
    assert every_kill(made.path, f"made.add(route[{n_before} : {n_before + 1}])") > 5
    for copy in tmp_path.glob("killed-*"):
        found = PlaceMap.open(copy)
        assert found.n_places in (n_before, n_before + 1)
        assert_array_equal(found.descriptors, ROUTE[: found.n_places])
        found.add(ROUTE[found.n_places : 40])
        assert_array_equal(PlaceMap.open(copy).descriptors, ROUTE[:40])
        assert not list(copy.rglob(".*"))


def test_a_kill_at_any_step_of_freezing_leaves_a_map_that_opens(tmp_path):
    made = PlaceMap.build(tmp_path / "map", ROUTE, ABOUT)
    made.add(ROUTE, new_route=True)
    expected = made.locate(ROUTE[20:40])
    assert every_kill(made.path, "made.freeze(index=False)") > 5
    for copy in tmp_path.glob("killed-*"):
        found = PlaceMap.open(copy)
        for ours, theirs in zip(found.locate(ROUTE[20:40]), expected, strict=True):
            assert_array_equal(ours, theirs)
        if not found.is_frozen:
            found.freeze(index=False)
        assert PlaceMap.open(copy).n_places == 800


def test_a_segment_that_is_not_whole_is_no_segment(tmp_path):
    made = PlaceMap.build(tmp_path / "map", ROUTE[:50], ABOUT)
    half = tmp_path / "map" / "segments" / ".00000001-00000001.12345678.partial"
    shutil.copytree(tmp_path / "map" / "segments" / "00000000-00000000", half)
    (half / "descriptors" / "c.0.0").unlink()
    assert PlaceMap.open(tmp_path / "map").n_places == 50
    made.add(ROUTE[50:60])
    assert PlaceMap.open(tmp_path / "map").n_places == 60
    assert not half.exists()


def test_two_writers_do_not_write_at_once(tmp_path):
    made = PlaceMap.build(tmp_path / "map", ROUTE, ABOUT)
    with (tmp_path / "map" / "lock").open("a") as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        for write in (lambda: made.add(ROUTE), made.freeze):
            with pytest.raises(InputError, match=r"is being written by another: wait for it to end$"):
                write()
        assert PlaceMap.open(tmp_path / "map").locate(ROUTE[:20]).reference[7] == 7  # readers do not wait
    made.add(ROUTE)
    assert PlaceMap.open(tmp_path / "map").n_places == 800


def test_writers_that_take_turns_see_each_other(tmp_path):
    first = PlaceMap.create(tmp_path / "map", ABOUT)
    second = PlaceMap.open(tmp_path / "map")
    for k in range(20):
        (first, second)[k % 2].add(ROUTE[k : k + 1], new_route=k == 10)
    assert_array_equal(PlaceMap.open(tmp_path / "map").descriptors, ROUTE[:20])
    assert_array_equal(second.routes, np.arange(20) >= 10)


def test_sixteen_additions_of_one_size_become_one_segment(tmp_path):
    made = PlaceMap.create(tmp_path / "map", ABOUT)
    counts = []
    for k in range(33):
        made.add(ROUTE[k : k + 1])
        counts.append(len(list((tmp_path / "map" / "segments").iterdir())))
    assert counts == [k // 16 + k % 16 for k in range(1, 34)]


def test_a_reader_opens_while_segments_merge(tmp_path):
    made = PlaceMap.create(tmp_path / "map", ABOUT)
    made.add(ROUTE[:1])
    done, sizes = threading.Event(), [0]

    def read():
        while not done.is_set():
            found = PlaceMap.open(tmp_path / "map")
            sizes.append(found.n_places)
            assert_array_equal(found.descriptors, ROUTE[: found.n_places])

    thread = threading.Thread(target=read)
    thread.start()
    try:
        for i in range(1, 70):
            made.add(ROUTE[i : i + 1])
        until(lambda: sizes[-1] == 70 or not thread.is_alive())
    finally:
        done.set()
        thread.join()
    assert sizes == sorted(sizes)
    assert sizes[-1] == 70


def test_a_reader_opens_while_the_map_is_frozen(tmp_path, monkeypatch):
    from insectnav.matching import places

    made, read = PlaceMap.build(tmp_path / "map", ROUTE, ABOUT), places.read_segments

    def frozen_in_the_meantime(*given):
        monkeypatch.setattr(places, "read_segments", read)
        made.freeze(index=False)
        return read(*given)

    monkeypatch.setattr(places, "read_segments", frozen_in_the_meantime)
    found = PlaceMap.open(tmp_path / "map")
    assert (found.n_places, found.is_frozen) == (400, True)


@pytest.mark.parametrize("index", [False, True])
def test_queries_change_nothing_on_disk(tmp_path, index):
    made = PlaceMap.build(tmp_path / "map", ROUTE, ABOUT)
    made.freeze(index=index)
    before = digests(tmp_path / "map")
    for folder in [tmp_path / "map", *(path for path in (tmp_path / "map").rglob("*") if path.is_dir())]:
        folder.chmod(0o555)
    found = PlaceMap.open(tmp_path / "map")
    search = "index" if index else "exact"
    found.locate(ROUTE[100:140], search=search)
    stream = found.stream(search=search)
    for frame in ROUTE[100:112]:
        stream, _ = stream.locate_next(frame)
    assert digests(tmp_path / "map") == before


def test_a_full_disk_is_told_and_costs_nothing(tmp_path, monkeypatch):
    made = PlaceMap.build(tmp_path / "map", ROUTE, ABOUT)

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("insectnav.matching.place_store.synchronise", full)
    for write in (lambda: made.add(ROUTE), made.freeze, lambda: PlaceMap.build(tmp_path / "new", ROUTE, ABOUT)):
        with pytest.raises(InputError, match=r"cannot be written \(No space left on device\)$"):
            write()
    monkeypatch.undo()
    assert PlaceMap.open(tmp_path / "map").n_places == 400
    assert not (tmp_path / "new").exists()
    assert not list(tmp_path.rglob("*.partial"))
