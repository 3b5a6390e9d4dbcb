"""The texture: its place in the world, its variance and its spectrum."""

import numpy as np
import pytest

from insectnav.checks import InputError
from insectnav.worlds.texture import pack_octaves, texture, textured
from texture_oracle import octave

RNG = np.random.default_rng(0)


def test_a_point_has_one_value_whatever_else_is_asked_for():
    points = RNG.uniform(-40.0, 40.0, (50, 4, 3))
    all_at_once = texture(points, seed=3)
    assert all_at_once.shape == (50, 4)
    np.testing.assert_array_equal(all_at_once[7, 2], texture(points[7, 2], seed=3))
    np.testing.assert_array_equal(all_at_once[::-1], texture(points[::-1], seed=3))


def test_seeds_are_independent():
    points = RNG.uniform(-1000.0, 1000.0, (20_000, 3))
    one, other = texture(points, seed=1), texture(points, seed=2)
    assert abs(np.corrcoef(one, other)[0, 1]) < 5 / np.sqrt(len(points))


@pytest.mark.parametrize("n_octaves", [1, 3, 8])
def test_mean_is_0_and_variance_1(n_octaves: int):
    """Bounds of five standard errors; points lie farther apart than the coarsest pattern, so they are independent."""
    n = 40_000
    points = np.stack([np.arange(n) * 2.7182818, RNG.uniform(0, 1e3, n), RNG.uniform(0, 1e3, n)], axis=-1)
    value = texture(points, seed=5, n_octaves=n_octaves)
    assert abs(value.mean()) < 5 / np.sqrt(n)
    fourth = (value**4).mean()
    assert abs((value**2).mean() - 1.0) < 5 * np.sqrt((fourth - 1) / n)


def test_power_along_a_line_falls_as_one_over_the_frequency():
    """Slope of log power over octaves of frequency, between the coarsest and the finest; white noise has 0, brown −2.

    The lowest band has 8 frequencies of 48 lines: a standard error of 0.05 in log power, of 0.02 in the slope.
    """
    n, step = 4096, 1 / 256
    lines = np.zeros((48, n, 3))
    lines[..., :2] = RNG.uniform(-500.0, 500.0, (48, 1, 2))
    angle = RNG.uniform(0.0, 2 * np.pi, (48, 1))
    lines[..., 0] += np.cos(angle) * step * np.arange(n)
    lines[..., 1] += np.sin(angle) * step * np.arange(n)
    value = texture(lines, seed=2, coarsest=4.0, n_octaves=9) * np.hanning(n)
    power = (np.abs(np.fft.rfft(value, axis=1)) ** 2).mean(axis=0)
    frequency = np.fft.rfftfreq(n, step)
    low = 2.0 ** np.arange(-1.0, 4.0)  # [cycles/m]; patterns reach from 4 m to 1/64 m
    mean = [power[(frequency >= edge) & (frequency < 2 * edge)].mean() for edge in low]
    assert np.polyfit(np.log(low), np.log(mean), 1)[0] == pytest.approx(-1.0, abs=0.12)


def test_octaves_halve_the_pattern():
    """With one octave, the pattern of half the size is the same pattern at half the distances."""
    points = RNG.uniform(-3.0, 3.0, (100, 3))
    np.testing.assert_allclose(
        texture(points, seed=4, coarsest=1.0, n_octaves=1), texture(points / 2, seed=4, coarsest=0.5, n_octaves=1)
    )


def test_it_is_continuous_across_the_lattice():
    near = np.array([[2.0, 0.3, 0.4], [-5.0, 0.7, 0.1], [0.0, 1.0, 3.0]])
    assert np.abs(texture(near - 1e-9, seed=0) - texture(near + 1e-9, seed=0)).max() < 1e-5


def test_reflectance_with_texture_stays_a_reflectance():
    value = np.array([-10.0, 0.0, 1.0, 10.0])
    np.testing.assert_allclose(textured(0.5, value, 0.3), [0.0, 0.5, 0.65, 1.0])
    np.testing.assert_array_equal(textured(0.5, value, 0.0), 0.5)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"points": [[0.0, 1.0]]}, "shape"),
        ({"points": [[0.0, np.nan, 1.0]]}, "finite"),
        ({"points": [[0.0, 1e12, 1.0]]}, "points reaches"),
        ({"seed": -1}, "seed"),
        ({"coarsest": 0.0}, "coarsest"),
        ({"n_octaves": 0}, "n_octaves"),
        ({"n_octaves": 50}, "n_octaves"),
    ],
)
def test_bad_input(changes: dict, words: str):
    given = {"points": [[0.0, 0.0, 0.0]], "seed": 0} | changes
    with pytest.raises(InputError, match=words):
        texture(given.pop("points"), **given)
    with pytest.raises(InputError, match="contrast"):
        textured(0.5, 0.0, 30.0)


@pytest.mark.parametrize("n_octaves", [1, 2, 7])
def test_it_is_the_sum_of_octaves_of_the_plain_implementation(n_octaves: int):
    points = RNG.uniform(-200.0, 200.0, (2000, 3))
    points[:30] = np.round(points[:30])  # corners of the lattice too
    octaves = pack_octaves(11, 2.0, n_octaves)
    plain = sum(
        octave(points * 2.0**k / 2.0 + octaves.shift[k], octaves.salt[k]) for k in range(n_octaves)
    ) * octaves.scale  # fmt: skip
    np.testing.assert_allclose(texture(points, seed=11, coarsest=2.0, n_octaves=n_octaves), plain, rtol=0, atol=1e-10)
