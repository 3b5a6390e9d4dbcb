"""Maps on disk: whole or going on, one process at a time, and what stays after an interruption."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from insectnav.checks import InputError
from insectnav.experiments.place_maps import build as building
from insectnav.experiments.place_maps.build import ADDING, UNFINISHED, BuildParams, build
from insectnav.experiments.place_maps.locate import LocateParams, TruthParams, locate
from insectnav.experiments.place_maps.opening import FrameParams
from insectnav.experiments.place_maps.thumbnails import find_thumbnails
from insectnav.experiments.store import locked
from insectnav.matching.places import PlaceMap
from place_scenes import spoil, views, write_pictures


@pytest.fixture
def summer(tmp_path: Path) -> Path:
    return write_pictures(tmp_path / "summer", views(30))


def test_an_interruption_keeps_whole_batches_and_add_goes_on(summer: Path, tmp_path: Path, monkeypatch):
    monkeypatch.setattr(building, "BATCH", 8)

    def stop(_: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        build([str(summer)], tmp_path / "m", BuildParams(), stop)
    assert PlaceMap.open(tmp_path / "m").n_places == 8
    assert (tmp_path / "m" / UNFINISHED).exists()
    result = build([str(summer)], tmp_path / "m", BuildParams(adds=True))
    assert (result["frames"], result["frames_from_earlier_run"], result["routes"]) == (22, 8, 1)
    build([str(summer)], tmp_path / "whole", BuildParams())
    one, other = (PlaceMap.open(tmp_path / name) for name in ("m", "whole"))
    assert_array_equal(one.descriptors, other.descriptors)
    assert one.names == other.names
    assert not (tmp_path / "m" / UNFINISHED).exists()


def test_no_batch_is_on_disk_without_its_small_pictures(summer: Path, tmp_path: Path, monkeypatch):
    monkeypatch.setattr(building, "BATCH", 8)
    keep = building.keep_thumbnails

    def keep_and_stop(folder: Path, first: int, pictures: Sequence[bytes]) -> None:
        if first == 8:
            raise KeyboardInterrupt
        keep(folder, first, pictures)

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(building, "keep_thumbnails", keep_and_stop)
        build([str(summer)], tmp_path / "m", BuildParams())
    build([str(summer)], tmp_path / "m", BuildParams(adds=True))
    assert sorted(find_thumbnails(tmp_path / "m", range(100))) == list(range(30))


def test_an_interruption_after_the_last_frame_is_finished_by_add(summer: Path, tmp_path: Path):
    def stop(_: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        build([str(summer)], tmp_path / "m", BuildParams(), stop)
    result = build([str(summer)], tmp_path / "m", BuildParams(adds=True))
    assert (result["frames"], result["places"], result["routes"]) == (0, 30, 1)


def test_a_frame_of_another_size_of_features_leaves_no_map(tmp_path: Path):
    write_pictures(tmp_path / "mixed", np.zeros((3, 25, 120), np.uint8) + np.arange(120, dtype=np.uint8))
    write_pictures(tmp_path / "mixed", np.zeros((1, 60, 120), np.uint8), "other{}.png")
    from insectnav.experiments.place_maps.choices import GivenOptions

    params = BuildParams(frames=FrameParams(given=GivenOptions(camera="panorama", descriptor="turned-views")))
    result = build([str(tmp_path / "mixed")], tmp_path / "m", params)
    assert result["missing"] == 0  # views are brought to one size
    assert result["features"] == 25 * 120


def test_two_processes_do_not_add_at_once(summer: Path, tmp_path: Path):
    build([str(summer)], tmp_path / "m", BuildParams())
    with locked(tmp_path / "m" / ADDING), pytest.raises(InputError, match="is being written by another run"):
        build([str(summer)], tmp_path / "m", BuildParams(adds=True))
    assert PlaceMap.open(tmp_path / "m").n_places == 30


def test_a_route_whose_last_batch_is_missing_keeps_the_frames_before(summer: Path, tmp_path: Path, monkeypatch):
    monkeypatch.setattr(building, "BATCH", 8)
    for k in range(24, 30):  # the fourth batch
        spoil(summer / f"frame{k}.png")
    result = build([str(summer)], tmp_path / "m", BuildParams())
    assert (result["places"], result["missing"]) == (30, 6)
    descriptors = PlaceMap.open(tmp_path / "m").descriptors
    assert_array_equal(np.flatnonzero(np.isnan(descriptors).all(axis=1)), np.arange(24, 30))


@pytest.mark.parametrize("freezes", [False, True])
def test_what_cannot_be_added_leaves_the_map_as_it_was(freezes: bool, tmp_path: Path):
    rng = np.random.default_rng(0)
    for name, n_features in (("a", 5), ("longer", 6), ("b", 5)):
        np.save(tmp_path / f"{name}.npy", rng.normal(size=(30, n_features)))
    path = tmp_path / "m"
    build([str(tmp_path / "a.npy")], path, BuildParams(freezes=freezes))
    with pytest.raises(InputError, match="frozen" if freezes else "n_features"):
        build([str(tmp_path / "longer.npy")], path, BuildParams(adds=True))
    assert not (path / UNFINISHED).exists()
    if not freezes:
        assert build([str(tmp_path / "b.npy")], path, BuildParams(adds=True))["places"] == 60


def test_a_build_that_was_stopped_while_it_froze_is_frozen_by_add(summer: Path, tmp_path: Path, monkeypatch):
    def stop(_: PlaceMap) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(PlaceMap, "freeze", stop)
        build([str(summer)], tmp_path / "m", BuildParams(freezes=True))
    result = build([str(summer)], tmp_path / "m", BuildParams(adds=True, freezes=True))
    assert (result["frames"], result["places"], result["routes"], result["is_frozen"]) == (0, 30, 1, True)
    assert not (tmp_path / "m" / UNFINISHED).exists()


def test_missing_frames_are_nan_and_found_by_their_neighbours(summer: Path, tmp_path: Path):
    for k in (0, 1, 14):
        spoil(summer / f"frame{k}.png")
    build([str(summer)], tmp_path / "m", BuildParams())
    place_map = PlaceMap.open(tmp_path / "m")
    assert_array_equal(np.flatnonzero(np.isnan(place_map.descriptors).all(axis=1)), [0, 1, 14])
    winter = write_pictures(tmp_path / "winter", views(30, season=1))
    found = locate(place_map, [str(winter)], LocateParams(truth=TruthParams(same_index=True, tolerance_frames=0)))
    assert found.found.reference[14] == 14
    assert found.found.truth is not None
    assert found.found.truth.is_right[5:-5].all()


def test_threads_change_nothing(summer: Path, tmp_path: Path):
    for workers in (1, 3):
        build([str(summer)], tmp_path / str(workers), BuildParams(frames=FrameParams(workers=workers)))
    one, other = (PlaceMap.open(tmp_path / name) for name in ("1", "3"))
    assert_array_equal(one.descriptors, other.descriptors)
