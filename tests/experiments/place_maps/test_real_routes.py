"""Recorded routes through the commands' functions: the numbers on the page of the documentation."""

from pathlib import Path

import numpy as np
import pytest

from insectnav.experiments.place_maps.build import BuildParams, build
from insectnav.experiments.place_maps.choices import GivenOptions
from insectnav.experiments.place_maps.frames import Thinning
from insectnav.experiments.place_maps.locate import LocateParams, TruthParams, locate
from insectnav.experiments.place_maps.located import numbers
from insectnav.experiments.place_maps.opening import FrameParams
from insectnav.experiments.place_maps.whereabouts import Whereabouts
from insectnav.matching.places import PlaceMap
from insectnav.matching.seqslam import SeqSlamParams
from real_routes import DATA

pytestmark = pytest.mark.data


def recorded(name: str) -> Path:
    if not (DATA / name).exists():
        pytest.skip(f"{DATA / name} is missing")
    return DATA / name


def test_a_railway_in_summer_and_winter(tmp_path: Path):
    folder = recorded("nordland")
    frames = FrameParams(thinning=Thinning(step=10), pictures=False)
    build([str(folder / "summer")], tmp_path / "m", BuildParams(frames=frames))
    truth = TruthParams(same_index=True, tolerance_frames=2)
    found = numbers(
        locate(PlaceMap.open(tmp_path / "m"), [str(folder / "winter")], LocateParams(frames=frames, truth=truth)).found
    )
    assert (found["places"], found["queries"], found["can_be_matched"]) == (120, 120, 110)
    assert (found["precision_of_all"], found["recall_at_full_precision"]) == (1.0, 1.0)


def test_a_robot_outdoors_whatever_it_faces(tmp_path: Path):
    folder = recorded("sussex_route")

    def frames(times: str, track: str) -> FrameParams:
        return FrameParams(
            given=GivenOptions(camera="panorama", descriptor="turned-views"),
            where=Whereabouts(
                times=str(folder / times),
                positions=str(folder / track),
                columns=("time_ms", "x_cm", "y_cm"),
                max_gap_s=30.0,
            ),
            pictures=False,
        )

    build(
        [str(folder / "snapshot_*.png")],
        tmp_path / "m",
        BuildParams(frames=frames("training.csv", "training_path_scaled.csv")),
    )
    search = locate(
        PlaceMap.open(tmp_path / "m"),
        [str(folder / "test_*.png")],
        LocateParams(
            frames=frames("testing_infomax.csv", "testing_path_infomax_scaled.csv"),
            seqslam=SeqSlamParams(sequence_length=1),
            truth=TruthParams(tolerance_m=0.5),
        ),
    )
    found = numbers(search.found)
    assert (found["queries"], found["judged"], found["right"]) == (102, 94, 94)
    assert found["error_median"] == pytest.approx(0.185, abs=0.002)
    assert found["error_largest"] == pytest.approx(0.495, abs=0.002)
    assert search.found.angles_deg is not None
    assert np.isfinite(search.found.angles_deg[:, 0]).all()
    assert np.median(np.abs(search.found.angles_deg[:, 0])) < 15.0


@pytest.mark.parametrize("descriptor", ["spherical-harmonics", "rotations"])
def test_skies_of_a_walk_through_a_fisheye(descriptor: str, tmp_path: Path):
    folder = recorded("fisheye_sky")
    masks = sorted(folder.glob("*_mask.png"))
    frames = FrameParams(given=GivenOptions(camera="fisheye:180", descriptor=descriptor, sky="mask"), pictures=False)
    build([str(path) for path in masks[::2]], tmp_path / "m", BuildParams(frames=frames))
    search = locate(
        PlaceMap.open(tmp_path / "m"),
        [str(path) for path in masks[1::2]],
        LocateParams(
            frames=frames,
            seqslam=SeqSlamParams(sequence_length=6),
            truth=TruthParams(same_index=True, tolerance_frames=1),
        ),
    )
    found = numbers(search.found)
    assert (found["can_be_matched"], found["right"]) == (26, 26)
