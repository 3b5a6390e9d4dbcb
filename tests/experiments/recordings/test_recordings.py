"""Recordings of others: read as they lie in the folder, named when missing, and what is known of them found."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.experiments.experiment import Results
from insectnav.experiments.published import AGREES, DIFFERS, NOT_COMPARABLE
from insectnav.experiments.recordings import constellations, files, nordland, sussex, tilted_skies
from insectnav.sweep import published_numbers
from real_routes import DATA
from real_skies import GRID, random_rotation, tilted_view

EXPERIMENTS = {
    "recordings-nordland": nordland,
    "recordings-sussex": sussex,
    "recordings-tilted-skies": tilted_skies,
    "recordings-constellations": constellations,
}


@pytest.fixture
def data(monkeypatch):
    if not DATA.is_dir():
        pytest.skip(f"{DATA} is missing")
    monkeypatch.setenv(files.FOLDER, str(DATA))
    files.sky_masks.cache_clear()
    tilted_skies._map.cache_clear()


def results_of(experiment, cells):
    arrays = [experiment.simulate(cell, 0) for cell in cells]
    return Results(cells, {name: np.stack([a[name][1] for a in arrays]) for name in arrays[0]})


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_without_the_data_table_figure_and_verdicts_say_so(name, monkeypatch):
    monkeypatch.delenv(files.FOLDER, raising=False)
    files.sky_masks.cache_clear()
    experiment = EXPERIMENTS[name]
    results = results_of(experiment, experiment.grid("quick"))
    files.sky_masks.cache_clear()
    table = experiment.summarise(results)
    assert {row["kind"] for row in table} == {files.MISSING}
    assert files.FOLDER in experiment.caption(results)
    assert experiment.draw(results).axes
    verdicts = experiment.compare(table, published_numbers(experiment, name))
    assert {verdict.verdict for verdict in verdicts} == {NOT_COMPARABLE}


def test_frames_of_another_size_are_refused(tmp_path, monkeypatch):
    monkeypatch.setenv(files.FOLDER, str(tmp_path))
    (tmp_path / "nordland" / "summer").mkdir(parents=True)
    cv2.imwrite(str(tmp_path / "nordland" / "summer" / "00000.png"), np.zeros((8, 9), np.uint8))
    with pytest.raises(InputError, match=r"'00000\.png' has 8 × 9 pixels of uint8, expected 32 × 64 bytes"):
        files.nordland("summer")


# A sky tilted, beside the plain way of the tests of rotation matching.


def disc(radius_deg=60.0):
    apart = np.hypot(*np.meshgrid(np.arange(320) - 159.5, np.arange(320) - 159.5)) / 160 * 90
    return apart < radius_deg


@pytest.mark.parametrize("tilt_deg", [0.0, 25.0, 60.0])
def test_a_tilted_view_is_that_of_the_plain_way(tilt_deg):
    rotation = random_rotation(np.random.default_rng(1), np.deg2rad(tilt_deg))
    found, (expected, seen) = tilted_skies.look(disc(), rotation), tilted_view(disc(), rotation)
    assert_array_equal(found.seen, seen)
    assert_allclose(found.cropped, np.where(seen, expected, 0.0), atol=1e-12)


def test_uncropped_a_disc_of_sky_keeps_its_size_and_cropped_it_does_not():
    rotation = random_rotation(np.random.default_rng(1), np.deg2rad(60.0))
    level, tilted = tilted_skies.look(disc(), np.eye(3)), tilted_skies.look(disc(), rotation)
    area = 2 * np.pi * (1 - np.cos(np.deg2rad(60.0)))
    for view in (level.whole, tilted.whole, level.cropped):
        assert view @ GRID.weights == pytest.approx(area, rel=0.01)
    assert tilted.cropped @ GRID.weights < 0.9 * area


def test_rotations_tilt_by_the_angle():
    cell = tilted_skies.Cell(tilt_deg=40.0, n_queries=50, n_skies=65)
    rotations = tilted_skies._rotations(cell, 0)
    assert_allclose(np.rad2deg(np.arccos(rotations[:, 2, 2])), 40.0, atol=1e-6)
    assert_allclose(rotations @ rotations.swapaxes(1, 2), np.broadcast_to(np.eye(3), (50, 3, 3)), atol=1e-12)


# What is known of the recordings.


@pytest.mark.data
def test_the_robot_is_put_within_half_a_metre(data):
    table = sussex.summarise(results_of(sussex, sussex.grid("quick")))
    row = next(row for row in table if row["way"] == sussex.COMPASS)
    assert row["tracked_views"] == 94
    assert row["median_cm"] < 19  # known of these recordings: median 18 cm, all within 50
    assert row["most_cm"] < 50


@pytest.mark.data
def test_the_railway_is_found_as_the_documentation_says(data):
    cells = [
        nordland.Cell(way=way, every=10, sequence_length=10, n_frames=1200) for way in (nordland.V1, nordland.DEFAULT)
    ]
    v1, default = nordland.summarise(results_of(nordland, cells))
    measures = ("precision_of_all", "recall_without_error", "area")
    assert_allclose([v1[name] for name in measures], (0.791, 0.736, 0.788), atol=5e-4)
    assert [default[name] for name in measures] == [1, 1, 1]


@pytest.mark.data
@pytest.mark.slow
def test_single_frames_by_words_fail_across_seasons(data):
    cells = [cell for cell in nordland.grid("quick") if cell.sequence_length == 1]
    winter, summer = nordland.summarise(results_of(nordland, cells))
    assert winter["precision_of_all"] < 0.2 < summer["precision_of_all"] + 0.05


@pytest.mark.data
def test_at_the_speeds_that_it_searches_seqslam_finds_more_than_constellations(data):
    cells = [cell for cell in constellations.grid("quick") if cell.season == "winter"]
    found = {
        (row["way"], row["speed"]): row["found"] for row in constellations.summarise(results_of(constellations, cells))
    }
    first, _, lenient, strict = constellations.WAYS
    assert all(found[lenient, speed] > found[first, speed] + 0.2 for speed in (0.5, 1.0, 1.5, 2.0))
    assert found[strict, 1.0] > 0.9 > 0.2 > found[strict, 2.0]


@pytest.mark.data
@pytest.mark.slow
def test_tilted_skies_are_found_over_all_rotations(data):
    (cell,) = (cell for cell in tilted_skies.grid("quick") if cell.tilt_deg == 60.0)
    table = tilted_skies.summarise(results_of(tilted_skies, [cell]))
    found = {row["way"]: row["found"] for row in table}
    assert found[tilted_skies.ROTATION] == found[tilted_skies.WHOLE] == 1
    assert found[tilted_skies.HARMONICS] < 0.5
    assert table[0]["rotation_error_deg"] < 0.5


# Verdicts on given tables.


def verdicts_of(name, table):
    experiment = EXPERIMENTS[name]
    return {v.quantity: v for v in experiment.compare(table, published_numbers(experiment, name))}


@pytest.mark.parametrize(("at_twice", "expected"), [(0.1, AGREES), (0.5, DIFFERS)])
def test_words_on_speed_say_that_it_distorts_constellations(at_twice, expected):
    first = next(iter(constellations.WAYS))
    table = [
        {"way": first, "season": "summer", "speed": speed, "queries": 300, "found": found}
        for speed, found in ((1.0, 0.5), (2.0, at_twice))
    ]
    (verdict,) = verdicts_of("recordings-constellations", table).values()
    assert verdict.verdict == expected


def test_the_error_of_a_difference_of_shares_is_that_of_both():
    table = [
        {"tilt_deg": tilt, "way": way, "n": 100, "found": 1.0, "neighbour_found": 0.5}
        for tilt in (0.0, 60.0)
        for way in tilted_skies.WAYS
    ]
    given = verdicts_of("recordings-tilted-skies", table)
    assert given["found by harmonics at 60°, sphere seen whole"].uncertainty == pytest.approx(0.05)
    assert given["neighbours found at 0°, Zernike less contour"].uncertainty == pytest.approx(0.05 * np.sqrt(2.0))


def test_captions_say_which_frames_are_left_out(monkeypatch):
    cells = constellations.grid("quick")
    caption = constellations.caption(Results([replace(cell, n_frames=1200) for cell in cells], {}))
    assert "without the first 17, while the train stands" in caption
    assert "counts as not found" in caption
    cells = nordland.grid("quick")
    caption = nordland.caption(Results([replace(cell, n_frames=1200) for cell in cells], {}))
    assert "every second of the first 400 frames" in caption
