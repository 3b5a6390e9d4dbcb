"""What the experiments of Stone et al. 2014 say of given results: tables, statistics, verdicts, missing data."""

import csv
from pathlib import Path

import cv2
import numpy as np
import pytest

from insectnav.experiments import load
from insectnav.experiments.experiment import Results
from insectnav.experiments.published import AGREES, DIFFERS, NOT_COMPARABLE
from insectnav.experiments.stone2014_sky_segmentation import fig_2, real_photographs, sensitivity, table_1
from insectnav.experiments.stone2014_sky_segmentation.scenes import SCENES
from insectnav.experiments.stone2014_sky_segmentation.table_1_panels import label_picture
from insectnav.experiments.stone2014_sky_segmentation.variations import VARIATIONS
from insectnav.sweep import published_numbers

PUBLISHED = Path(table_1.__file__).parent / "published.csv"
COLUMNS = table_1.NAMES[:7]


def printed_accuracies() -> np.ndarray:
    """The twelve scenes of Table I, (scene, way)."""
    with PUBLISHED.open(newline="", encoding="utf-8") as file:
        values = {row["quantity"]: float(row["value"]) for row in csv.DictReader(file) if row["value"]}
    return np.array([[values[f"{s.name}: {way}"] for way in COLUMNS] for s in SCENES if s.is_named])


def results_of(right: np.ndarray) -> Results:
    """Results of the first scenes with these accuracies, (scene, way); ways beside the table get those of k-means."""
    beside = np.repeat(right[:, :1], len(table_1.NAMES) - right.shape[1], axis=1)
    cells = [table_1.Cell(scene=scene.name, reduction=1, supersampling=1) for scene in SCENES[: len(right)]]
    arrays = {"accuracy": np.concatenate([right, beside], axis=1), "sky_share": np.full(len(right), 0.4)}
    return Results(cells, arrays)


def test_the_twelve_printed_scenes_nearly_have_the_printed_means_of_all_eighteen():
    # The table's own check: six scenes are missing, so that means lie within what six of eighteen can move.
    means = printed_accuracies().mean(axis=0)
    numbers = published_numbers(load("stone2014-table-1"), "stone2014-table-1")
    for way, mean in zip(COLUMNS, means, strict=True):
        of_all = numbers[f"mean: {way}"].value
        missing = (18.0 * of_all - 12.0 * mean) / 6.0
        assert 50.0 < missing <= 100.0


def test_mean_deviation_and_tests_over_scenes():
    rng = np.random.default_rng(0)
    right = np.concatenate([rng.uniform(40.0, 99.0, (18, 1)), rng.uniform(96.0, 99.0, (18, 6))], axis=1)
    rows = {row["scene"]: row for row in table_1.summarise(results_of(right))}
    assert rows["mean"]["k-means, visible"] == pytest.approx(right[:, 0].mean())
    assert rows["standard deviation"]["k-means, UV"] == pytest.approx(right[:, 1].std(ddof=1))
    assert rows["p, Wilcoxon against k-means, UV"]["k-means, visible"] < 0.001
    assert rows["p, F-ratio against k-means, UV"]["k-means, visible"] < 0.001
    assert rows["p, F-ratio against k-means, UV"]["k-means, UV-G"] > 0.01
    assert rows[SCENES[0].name]["kind"].startswith("rendered")


def test_verdicts_follow_from_the_accuracies():
    right = np.full((18, 7), 90.0) + np.linspace(-1.0, 1.0, 18)[:, None] * np.array([8.0, 1.0, 3.0, 9.0, 2.0, 4.0, 1.0])
    right[:, 1] += 6.0
    right[:, 6] += 6.0
    table = table_1.summarise(results_of(right))
    numbers = published_numbers(load("stone2014-table-1"), "stone2014-table-1")
    found = {verdict.quantity: verdict for verdict in table_1.compare(table, numbers)}
    assert found["difference of the means: k-means, UV and k-means, visible"].verdict == AGREES
    assert found["ratio of the standard deviations: k-means, visible and k-means, UV"].ours == pytest.approx(8.0)
    assert found["Forest floor, Sussex: GMM, UV"].verdict == NOT_COMPARABLE
    swapped = right.copy()
    swapped[:, [0, 1]] = right[:, [1, 0]]
    worse = {v.quantity: v for v in table_1.compare(table_1.summarise(results_of(swapped)), numbers)}
    assert worse["difference of the means: k-means, UV and k-means, visible"].verdict == DIFFERS
    few = {v.quantity: v for v in table_1.compare(table_1.summarise(results_of(right[:6])), numbers)}
    assert few["mean: k-means, UV"].verdict == NOT_COMPARABLE


def test_labels_are_drawn_in_four_colours():
    mask, truth = np.array([[True, True, False, False]]), np.array([[True, False, False, True]])
    picture = label_picture(mask, truth)[0]
    assert picture[0].tolist() == [1.0, 1.0, 1.0]
    assert picture[2].tolist() == [0.0, 0.0, 0.0]
    assert picture[1, 2] > picture[1, 0]  # blue
    assert picture[3, 0] > picture[3, 2]  # red


def test_separation_of_two_normal_distributions_is_their_distance_in_deviations():
    rng = np.random.default_rng(0)
    sky = np.arange(40_000).reshape(200, 200) % 2 == 0
    values = rng.standard_normal((200, 200, 5)) * np.where(sky, 1.0, 2.0)[..., None] + 3.0 * sky[..., None]
    expected = 3.0 / np.sqrt(0.5 * (1.0 + 4.0))
    assert fig_2._separations(values, sky) == pytest.approx(np.full(5, expected), abs=0.06)


def test_every_variation_has_a_name_of_its_own_and_changes_one_thing():
    names = [variation.name for variation in VARIATIONS]
    assert len(set(names)) == len(names)
    assert VARIATIONS[0].name == "as set"
    assert not VARIATIONS[0].is_of_the_light
    assert sum(variation.is_of_the_light for variation in VARIATIONS) == 11


def test_worst_case_is_found_over_all_variations():
    right = np.full((18, len(VARIATIONS), len(sensitivity.NAMES)), 90.0) + np.linspace(-1.0, 1.0, 18)[:, None, None]
    right[:, :, sensitivity.NAMES.index("k-means, UV")] += 5.0
    right[:, 4, sensitivity.NAMES.index("k-means, UV")] -= 7.0
    cells = [sensitivity.Cell(scene=scene.name, reduction=4, supersampling=1) for scene in SCENES]
    table = sensitivity.summarise(Results(cells, {"accuracy": right}))
    numbers = published_numbers(load("stone2014-sensitivity"), "stone2014-sensitivity")
    found = {verdict.quantity: verdict for verdict in sensitivity.compare(table, numbers)}
    assert found["UV less visible, k-means, as set"].ours == pytest.approx(5.0)
    worst = found["UV less visible, k-means, worst case"]
    assert worst.ours == pytest.approx(-2.0)
    assert worst.verdict == DIFFERS
    assert VARIATIONS[4].name in worst.why


def write_set(folder: Path, n: int) -> None:
    folder.mkdir(parents=True)
    rng = np.random.default_rng(0)
    for k in range(n):
        image = rng.integers(20, 60, (60, 80, 3)).astype(np.uint8)
        image[:25] += 150
        mask = np.zeros((60, 80), np.uint8)
        mask[:25] = 255
        assert cv2.imwrite(str(folder / f"{k:03d}.png"), image)
        assert cv2.imwrite(str(folder / f"{k:03d}_sky.png"), mask)


def test_a_set_of_photographs_is_read_and_labelled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    write_set(tmp_path / "camvid_sky", 3)
    monkeypatch.setenv("INSECTNAV_DATA", str(tmp_path))
    cells = real_photographs.grid("quick")
    assert [cell.n_images for cell in cells] == [3, 0]
    arrays = [real_photographs.simulate(cell, 0)["accuracy"][1] for cell in cells]
    results = Results(cells, {"accuracy": np.stack(arrays)})
    rows = real_photographs.summarise(results)
    first = {row["way"]: row for row in rows if row["set"] == "camvid_sky"}
    assert first["k-means, visible"]["mean"] == pytest.approx(100.0)
    assert first["k-means, visible"]["kind"] == "real photographs"
    assert "not found" in next(row["kind"] for row in rows if row["set"] == "fisheye_sky")
    assert "3 photographs" in real_photographs.caption(results)
    assert "not found" in real_photographs.caption(results)


def test_without_the_folder_every_set_is_said_to_be_missing(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.delenv("INSECTNAV_DATA", raising=False)
    cells = real_photographs.grid("full")
    assert [cell.n_images for cell in cells] == [0, 0]
    assert np.isnan(real_photographs.simulate(cells[0], 0)["accuracy"][1]).all()
