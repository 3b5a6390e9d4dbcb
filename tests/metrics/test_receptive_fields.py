"""Receptive fields of cells that fire at known positions of a bar."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import uniform_filter1d

from insectnav.angles import wrap
from insectnav.checks import InputError
from insectnav.metrics.receptive_fields import ReceptiveField, receptive_fields
from spike_trains import poisson

N = 192  # positions
STEP = 2 * np.pi / N
FRAME = 6.0 / N  # [s]
POSITIONS = -np.pi + STEP * np.arange(N)
seeds = st.integers(0, 2**32 - 1)


def bar(ways: tuple[int, ...] = (1, 1, -1, -1), first: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Frame edges (pass, N + 1) and azimuths (pass, N) of rotations that begin behind the animal, 8 s apart."""
    steps = np.arange(N)
    edges = 2.0 + 8.0 * np.arange(len(ways))[:, None] + FRAME * np.arange(N + 1)
    return edges, np.array([wrap(-np.pi + STEP * (first + way * steps)) for way in ways])


def spikes_in(edges: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """So many spikes in the middle of each frame (pass, N)."""
    return np.repeat(((edges[:, :-1] + edges[:, 1:]) / 2).ravel(), counts.astype(int).ravel())


def counts_at(azimuths: np.ndarray, response: np.ndarray) -> np.ndarray:
    """Counts of each frame, given those of each of the positions."""
    return response[np.rint((azimuths + np.pi) / STEP).astype(int) % N]


@pytest.mark.parametrize("place", [70, 0, 1, N - 1])
def test_one_spike_spreads_over_five_positions_round_the_circle(place: int):
    edges, azimuths = bar()
    response = np.eye(N)[place]
    fields = receptive_fields(spikes_in(edges, counts_at(azimuths, response)), edges, azimuths)
    # Two running means of three make the weights 1 2 3 2 1, in ninths.
    expected = sum(w * np.roll(response, k) for k, w in zip(range(-2, 3), (1, 2, 3, 2, 1), strict=True))
    for field in fields:
        np.testing.assert_allclose(field.azimuth, POSITIONS, atol=1e-12)
        np.testing.assert_allclose(field.rate, expected / 9 / FRAME, atol=1e-9)
        np.testing.assert_allclose(field.normalised, expected / 3, atol=1e-12)
        assert field.n_passes == 2


def test_one_spike_spreads_over_three_blocks():
    edges, azimuths = bar()
    field = receptive_fields(
        spikes_in(edges, counts_at(azimuths, np.eye(N)[0])), edges, azimuths, neighbours="blocks"
    ).clockwise
    np.testing.assert_allclose(field.azimuth, POSITIONS[1::3], atol=1e-12)
    expected = np.zeros(64)
    expected[[63, 0, 1]] = 1.0
    np.testing.assert_allclose(field.normalised, expected, atol=1e-12)
    np.testing.assert_allclose(field.rate, expected / 9 / FRAME, atol=1e-9)


@given(seeds, st.integers(0, N - 1))
def test_field_agrees_with_scipy_wherever_the_bar_begins(seed: int, first: int):
    response = np.random.default_rng(seed).integers(0, 5, (2, N))
    edges, azimuths = bar((1, 1, -1), first)
    counts = np.stack([counts_at(azimuths[i], response[k]) for i, k in enumerate((0, 1, 0))])
    fields = receptive_fields(spikes_in(edges, counts), edges, azimuths)
    for field, rate in zip(fields, (response.mean(axis=0), response[0]), strict=True):
        smooth = uniform_filter1d(uniform_filter1d(rate / FRAME, 3, mode="wrap"), 3, mode="wrap")
        np.testing.assert_allclose(field.rate, smooth, atol=1e-9)
        np.testing.assert_allclose(field.normalised, smooth / smooth.max(), atol=1e-12)
    assert [field.n_passes for field in fields] == [2, 1]


def test_frames_of_unequal_length_give_rates():
    edges, azimuths = bar((1,))
    edges = np.cumsum(np.random.default_rng(2).uniform(0.5, 2.0, (1, N + 1)) * FRAME, axis=-1)
    spikes = spikes_in(edges, np.full((1, N), 3))
    rate = uniform_filter1d(uniform_filter1d(3 / np.diff(edges[0]), 3, mode="wrap"), 3, mode="wrap")
    np.testing.assert_allclose(receptive_fields(spikes, edges, azimuths).clockwise.rate, rate)


@given(seeds, st.integers(0, N - 1))
def test_field_turns_and_mirrors_with_the_world(seed: int, by: int):
    edges, azimuths = bar()
    spikes = np.random.default_rng(seed).uniform(0.0, 34.0, 500)
    fields = receptive_fields(spikes, edges, azimuths)
    turned = receptive_fields(spikes, edges, wrap(azimuths + by * STEP))
    mirrored = receptive_fields(spikes, edges, -azimuths)
    for way in range(2):
        np.testing.assert_allclose(turned[way].rate, np.roll(fields[way].rate, by), atol=1e-9)
        # −π is its own mirror image, so the others change places about it.
        np.testing.assert_allclose(mirrored[way].rate, np.roll(fields[1 - way].rate[::-1], 1), atol=1e-9)


def test_poisson_field_is_recovered():
    ways = (1, -1) * 20
    edges, azimuths = bar(ways)
    centre, width = np.deg2rad(-60.0), np.deg2rad(15.0)

    def response(azimuth: np.ndarray) -> np.ndarray:
        return 5.0 + 95.0 * np.exp(-(wrap(azimuth - centre) ** 2) / (2 * width**2))

    def rate(time: np.ndarray) -> np.ndarray:
        index = np.clip(np.searchsorted(edges[:, 0], time, side="right") - 1, 0, None)
        frame = np.floor((time - edges[index, 0]) / FRAME).astype(int)
        return np.where((frame >= 0) & (frame < N), response(azimuths[index, np.clip(frame, 0, N - 1)]), 0.0)

    fields = receptive_fields(poisson(rate, 100.0, edges[-1, -1], seed=8), edges, azimuths)
    kernel = np.array([1, 2, 3, 2, 1]) / 9
    smooth = sum(w * np.roll(response(POSITIONS), k) for k, w in zip(range(-2, 3), kernel, strict=True))
    variance = sum(w**2 * np.roll(response(POSITIONS), k) for k, w in zip(range(-2, 3), kernel, strict=True))
    for field in fields:
        z = (field.rate - smooth) / np.sqrt(variance / (20 * FRAME))
        assert np.abs(z).max() < 5.5  # of 192; the counts are a little skewed
        assert 0.8 < np.std(z) < 1.2


def test_way_that_was_not_shown_and_silent_cell_have_no_field():
    edges, azimuths = bar((1, 1))
    fields = receptive_fields([], edges, azimuths)
    assert isinstance(fields.clockwise, ReceptiveField)
    assert fields.clockwise.rate.tolist() == [0.0] * N
    assert np.isnan(fields.clockwise.normalised).all()
    assert fields.anticlockwise.n_passes == 0
    assert np.isnan(fields.anticlockwise.rate).all()


@pytest.mark.parametrize("noise", [1e-12, 1e-3])
def test_small_errors_of_position_do_no_harm(noise: float):
    edges, azimuths = bar()
    spikes = np.random.default_rng(3).uniform(0.0, 34.0, 500)
    jitter = np.random.default_rng(4).uniform(-noise, noise, azimuths.shape) * STEP
    for exact, rough in zip(
        receptive_fields(spikes, edges, azimuths), receptive_fields(spikes, edges, wrap(azimuths + jitter)), strict=True
    ):
        roll = round(float(rough.azimuth[0] - exact.azimuth[0]) / STEP)  # the first may have crossed to the far end
        np.testing.assert_allclose(np.roll(rough.rate, roll), exact.rate, atol=1e-9)


def changed(index: tuple, value: float) -> np.ndarray:
    azimuths = bar()[1].copy()
    azimuths[index] = value
    return azimuths


@pytest.mark.parametrize(
    ("edges", "azimuths", "message"),
    [
        (bar()[0], bar()[1].T, "frame_edges has shape"),
        (bar()[0][:, 1:], bar()[1], "frame_edges has shape"),
        (bar()[0][:, ::-1], bar()[1], "frame_edges does not ascend"),
        (bar()[0] * np.nan, bar()[1], "frame_edges is nan"),
        (bar()[0], np.rad2deg(bar()[1]), "azimuth reaches.*degrees"),
        (bar()[0], bar()[1][0], "azimuth has shape"),
        (bar()[0][:, :3], bar()[1][:, :2], "azimuth has shape"),
        (bar()[0], changed((2, 5), 0.0), "azimuth of pass 2 does not go round once in 192 even steps one way"),
        (bar()[0], changed((1, 5), np.nan), "azimuth is nan"),
        (bar()[0], bar()[1] / 2, "azimuth of pass 0 does not go round once"),
        (bar()[0], wrap(bar()[1] + STEP / 2 * np.arange(4)[:, None]), "azimuth differs between passes"),
        (bar()[0][:0], bar()[1][:0], "azimuth has shape"),
    ],
)
def test_bad_passes_are_refused_in_one_sentence(edges: np.ndarray, azimuths: np.ndarray, message: str):
    with pytest.raises(InputError, match=message) as caught:
        receptive_fields([1.0], edges, azimuths)
    assert "\n" not in str(caught.value)


def test_blocks_must_divide_the_positions():
    azimuths = wrap(2 * np.pi / 8 * np.arange(8))[None]
    with pytest.raises(InputError, match="azimuth has 8 positions, expected a multiple of 3 for blocks"):
        receptive_fields([1.0], np.arange(9.0)[None], azimuths, neighbours="blocks")
    with pytest.raises(InputError, match=r"neighbours 'block' is unknown.*did you mean blocks"):
        receptive_fields([1.0], np.arange(9.0)[None], azimuths, neighbours="block")
