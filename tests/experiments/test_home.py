"""Home from a track: units, nest, notes and numbers against what they stand for; the figure; the same bytes again."""

import csv
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.agents import run_trials
from insectnav.agents.motion import MotionParams
from insectnav.checks import InputError
from insectnav.experiments.home import (
    SHOWN,
    HomeParams,
    Homing,
    Trip,
    figure_data,
    homing_steps,
    random_trip,
    recorded_trip,
    report,
    run,
    simulate,
    summarise,
)
from insectnav.experiments.home_figure import draw
from insectnav.records import Track

N_SAMPLES = 60
FEW = HomeParams(n_trials=5, n_inbound=150, seed=4)
FILES = ["data.zarr", "figure.pdf", "figure.png", "provenance.json", "summary.json", "table.csv"]


def walk(scale: float = 1.0, length_unit: str = "m", nest: tuple = (0.0, 0.0), n: int = N_SAMPLES, **options) -> Track:
    """A bend to the right, 0.2 m a sample."""
    heading = np.linspace(0.5, 1.8, n)
    moves = 0.2 * np.stack([np.sin(heading), np.cos(heading)], axis=-1)
    position = scale * (np.array(nest) + np.cumsum(moves, axis=0) - moves[0])
    options = {"time_unit": "s", "name": "walk"} | options
    return Track(time=0.1 * np.arange(n), position=position, length_unit=length_unit, **options)


def straight_trip(n_steps: int, speed: float = 0.85, **changes) -> Trip:
    """Along +y at constant speed."""
    velocity = np.tile([0.0, speed], (n_steps, 1))
    return random_trip(0)._replace(heading=np.zeros(n_steps), velocity=velocity, **changes)


def numbers(homing: Homing) -> dict[str, Mapping[str, Any]]:
    return {row["quantity"]: row for row in summarise(homing)}


@pytest.fixture(scope="module")
def homing() -> Homing:
    return simulate(recorded_trip(walk(nest=(30.0, -7.0))), FEW)


# Units.


def test_lengths_come_back_in_the_unit_of_the_track(homing: Homing):
    metres = numbers(homing)
    centimetres = numbers(simulate(recorded_trip(walk(100.0, "cm", nest=(30.0, -7.0))), FEW))
    assert list(metres) == list(centimetres)
    lengths = {"closest_distance", "decoded_length", "distance_of_turning_point"}
    for name, row in metres.items():
        assert (row["unit"] == "m") == (name in lengths)
        factor = 100.0 if name in lengths else 1.0
        for column in ("mean", "median", "sd", "p90"):
            expected = factor * row[column]
            got = centimetres[name][column]
            assert got == pytest.approx(expected, rel=2e-3, abs=2e-3 * factor, nan_ok=True), (name, column)
        assert centimetres[name]["n"] == row["n"]
    assert centimetres["closest_distance"]["unit"] == "cm"


def test_place_of_the_nest_changes_nothing_but_the_map(homing: Homing):
    at_origin = simulate(recorded_trip(walk()), FEW)
    for name, row in numbers(homing).items():
        assert row["mean"] == pytest.approx(numbers(at_origin)[name]["mean"], rel=2e-3, abs=1e-3, nan_ok=True)
    here, there = figure_data(at_origin), figure_data(homing)
    assert_allclose(there["nest"] - here["nest"], [30.0, -7.0])
    assert_allclose(there["outbound"] - here["outbound"], np.broadcast_to([30.0, -7.0], (N_SAMPLES, 2)), atol=1e-4)
    assert_array_equal(there["outbound"][0], there["nest"])


def test_table_counts_what_it_says(homing: Homing):
    track, rows = walk(), numbers(homing)
    straight = np.linalg.norm(track.position[-1] - track.position[0])
    assert rows["distance_of_turning_point"]["mean"] == pytest.approx(straight)
    position = homing.arrays.position[:, N_SAMPLES - 1 :].astype(float) / homing.trip.steps_per_unit
    closest = np.linalg.norm(position, axis=-1).min(axis=1)
    assert rows["closest_distance"]["mean"] == pytest.approx(closest.mean(), rel=1e-3)
    assert rows["closest_distance"]["p90"] == pytest.approx(np.percentile(closest, 90), rel=1e-3)
    within = np.mean(closest <= 20.0 / homing.trip.steps_per_unit)
    assert rows["came_within_search_radius"]["mean"] == pytest.approx(within)
    vector = homing.home_vector / homing.trip.steps_per_unit
    assert rows["decoded_length"]["mean"] == pytest.approx(np.linalg.norm(vector, axis=1).mean(), rel=1e-4)
    away = (track.position[0] - track.position[-1]) @ [1.0, 1.0j]
    error = np.angle((vector @ [1.0, 1.0j]) / away, deg=True)
    assert rows["decoded_bearing_error"]["mean"] == pytest.approx(-error.mean(), abs=0.01)  # positive clockwise
    assert rows["decoded_bearing_error_absolute"]["mean"] == pytest.approx(np.abs(error).mean(), abs=0.01)
    ratio = np.linalg.norm(vector, axis=1).mean() / straight
    assert rows["decoded_over_true_length"]["mean"] == pytest.approx(ratio, rel=1e-3)
    share = rows["straightness"]["mean"]
    assert rows["tortuosity"]["mean"] == pytest.approx(1.0 / share, rel=1e-6)


def test_home_is_found_and_straight():
    rows = numbers(simulate(recorded_trip(walk(n=300)), HomeParams(n_trials=40, seed=1)))
    assert rows["distance_of_turning_point"]["mean"] > 50.0
    assert rows["closest_distance"]["median"] < 1.0
    assert rows["came_within_search_radius"]["mean"] == 1.0
    assert rows["decoded_bearing_error_absolute"]["mean"] < 10.0
    assert 0.9 < rows["decoded_over_true_length"]["mean"] < 1.3


# What belongs together.


def test_recorded_activity_is_that_of_trial_0(homing: Homing):
    arrays, trip = homing.arrays, homing.trip
    assert tuple(homing.activity) == SHOWN
    assert_array_equal(homing.activity["memory"][N_SAMPLES - 1], arrays.memory_at_turn[0])
    assert not np.array_equal(arrays.memory_at_turn[0], arrays.memory_at_turn[1])
    pair = (np.tile(trip.heading, (5, 1)), np.tile(trip.velocity, (5, 1, 1)))
    again = run_trials(pair, n_inbound=150, seed=4, record=SHOWN)
    assert_array_equal(again.heading, arrays.heading)
    for name in SHOWN:
        assert_array_equal(again[name][0], homing.activity[name])


def test_compass_cells_fit_the_headings_of_trial_0():
    # Without noise TL i is σ(6.8 cos(θ − i · 45°) − 3), θ being the heading before the turn of this step.
    homing = simulate(recorded_trip(walk()), HomeParams(n_trials=2, n_inbound=40, noise=0.0))
    theta = np.insert(homing.arrays.heading[0].astype(float), N_SAMPLES, homing.arrays.heading[0, N_SAMPLES - 1])[:-1]
    preferred = np.tile(np.arange(8) * np.pi / 4.0, 2)
    expected = 1.0 / (1.0 + np.exp(3.0 - 6.8 * np.cos(theta[:, None] - preferred)))
    assert_allclose(homing.activity["tl"], expected, atol=1e-4)


def test_outbound_path_is_the_track(homing: Homing):
    track = walk(nest=(30.0, -7.0))
    for trial in range(5):
        path = homing.trip.nest + homing.arrays.position[trial, :N_SAMPLES] / homing.trip.steps_per_unit
        assert_allclose(path, track.position, atol=1e-4)


def test_trials_differ_and_the_seed_decides():
    trip = recorded_trip(walk())
    one, two, other = (simulate(trip, HomeParams(n_trials=3, n_inbound=20, seed=s)) for s in (1, 1, 2))
    assert_array_equal(one.arrays.position, two.arrays.position)
    assert not np.array_equal(one.arrays.position, other.arrays.position)
    assert len(np.unique(one.arrays.position[:, -1], axis=0)) == 3


def test_progress_counts_every_trial():
    finished: list[int] = []
    simulate(recorded_trip(walk()), HomeParams(n_trials=130, n_inbound=2), finished.append)
    assert sum(finished) == 130


# Time for the way home.


@pytest.mark.parametrize(
    ("n_steps", "speed", "expected"),
    [
        (300, 0.85, math.ceil(2 * 300 * 0.85 / (0.1 * 0.85 / 0.15))),  # far: twice the straight way at 0.567
        (300, 0.1, 300),  # near: as long as out
        (1, 0.0, 1),
    ],
)
def test_steps_for_the_way_home(n_steps: int, speed: float, expected: int):
    assert homing_steps(straight_trip(n_steps, speed), MotionParams()) == pytest.approx(expected, abs=1)


def test_asked_for_steps_are_taken():
    homing = simulate(straight_trip(20), HomeParams(n_trials=2, n_inbound=7))
    assert homing.arrays.heading.shape == (2, 27)
    assert report(homing, summarise(homing), HomeParams())["scale"]["homing_steps"] == 7


# The report.


def test_report_says_what_was_done(homing: Homing):
    told = report(homing, summarise(homing), FEW)
    track = walk()
    assert told["name"] == "walk"
    assert told["heading"] == "direction of motion"
    assert told["settings"] == {
        "preset": "thesis", "variant": "partially-holonomic", "trials": 5, "noise": 0.1, "seed": 4,
    }  # fmt: skip
    assert told["track"]["samples"] == N_SAMPLES
    assert told["track"]["duration"] == pytest.approx(0.1 * (N_SAMPLES - 1))
    assert told["track"]["length"] == pytest.approx(0.2 * (N_SAMPLES - 1))
    scale = told["scale"]
    assert (scale["length_unit"], scale["time_unit"]) == ("m", "s")
    assert (scale["outbound_steps"], scale["homing_steps"]) == (N_SAMPLES, 150)
    moves = np.linalg.norm(np.diff(track.position, axis=0), axis=1)
    assert scale["steps_per_length_unit"] == pytest.approx(0.85 / np.percentile(moves, 95))
    assert scale["search_radius"] == pytest.approx(20.0 / scale["steps_per_length_unit"])
    assert any("direction of motion" in note for note in told["notes"])
    assert not any("saturated" in note for note in told["notes"])
    assert "quantity" not in told["results"]["closest_distance"]


def test_saturation_is_told_where_a_large_scale_was_asked_for():
    track = walk(n=400)
    usual = recorded_trip(track).steps_per_unit
    for factor, is_told in ((1.0, False), (20.0, True)):
        homing = simulate(recorded_trip(track, factor * usual), HomeParams(n_trials=2, n_inbound=1))
        memory = homing.arrays.memory_at_turn
        share = np.mean((memory == 0.0) | (memory == 1.0))
        notes = [note for note in report(homing, summarise(homing), FEW)["notes"] if "saturated" in note]
        assert bool(notes) == (share > 0.0) == is_told
        if is_told:
            assert notes[0].startswith(f"{100 * share:.0f} % of the memory cells")
            assert "--steps-per-unit" in notes[0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"preset": "thesiss"}, r"preset 'thesiss' is unknown: expected one of thesis, code-2017 \(did you mean thesi"),
        ({"variant": "ideal"}, "variant 'ideal' is unknown: expected one of partially-holonomic, non-holonomic, fully"),
        ({"noise": -0.1}, "noise is -0.1"),
        ({"noise": math.nan}, "noise is nan"),
        ({"n_trials": 0}, "trials is 0"),
        ({"n_inbound": 0}, "homing steps is 0"),
        ({"seed": -1}, "seed is -1"),
    ],
)
def test_settings_that_cannot_be_are_refused(change: dict, message: str):
    with pytest.raises(InputError, match=f"^{message}"):
        HomeParams(**change)


# Files.


@pytest.fixture(scope="module")
def two_runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, dict[str, Any]]:
    folder = tmp_path_factory.mktemp("home")
    told = [run(recorded_trip(walk(nest=(3.0, 4.0))), FEW, folder / name) for name in ("one", "two")]
    return folder / "one", folder / "two", told[0]


def test_same_seed_leaves_the_same_bytes(two_runs: tuple):
    one, two, _ = two_runs
    assert sorted(path.name for path in one.iterdir()) == FILES
    assert sorted(path.name for path in one.parent.iterdir()) == ["one", "two"]
    for name in ("table.csv", "summary.json", "figure.png", "figure.pdf"):
        assert (one / name).read_bytes() == (two / name).read_bytes(), name
        assert (one / name).stat().st_size > 100


def test_figures_are_a_png_and_a_pdf(two_runs: tuple):
    assert (two_runs[0] / "figure.png").read_bytes().startswith(b"\x89PNG\r\n")
    assert (two_runs[0] / "figure.pdf").read_bytes().startswith(b"%PDF-")


def test_table_and_summary_agree(two_runs: tuple):
    one, _, told = two_runs
    summary = json.loads((one / "summary.json").read_text(encoding="utf-8"))
    with (one / "table.csv").open(newline="", encoding="utf-8") as file:
        table = {row.pop("quantity"): row for row in csv.DictReader(file)}
    assert list(table) == list(summary["results"]) == list(told["results"])
    for name, row in summary["results"].items():
        assert table[name]["unit"] == row["unit"]
        for column in ("mean", "median", "sd", "p90"):
            assert (table[name][column] == "") == (row[column] is None)
            if row[column] is not None:
                assert float(table[name][column]) == pytest.approx(row[column], rel=1e-5)
    assert summary["scale"] == told["scale"]
    assert json.loads((one / "provenance.json").read_text())["seconds"] > 0.0


def test_data_are_the_arrays_in_the_unit_of_the_track(two_runs: tuple):
    homing = simulate(recorded_trip(walk(nest=(3.0, 4.0))), FEW)
    per_unit = homing.trip.steps_per_unit
    with xarray.open_zarr(two_runs[0] / "data.zarr", consolidated=False) as data:
        assert data.position.dims == ("trial", "step", "xy")
        assert data.position.attrs["units"] == data.closest_distance.attrs["units"] == "m"
        assert_allclose(data.position, np.add([3.0, 4.0], homing.arrays.position / per_unit), atol=1e-5)
        assert_allclose(data.position[:, :N_SAMPLES], np.tile(walk(nest=(3.0, 4.0)).position, (5, 1, 1)), atol=1e-4)
        assert_array_equal(data.heading, homing.arrays.heading)
        assert_array_equal(data.memory_at_turn, homing.arrays.memory_at_turn)
        assert_allclose(data.closest_distance, homing.arrays.closest_distance / per_unit, rtol=1e-6)
        assert_allclose(data.home_vector_at_turn, homing.home_vector / per_unit, rtol=1e-6)
        assert_array_equal(data.leg, np.repeat([0, 1], [N_SAMPLES, 150]))
        assert_array_equal(data.trial, np.arange(5))
        for name in SHOWN:
            assert_array_equal(data[f"{name}_of_trial_0"], homing.activity[name])
        assert data.attrs["seed"] == 4
        assert data.attrs["circuit_variant"] == "partially-holonomic"
        assert data.attrs["scale"]["steps_per_length_unit"] == pytest.approx(per_unit)


def test_what_fails_leaves_nothing(tmp_path: Path):
    with pytest.raises(InputError, match=r"trials times steps are 1.2e\+08, expected"):
        run(recorded_trip(walk()), HomeParams(n_trials=120, n_inbound=1_000_000), tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_drawing_that_fails_is_told_and_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("insectnav.experiments.home.figure_data", lambda homing: {"name": "nothing else"})
    with pytest.raises(RuntimeError, match="the figure could not be drawn"):
        run(recorded_trip(walk()), FEW, tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_trip_without_a_track():
    trip = random_trip(3)
    assert trip.heading.shape == (1500,)
    assert np.linalg.norm(trip.velocity, axis=-1).max() < 1.5
    assert_array_equal(trip.velocity, random_trip(3).velocity)
    assert not np.array_equal(trip.velocity, random_trip(4).velocity)
    assert (trip.length_unit, trip.steps_per_unit, dict(trip.track)) == ("step", 1.0, {})


# The figure.


def drawn(change: Mapping[str, Any] = {}, homing: Homing | None = None, n_trials: int = 5) -> Any:
    """The figure as the drawing process makes it, which gets all data as arrays."""
    homing = homing or simulate(recorded_trip(walk(nest=(30.0, -7.0))), HomeParams(n_trials=n_trials, n_inbound=30))
    return draw({name: np.asarray(value)[()] for name, value in (figure_data(homing) | change).items()})


def test_figure_shows_what_it_says(homing: Homing):
    data, figure = figure_data(homing), drawn(homing=homing)
    paths, panel, bar = figure.axes
    assert (paths.get_xlabel(), paths.get_ylabel(), paths.get_title(loc="left")) == ("x (m)", "y (m)", "walk")
    assert paths.get_aspect() == 1.0
    legend = " | ".join(text.get_text() for text in paths.get_legend().get_texts())
    for words in ("n = 5", "outbound", "way home of trial 1", "home vector", "nest", "turning point"):
        assert words in legend
    assert f"search radius ({20.0 / homing.trip.steps_per_unit:.3g} m)" in legend
    (circle,) = paths.patches
    assert (tuple(circle.center), circle.radius) == ((30.0, -7.0), 20.0 / homing.trip.steps_per_unit)
    (ways_home,) = paths.collections
    assert len(ways_home.get_segments()) == 4  # the first has a line of its own
    (arrow,) = (text for text in paths.texts if hasattr(text, "arrow_patch"))
    turn = walk(nest=(30.0, -7.0)).position[-1]
    assert_allclose(arrow.xyann, turn, atol=1e-4)
    assert_allclose(arrow.xy, turn + data["home_vector"].mean(axis=0), atol=1e-4)
    lines = [np.array(line.get_xydata(), float) for line in paths.lines]
    assert any(len(line) == 1 and np.allclose(line[0], turn, atol=1e-4) for line in lines)
    assert any(len(line) == 1 and np.allclose(line[0], [30.0, -7.0]) for line in lines)
    assert any(len(line) == N_SAMPLES and np.allclose(line, data["outbound"]) for line in lines)
    (image,), (mark,) = panel.images, panel.lines
    assert_allclose(mark.get_xdata(), 0.1 * N_SAMPLES)
    assert_allclose(image.get_extent()[:2], [0.0, 0.1 * (N_SAMPLES + 150)])
    labels = {text.get_text(): text.get_position()[1] for text in panel.texts}
    picture = np.ma.filled(image.get_array(), np.nan)
    assert tuple(image.get_extent()[2:]) == (len(picture), 0.0)
    for name, label in zip(SHOWN, ["TL", "CL1", "TB1", "TN2", "Memory", "CPU4", "Pontine", "CPU1"], strict=True):
        rates = homing.activity[name].T / homing.activity[name].max()
        height = 8 if name == "tn2" else 16
        top = round(labels[label] - height / 2)
        assert_allclose(picture[top : top + height], np.repeat(rates, height // len(rates), axis=0), atol=1e-6)
    assert np.isnan(picture).all(axis=1).sum() == 7 * 4  # gaps between eight populations
    assert panel.get_xlabel() == "time (s)"
    assert "rate" in bar.get_ylabel()


@pytest.mark.parametrize(
    "trip",
    [
        recorded_trip(walk(length_unit="unit", time_unit="frame")),
        recorded_trip(walk(name="2019-07-14_nest3_ant12_route04_smoothed_and_calibrated_by_hand")),
        straight_trip(300),
        straight_trip(1, 0.0),
    ],
)
def test_nothing_in_the_figure_overlaps_or_is_cut_off(trip: Trip):
    figure = drawn(homing=simulate(trip, HomeParams(n_trials=1, n_inbound=1200)))
    paths, panel, plural = figure.axes[0], figure.axes[1], {"unit": "units", "step": "steps", "frame": "frames"}
    assert paths.get_xlabel() == f"x ({plural.get(trip.length_unit, trip.length_unit)})"
    assert figure.axes[-2].get_xlabel() == f"time ({plural.get(trip.time_unit, trip.time_unit)})"
    whole, left, right = (thing.get_tightbbox() for thing in (figure, paths, panel))
    width, height = figure.get_size_inches()
    assert 0.0 <= whole.x0 < whole.x1 <= width
    assert 0.0 <= whole.y0 < whole.y1 <= height
    assert left.x1 < right.x0


def test_more_ways_home_than_are_drawn_are_not_claimed():
    figure = drawn(n_trials=120)
    n_drawn = len(figure.axes[0].collections[0].get_segments())
    label = figure.axes[0].get_legend().get_texts()[0].get_text()
    assert str(n_drawn + 1) in label
