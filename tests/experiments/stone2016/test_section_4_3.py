"""Small runs of the experiments of section 4.3, in the built world, from simulation to verdicts; and their laws."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.experiments.published import NOT_COMPARABLE
from insectnav.experiments.stone2016_homing import clutter, coding, fig_4_3, fig_4_4, fig_4_5, fig_4_6, sampling
from insectnav.experiments.stone2016_homing.area_table import area_row, paired_row, ratio_of_means
from insectnav.experiments.stone2016_homing.comparisons import COMPARISONS, landmark_vectors, order_amplitudes
from insectnav.experiments.stone2016_homing.places import SIZE
from insectnav.homing import average_landmark_vector
from insectnav.vision.descriptors import harmonic_amplitudes, zernike_amplitudes
from small_runs import same_bits, simulated, verdicts_of

WHERE = {"world": "ant-world", "corner": -5.0}
COARSE = {"spacing": 1.0, "supersampling": 1}  # all references but for y are off such a grid: good enough to run
SMALL = {
    "stone2016-fig-4-3": (fig_4_3, [fig_4_3.Cell(**WHERE, supersampling=1)]),
    "stone2016-fig-4-4": (fig_4_4, [fig_4_4.Cell(**WHERE, **COARSE)]),
    "stone2016-fig-4-5": (
        fig_4_5,
        [fig_4_5.Cell(**WHERE, **COARSE, heading=h, every=2) for h in ("aligned", "random")],
    ),
    "stone2016-fig-4-6": (fig_4_6, [fig_4_6.Cell(**WHERE, supersampling=1)]),
    "stone2016-sampling": (
        sampling,
        [sampling.Cell(**WHERE, **COARSE, heading=h, n_spacings=1) for h in ("aligned", "random")],
    ),
    "stone2016-coding": (coding, [coding.Cell(**WHERE, **COARSE, heading=h) for h in ("aligned", "random")]),
    "stone2016-clutter": (
        clutter,
        [
            clutter.Cell(**WHERE, **COARSE, heading=h, label="built, 12 m", clearing=12.0, world_seed=0)
            for h in ("aligned", "random")
        ],
    ),
}  # fmt: skip


@pytest.fixture(scope="module", params=list(SMALL))
def small(request):
    experiment, cells = SMALL[request.param]
    return request.param, experiment, simulated(experiment, cells)


def test_small_run_gives_all_verdicts_and_says_that_it_is_a_stand_in(small):
    name, experiment, results = small
    verdicts = verdicts_of(experiment, name, results)
    assert verdicts
    assert {verdict.verdict for verdict in verdicts} == {NOT_COMPARABLE}
    assert all("not part of insectnav" in verdict.why for verdict in verdicts)
    words = experiment.caption(results)
    assert "stand-in" in words or "built ant-world" in words


def test_areas_are_within_the_box(small):
    _, _, results = small
    for name, values in results.arrays.items():
        if name == "area":
            assert ((values >= 0.0) & (values <= SIZE**2 + 1e-3)).all()


def test_random_headings_differ_with_the_seed_and_nothing_else():
    assert same_bits(fig_4_5, SMALL["stone2016-fig-4-5"][1][1])


def test_aligned_knows_no_seed():
    cell = SMALL["stone2016-fig-4-5"][1][0]
    assert_array_equal(fig_4_5.simulate(cell, 0)["area"][1], fig_4_5.simulate(cell, 1)["area"][1])


# Fig. 4.5: rows.


def test_rows_are_of_the_areas_that_are_kept():
    results = simulated(*SMALL["stone2016-fig-4-5"])
    rows = fig_4_5.summarise(results)
    assert len(rows) == 2 * len(COMPARISONS) * 2
    for row in rows:
        cell, name = results.only(heading=row["heading"]), list(COMPARISONS).index(row["comparison"])
        area = results["area"][cell, name, 0 if row["spacing_m"] == 1.0 else 1].astype(float)
        other = results["area"][1 - cell, name, 0 if row["spacing_m"] == 1.0 else 1].astype(float)
        assert row["mean_area_m2"] == pytest.approx(sum(map(float, area)) / 20)
        assert row["over_other_heading"] == pytest.approx(area.mean() / other.mean(), nan_ok=True)


def test_summary_of_areas():
    row = area_row([1.0, 2.0, 3.0, 6.0])
    assert (row["mean_area_m2"], row["median_m2"], row["least_m2"], row["largest_m2"], row["n"]) == (3, 2.5, 1, 6, 4)
    assert row["sd_m2"] == pytest.approx((14.0 / 3.0) ** 0.5)
    assert row["standard_error_m2"] == pytest.approx((14.0 / 3.0) ** 0.5 / 2.0)


def test_pairs_of_areas():
    larger = paired_row([2.0, 4.5, 6.0, 8.0, 11.0], [1.0, 2.0, 3.0, 4.0, 5.0], "pixels")
    assert larger["rank_biserial_against_pixels"] == 1.0
    assert larger["p_larger_than_pixels"] == pytest.approx(0.5**5)
    smaller = paired_row([1.0, 2.0, 3.0, 4.0, 5.0], [2.0, 4.5, 6.0, 8.0, 11.0], "pixels")
    assert smaller["p_larger_than_pixels"] == pytest.approx(1.0 - 0.5**5)
    assert paired_row([1.0, 2.0], [1.0, 2.0], "x")["p_larger_than_x"] == 0.5


def test_error_of_a_ratio():
    """By its definition for large samples: the SD of the ratio over samples drawn anew."""
    rng = np.random.default_rng(0)
    first = rng.normal(10.0, 1.0, (4000, 50))
    second = 0.5 * first + rng.normal(0.0, 0.5, first.shape)
    spread = np.std(first.mean(axis=1) / second.mean(axis=1))
    errors = [ratio_of_means(a, b)[1] for a, b in zip(first[:200], second[:200], strict=True)]
    assert np.mean(errors) == pytest.approx(spread, rel=0.1)
    assert ratio_of_means(first[0], 2.0 * first[0]) == (pytest.approx(0.5), pytest.approx(0.0, abs=1e-12))
    assert np.isnan(ratio_of_means([1.0], [0.0])).all()


# Codes.


def panoramas(n, seed=0):
    return np.random.default_rng(seed).random((n, 105, 360)).astype(np.float32)


def test_order_amplitudes_forget_whole_columns_and_add_up_to_those_of_degrees():
    views = panoramas(3)
    found = order_amplitudes(views, 9)
    assert found.shape == (3, 45)
    assert_allclose(order_amplitudes(np.roll(views, 77, axis=-1), 9), found, rtol=1e-6)
    first = np.cumsum([0, *range(1, 9)])
    whole = np.stack([np.linalg.norm(found[:, i : i + k + 1], axis=-1) for k, i in enumerate(first)], axis=-1)
    assert_allclose(whole, harmonic_amplitudes(views, 9), rtol=1e-6)


def test_code_distances_are_those_of_each_code_by_itself():
    views, remembered = panoramas(5), panoramas(2, 1)
    found = coding.CodeDistances(remembered)(views)
    assert found.shape == (5, len(coding.CODES) - 1, 2)
    for family, weights in (("zernike-stone", "stone"), ("zernike-orthonormal", "orthonormal"), ("zernike-raw", "raw")):
        for order in (2, 16, 32):
            here, there = (zernike_amplitudes(each, order, weights=weights) for each in (views, remembered))
            place = coding.CODES.index((family, order)) - 1
            expected = np.linalg.norm(here[:, None] - there, axis=-1)
            assert_allclose(found[:, place], expected, rtol=1e-9)
    place = coding.CODES.index(("harmonic-degrees", 8)) - 1
    here, there = (harmonic_amplitudes(each, 9) for each in (views, remembered))
    assert_allclose(found[:, place], np.linalg.norm(here[:, None] - there, axis=-1), rtol=1e-9)


def test_landmark_vectors_of_black_on_white_are_those_of_a_mask():
    mask = np.random.default_rng(3).random((4, 105, 360)) < 0.2
    expected = average_landmark_vector(mask[:, :90])
    assert_allclose(landmark_vectors(1.0 - mask), expected, rtol=1e-9, atol=1e-12)


# Figs 4.4 and 4.6.


def test_raster_of_the_nearest():
    values = np.arange(500 * 500).reshape(500, 500)
    assert_array_equal(fig_4_4.on_raster(values), values)
    small = fig_4_4.on_raster(np.eye(2))
    assert small[:250, :250].all()
    assert not small[250:, :250].any()


def test_pairs_are_as_far_apart_as_the_figure_says():
    pairs = fig_4_6.pair_places(-5.0)
    assert_allclose(np.linalg.norm(pairs[:, 1] - pairs[:, 0], axis=-1), 3.6)
    assert_allclose(pairs[0, 1] - pairs[0, 0], [3.6, 0.0], atol=1e-12)  # the one that is drawn: to the east
    assert (np.abs(pairs) <= 5.0).all()
    assert len(np.unique(pairs.reshape(len(pairs), 4).round(6), axis=0)) == len(pairs)


def test_equal_views_are_alike_and_disjoint_plants_misaligned():
    views, amplitude = panoramas(1)[[0, 0]], fig_4_6.normalised(zernike_amplitudes(panoramas(1)))[[0, 0]]
    plants = np.zeros((2, 90, 360))
    plants[:, 40, :50] = 1.0
    assert_allclose(fig_4_6.pair_measures(views, plants, amplitude), [0.0, 0.0, 0.0, 1.0, 1.0], atol=1e-12)
    plants[1] = np.roll(plants[0], 100, axis=-1)
    assert fig_4_6.pair_measures(views, plants, amplitude)[0] == 1.0


def test_cells_of_other_worlds_have_other_keys():
    from insectnav.experiments.experiment import results_key

    cells = SMALL["stone2016-fig-4-5"][1]
    there = [replace(cell, world="clearing") for cell in cells]
    assert results_key(fig_4_5, cells, 0) != results_key(fig_4_5, there, 0)
