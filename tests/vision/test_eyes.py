"""Compound eyes put together from published numbers."""

from dataclasses import replace

import numpy as np
import pytest

from insectnav.checks import InputError
from insectnav.vision.eyes import (
    CATAGLYPHIS_BICOLOR,
    EYES,
    HONEYBEE,
    LEFT,
    MELOPHORUS_BAGOTI,
    RIGHT,
    CompoundEye,
    both_eyes,
    desert_ant,
    honeybee,
    interommatidial_angles,
)
from insectnav.vision.sphere import azimuth_elevation, directions, fibonacci, great_circle_angle

DEGREE = np.pi / 180
MADE = {name: make() for name, make in EYES.items()}


@pytest.mark.parametrize("name", EYES)
def test_eyes_are_mirror_images_of_unit_vectors(name: str):
    eye = MADE[name]
    left, right = (eye.directions[eye.side == side] for side in (LEFT, RIGHT))
    np.testing.assert_array_equal(left, right * [-1, 1, 1])
    np.testing.assert_allclose(np.linalg.norm(eye.directions, axis=-1), 1.0, rtol=1e-14)
    for values in (eye.acceptance, eye.has_band, eye.is_dorsal_rim):
        np.testing.assert_array_equal(values[eye.side == LEFT], values[eye.side == RIGHT])
    assert eye.has_band.any(axis=1).all()


@pytest.mark.parametrize("name", EYES)
def test_no_ommatidium_looks_where_another_of_its_eye_does(name: str):
    eye = MADE[name]
    right = eye.directions[eye.side == RIGHT]
    assert len(np.unique(np.round(right, 6), axis=0)) == len(right)
    chord = np.linalg.norm(right[:, None] - right[None], axis=-1) if len(right) < 2000 else None
    if chord is not None:
        np.fill_diagonal(chord, 9.0)
        assert chord.min() > 0.8 * np.median(chord.min(axis=0))


@pytest.mark.parametrize("name", EYES)
def test_preferred_e_vectors_lie_across_the_line_of_sight_and_level(name: str):
    eye = MADE[name]
    rim = eye.is_dorsal_rim
    axes, sight = eye.e_vector[rim], eye.directions[rim]
    np.testing.assert_allclose(np.linalg.norm(axes, axis=-1), 1.0, rtol=1e-14)
    np.testing.assert_allclose((axes * sight).sum(axis=-1), 0.0, atol=1e-14)
    np.testing.assert_array_equal(axes[:, 2], 0.0)
    assert (azimuth_elevation(sight)[1] > 0.5).all()
    assert np.isnan(eye.e_vector[~rim]).all()


def test_cataglyphis_has_its_published_numbers():
    eye = MADE["cataglyphis-bicolor"]
    right = eye.side == RIGHT
    assert right.sum() == 1000
    assert eye.bands == ("uv", "green")
    assert 55 <= (eye.is_dorsal_rim & right).sum() <= 75  # Wehner 2001
    assert eye.polarisation_sensitivity == 6.3  # Labhart 1986
    np.testing.assert_allclose(np.rad2deg(eye.acceptance[eye.is_dorsal_rim]), 5.4, rtol=1e-12)  # Labhart 1986
    azimuth, elevation = np.rad2deg(azimuth_elevation(eye.directions))
    ahead = (np.abs(azimuth) < 5) & (np.abs(elevation) < 5)
    assert np.rad2deg(eye.acceptance[ahead]) == pytest.approx(3.0, abs=0.3)  # Labhart 1986
    assert 149 < np.abs(azimuth).max() < 150
    # Duelli (1975): the region that matters looks at elevations of about 43° to 65°, its centre at 51° and 45° aside.
    rim = azimuth_elevation(eye.directions[eye.is_dorsal_rim & right].mean(axis=0))
    np.testing.assert_allclose(np.rad2deg(rim), [45.0, 51.0], atol=3.0)


@pytest.mark.parametrize("params", [CATAGLYPHIS_BICOLOR, MELOPHORUS_BAGOTI])
def test_ommatidia_of_ants_are_spread_evenly_over_the_field(params):
    eye = desert_ant(params)
    right = eye.directions[eye.side == RIGHT]
    low, high = np.sin(np.deg2rad(params.elevation_deg))
    solid_angle = np.deg2rad(params.azimuth_deg[1] - params.azimuth_deg[0]) * (high - low)
    # Of hexagons with that many cells; the spiral is at most an eighth wider on average.
    hexagon = np.sqrt(2 / np.sqrt(3) * solid_angle / params.n_ommatidia)
    assert 1.0 < np.median(interommatidial_angles(right)) / hexagon < 1.125
    half = np.count_nonzero(right[:, 2] > (low + high) / 2)
    assert half == pytest.approx(params.n_ommatidia / 2, abs=0.02 * params.n_ommatidia)


def test_melophorus_has_its_published_numbers():
    eye = MADE["melophorus-bagoti"]
    right = eye.directions[eye.side == RIGHT]
    assert 420 <= len(right) <= 590  # Schwarz et al. 2011, as the next two
    assert np.rad2deg(np.median(interommatidial_angles(right))) == pytest.approx(3.7, rel=0.1)
    np.testing.assert_allclose(np.rad2deg(eye.acceptance), np.hypot(2.9, 2.3), atol=0.01)
    assert not eye.is_dorsal_rim.any()
    assert eye.polarisation_sensitivity is None


def test_honeybee_has_nearly_the_counted_number_of_ommatidia():
    assert (MADE["honeybee"].side == RIGHT).sum() == pytest.approx(5432, rel=0.02)  # Seidl & Kaiser 1981


def test_honeybee_angles_between_ommatidia_change_over_the_eye():
    eye = MADE["honeybee"]
    right = eye.directions[eye.side == RIGHT]
    azimuth, elevation = np.rad2deg(azimuth_elevation(right))
    row = np.abs(elevation) < 1e-9
    level = np.sort(azimuth[row])
    gap, middle = np.diff(level), (level[1:] + level[:-1]) / 2
    # Giger (1996): 3.7° ahead, 2.4° at 45°, 3.7° at 90°, 4.6° from 150° on.
    np.testing.assert_allclose(np.interp([0.0, 45.0, 90.0, 150.0], middle, gap), [3.7, 2.4, 3.7, 4.6], atol=0.1)
    heights = np.unique(np.round(elevation, 6))
    above = heights[heights > -1e-9]
    # Rows are half a step apart, which grows from 1.5° at the horizon to 4.5° at the pole.
    np.testing.assert_allclose(2 * np.diff(above), 1.5 + 3.0 * above[:-1] / 90.0, atol=1e-5)
    np.testing.assert_allclose(above[1:], -heights[heights < -1e-9][::-1], atol=1e-9)
    assert level.min() >= HONEYBEE.nasal_edge_deg
    assert level.max() <= HONEYBEE.temporal_edge_deg
    # More than 300° in both eyes together, Stürzl et al. 2010.
    assert level.max() > 150


def test_every_other_row_of_the_honeybee_is_shifted_by_half_an_angle():
    eye = MADE["honeybee"]
    azimuth, elevation = np.rad2deg(azimuth_elevation(eye.directions[eye.side == RIGHT]))
    heights = np.unique(np.round(elevation[elevation > -1e-9], 6))
    for number, height in enumerate(heights[:20]):
        row = azimuth[np.isclose(elevation, height, atol=1e-5)]
        least = np.abs(row).min()
        # Half of 3.7°, which takes more azimuth higher up.
        half = 3.7 / 2 / np.cos(np.deg2rad(height))
        assert least == pytest.approx(half if number % 2 else 0.0, abs=0.05 * half)


def test_honeybee_sees_zenith_and_nadir_and_rows_close():
    eye = MADE["honeybee"]
    right = eye.directions[eye.side == RIGHT]
    for pole in ([0, 0, 1], [0, 0, -1]):
        assert great_circle_angle(right, pole).min() < 3 * DEGREE
    azimuth, elevation = np.rad2deg(azimuth_elevation(right))
    for height in np.unique(np.round(elevation, 6)):
        if 72 < abs(height) < 86:
            row = np.sort(azimuth[np.isclose(elevation, height, atol=1e-5)])
            gaps = np.diff(np.append(row, row[0] + 360.0))
            assert gaps.max() < 2.2 * np.median(gaps)


def test_honeybee_types_occur_as_often_as_counted():
    eye = MADE["honeybee"]
    uv, blue, green = eye.has_band[(eye.side == RIGHT) & ~eye.is_dorsal_rim].T
    n = len(uv)
    for found, share in ((uv & blue, 0.44), (uv & ~blue, 0.46), (~uv & blue, 0.10)):
        assert abs(found.mean() - share) < 4 * np.sqrt(share * (1 - share) / n)
    assert green.all()
    np.testing.assert_array_equal(honeybee(seed=0).has_band, eye.has_band)
    assert (honeybee(seed=1).has_band != eye.has_band).any()
    assert eye.has_band[eye.is_dorsal_rim, 0].all()


def test_interommatidial_angle_of_a_known_lattice():
    n = 4000
    inner = interommatidial_angles(fibonacci(n).directions)
    assert np.mean(inner) == pytest.approx(np.sqrt(8 * np.pi / np.sqrt(3) / n), rel=0.08)
    ring = directions(np.arange(-1, 1.01, 0.1), 0.0)  # middle ones have neighbours at 1, 1, 2, 2, 3 and 3 steps
    np.testing.assert_allclose(interommatidial_angles(ring)[3:-3], 0.2, rtol=1e-12)


def test_own_eyes_of_any_directions():
    right = fibonacci(30, (0.0, 90.0)).directions
    eye = both_eyes("mine", right, np.full(30, 0.1), bands=("green",), is_rim=right[:, 2] > 0.9)
    assert eye.n_ommatidia == 60
    assert eye.has_band.all()
    assert eye.is_dorsal_rim.sum() == 2 * (right[:, 2] > 0.9).sum()
    # Towards the front the level e-vector is left and right; to the side it is ahead and behind.
    front = both_eyes("front", directions(0.0, 1.0)[None], [0.1], is_rim=[True])
    np.testing.assert_allclose(np.abs(front.e_vector), [[1, 0, 0], [1, 0, 0]], atol=1e-15)
    aside = both_eyes("aside", directions(np.pi / 2, 1.0)[None], [0.1], is_rim=[True])
    np.testing.assert_allclose(np.abs(aside.e_vector), [[0, 1, 0], [0, 1, 0]], atol=1e-15)
    with pytest.raises(ValueError, match="read-only"):
        eye.directions[0] = 1.0


GOOD = {
    "name": "one",
    "directions": [[0.0, 0, 1]],
    "acceptance": [0.1],
    "bands": ("uv",),
    "has_band": [[True]],
    "side": [1],
    "e_vector": [[1.0, 0, 0]],
}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"directions": [[0.0, 0, 2]]}, "directions has a vector of length 2"),
        ({"acceptance": [5.0]}, "acceptance reaches 5.*degrees"),
        ({"acceptance": 0.1}, "acceptance has shape"),
        ({"bands": ("red",)}, "band 'red' is unknown"),
        ({"has_band": [[True, False]]}, "has_band has shape"),
        ({"side": [0]}, "side holds other values than -1 and 1"),
        ({"e_vector": [[0.0, 0, 1]]}, "e_vector points along the line of sight"),
        ({"e_vector": [[2.0, 0, 0]]}, "e_vector has a vector of length 2"),
        ({"polarisation_sensitivity": 0.5}, "polarisation_sensitivity is 0.5"),
    ],
)
def test_impossible_eyes_are_refused_in_one_sentence(change: dict, message: str):
    assert CompoundEye(**GOOD).is_dorsal_rim.tolist() == [True]
    with pytest.raises(InputError, match=message) as caught:
        CompoundEye(**(GOOD | change))
    assert "\n" not in str(caught.value)


def test_too_few_ommatidia_are_refused():
    with pytest.raises(InputError, match="number of directions is 3, expected at least 7"):
        interommatidial_angles(np.eye(3))
    few = desert_ant(replace(MELOPHORUS_BAGOTI, n_ommatidia=20))
    assert few.n_ommatidia == 40
