"""The model's cells recorded as a lab's: their rates against the oracle, the analyses against closed forms."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from insectnav.central_complex import CODE_2017, THESIS
from insectnav.experiments.experiment import Results
from insectnav.experiments.published import AGREES, read_published
from insectnav.experiments.stone2017_path_integration import physiology
from insectnav.experiments.stone2017_path_integration.physiology import (
    AZIMUTHS,
    COMPASS_SHIFT_DEG,
    VELOCITIES,
    Cell,
)
from insectnav.experiments.stone2017_path_integration.physiology_table import find
from oracle import THESIS as ORACLE
from oracle import compass, flow_neurons, initial_state

N_ANIMALS = 16
PLAIN = {"anticipation_deg": 0.0, "noise": 0.1, "step_ms": 10.0}
SHIFTED = PLAIN | {"anticipation_deg": COMPASS_SHIFT_DEG}


@pytest.fixture(scope="module")
def results() -> Results:
    cells = [replace(cell, n_animals=N_ANIMALS, n_turns=1) for cell in physiology.grid("quick")[:4]]
    found = [physiology.simulate(cell, seed=3) for cell in cells]
    return Results(cells, {name: np.stack([arrays[name][1] for arrays in found]) for name in found[0]})


@pytest.fixture(scope="module")
def noiseless() -> dict[str, np.ndarray]:
    return {name: values[1] for name, values in physiology.simulate(Cell(noise=0.0, n_animals=N_ANIMALS), 3).items()}


def static_rates_of_oracle(is_polariser: bool) -> np.ndarray:
    """First TL, CL1 and TB1 cell at every fifth degree of a stimulus that has stood still for a while."""
    curves = []
    for degree in range(0, 360, 5):
        tb1, _ = initial_state()
        for _ in range(40):
            tl, cl1, tb1 = compass(tb1, np.radians(degree) * (2 if is_polariser else 1), ORACLE, 0.0, None)
        curves.append((tl[0], cl1[0], tb1[0]))
    return np.array(curves).T


@pytest.mark.parametrize("stimulus", ["heading", "polariser"])
def test_rates_at_rest_are_those_of_the_oracle(results: Results, stimulus: str):
    ours = results["static_rate"][results.only(stimulus=stimulus, anticipation_deg=0.0)]
    np.testing.assert_allclose(ours[:, ::5], static_rates_of_oracle(stimulus == "polariser"), atol=2e-5)


def test_widths_without_spikes_are_the_closed_form(results: Results):
    """TL: σ(a cos x − b) is halfway between its ends where a cos x − b is the logit of their mean; CL1 likewise."""

    def sigmoid(x: float) -> float:
        return 1.0 / (1.0 + np.exp(-x))

    def half_width(low: float, high: float, slope: float, bias: float) -> float:
        middle = (low + high) / 2.0
        return (np.log(middle / (1.0 - middle)) + bias) / slope

    top, bottom = sigmoid(6.8 - 3.0), sigmoid(-6.8 - 3.0)
    tl = 2.0 * np.degrees(np.arccos(half_width(bottom, top, 6.8, 3.0)))
    tl_at_half = -half_width(sigmoid(-3.0 * top + 0.5), sigmoid(-3.0 * bottom + 0.5), 3.0, -0.5)
    alignment = (np.log(tl_at_half / (1.0 - tl_at_half)) + 3.0) / 6.8
    cl1 = 360.0 - 2.0 * np.degrees(np.arccos(alignment))
    rows = find(physiology.summarise(results), stimulus="heading", **PLAIN)
    assert rows["TL", "tuning width without spikes"]["value"] == pytest.approx(tl, abs=0.01)
    assert rows["CL1", "tuning width without spikes"]["value"] == pytest.approx(cl1, abs=0.01)
    axial = find(physiology.summarise(results), stimulus="polariser", **PLAIN)
    assert axial["TL", "tuning width without spikes"]["value"] == pytest.approx(tl / 2.0, abs=0.01)


def test_flow_cells_fire_at_the_rates_of_the_oracle(noiseless: dict[str, np.ndarray]):
    """Mean over cells and two seconds of a Poisson count: five standard errors."""
    for index, forward in enumerate(VELOCITIES / np.cos(np.pi / 4.0)):
        tn1, tn2 = flow_neurons(0.0, np.array([0.0, forward]), ORACLE, 0.0, None)
        for kind, expected in enumerate((tn1, tn2)):
            rate = noiseless["rate_by_velocity"][kind, :, :, index].mean(axis=1)
            error = np.sqrt(150.0 * expected / (2.0 * N_ANIMALS))
            assert np.all(np.abs(rate - 150.0 * expected) <= 5.0 * error + 1e-3)
    for index, azimuth in enumerate(AZIMUTHS):
        tn1, tn2 = flow_neurons(0.0, np.array([np.sin(azimuth), np.cos(azimuth)]), ORACLE, 0.0, None)
        for kind, expected in enumerate((tn1, tn2)):
            rate = noiseless["rate_by_azimuth"][kind, :, :, index].mean(axis=1)
            error = np.sqrt(150.0 * expected / (2.0 * N_ANIMALS))
            assert np.all(np.abs(rate - 150.0 * expected) <= 5.0 * error + 1e-3)


@pytest.mark.parametrize("kind", ["TL", "CL1"])
@pytest.mark.parametrize("stimulus", ["heading", "polariser"])
def test_compass_shift_comes_back_twice(results: Results, stimulus: str, kind: str):
    """Ahead in one direction and as far in the other; without it the cells follow the stimulus."""
    table = physiology.summarise(results)
    for conditions, expected in ((PLAIN, 0.0), (SHIFTED, 2.0 * COMPASS_SHIFT_DEG)):
        row = find(table, stimulus=stimulus, **conditions)[kind, "shift"]
        assert abs(row["value"] - expected) < 4.0 * row["standard_error"]
        assert row["standard_error"] < 2.0


def test_preferred_expansion_points_lie_on_the_axes_of_the_cells(noiseless: dict[str, np.ndarray]):
    """Right and left of TN1, then TN2: back left, back right, front right, front left."""
    expected = np.array([[-135.0, 135.0], [45.0, -45.0]])[..., None]
    error = noiseless["expansion_point"] - expected
    assert np.all(np.abs(error.mean(axis=-1)) < 4.0 * error.std(axis=-1, ddof=1) / np.sqrt(N_ANIMALS))
    assert np.abs(error).max() < 10.0


def test_mirrored_cells_respond_alike_to_mirrored_expansion(noiseless: dict[str, np.ndarray]):
    """The circuit has no side: rates of the left cell at −azimuth are those of the right cell at azimuth."""
    right, left = noiseless["rate_by_azimuth"].mean(axis=2).transpose(1, 0, 2)
    mirrored = np.roll(left[:, ::-1], 1, axis=-1)  # azimuths −180, −157.5, ... 157.5 degrees
    error = np.sqrt((right + mirrored) / (2.0 * N_ANIMALS))
    assert np.all(np.abs(right - mirrored) <= 5.0 * error)


def test_rotation_and_darkness_leave_flow_cells_at_their_background(results: Results):
    rows = find(physiology.summarise(results), stimulus="heading", **PLAIN)
    for kind, exciting in (("TN1", "backward"), ("TN2", "forward")):
        for stimulus in ("rotational flow", f"darkness after {exciting} flow"):
            row = rows[kind, f"response to {stimulus}"]
            assert abs(row["value"]) < 4.0 * row["standard_error"]


def test_cells_shown_are_the_same_under_both_sets_of_constants():
    from insectnav.experiments.stone2017_path_integration.virtual_recordings import recorded_rates

    heading, velocity = np.linspace(-3.0, 3.0, 200), np.full((200, 2), 0.4)
    options = {"noise": 0.1, "seed": 1, "first_trial": 0, "n_animals": 2}
    pairs = zip(
        recorded_rates(heading, velocity, THESIS, **options),
        recorded_rates(heading, velocity, CODE_2017, **options),
        strict=True,
    )
    for (_, thesis), (_, code) in pairs:
        assert set(thesis) == {"tl", "cl1", "tb1", "tn1", "tn2"}
        for name in thesis:
            np.testing.assert_array_equal(thesis[name], code[name])


def test_same_seed_gives_the_same_bits_however_many_animals():
    few, more = (physiology.simulate(Cell(n_animals=n, n_turns=1), seed=5) for n in (3, 17))
    again = physiology.simulate(Cell(n_animals=3, n_turns=1), seed=5)
    other = physiology.simulate(Cell(n_animals=3, n_turns=1), seed=6)
    for name, (dimensions, values, *_) in few.items():
        np.testing.assert_array_equal(values, again[name][1])
        if "animal" in dimensions:
            axis = dimensions.index("animal")
            np.testing.assert_array_equal(values, np.take(more[name][1], range(3), axis=axis))
            if values.dtype != bool:
                assert not np.array_equal(values, other[name][1], equal_nan=True)


def test_every_published_quantity_gets_a_verdict_and_differences_a_reason(results: Results, tmp_path: Path):
    published = read_published(Path(physiology.__file__).with_name("published.csv"), "stone2017-physiology")
    verdicts = physiology.compare(physiology.summarise(results), published)
    assert [verdict.quantity for verdict in verdicts] == list(published)
    assert all(verdict.why for verdict in verdicts if verdict.verdict != AGREES)
    caption = physiology.caption(results)
    assert f"n = {N_ANIMALS} animals" in caption
    figure = physiology.draw(results)
    figure.savefig(tmp_path / "figure.png")
    assert len(figure.axes) == 8


def test_spacing_shows_a_displaced_cell(results: Results):
    """Turn the preference of every cell of one direction by 10 degrees: the spacings beside it change by that much."""
    index = results.only(stimulus="heading", anticipation_deg=0.0)
    preferred = np.zeros_like(results["preferred_angle"])
    preferred[index] = (
        45.0 * (np.arange(N_ANIMALS) % 8) + 10.0 * (np.arange(N_ANIMALS) % 8 == 3) + 180.0
    ) % 360.0 - 180.0
    displaced = Results(results.cells, dict(results.arrays) | {"preferred_angle": preferred})
    rows = find(physiology.summarise(displaced), stimulus="heading", **PLAIN)
    assert rows["TB1", "least spacing of preferred angles"]["value"] == pytest.approx(35.0, abs=1e-4)
    assert rows["TB1", "largest spacing of preferred angles"]["value"] == pytest.approx(55.0, abs=1e-4)
