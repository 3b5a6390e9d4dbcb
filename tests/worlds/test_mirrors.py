"""Mirrors by a second ray: water before a wall, and reflectances of one's own."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from insectnav.checks import InputError
from insectnav.worlds import light_world, render
from insectnav.worlds.lit_world import Grain
from insectnav.worlds.materials import MATERIALS, mirror_fraction
from insectnav.worlds.shapes import mesh_from, quads
from insectnav.worlds.sky import Sky

BANDS = ("uv", "blue", "green", "red")
SKY = Sky(sun_azimuth=np.pi, sun_elevation=0.7)
WATER = quads([[(-20.0, -5.0, 0.0), (20.0, -5.0, 0.0), (20.0, 20.0, 0.0), (-20.0, 20.0, 0.0)]])
WALL = quads([[(20.0, 20.0, 0.0), (-20.0, 20.0, 0.0), (-20.0, 20.0, 9.0), (20.0, 20.0, 9.0)]])
MESH = mesh_from([("water", WATER), ("brick", WALL)], "pond before a wall")
DULL = {**MATERIALS, "water": replace(MATERIALS["water"], refractive_index=1.0)}


def seen(world, position, direction) -> np.ndarray:
    """Radiance (band,) along one ray."""
    unit = np.asarray(direction) / np.linalg.norm(direction)
    layers = render(world, [position], directions=unit[None], layers=BANDS)
    return np.array([layers[band][0, 0] for band in BANDS])


@pytest.mark.parametrize("fall", [0.7, 0.15])  # what is mirrored: sky above the wall, wall
def test_water_shows_what_stands_behind_it_by_fresnel(fall: float):
    lit = light_world(MESH, SKY, grain=Grain(contrast=0.0))
    dull = light_world(MESH, SKY, grain=Grain(contrast=0.0), materials=DULL)
    eye, down, up = np.array([0.0, 0.0, 1.5]), np.array([0.0, 1.0, -fall]), np.array([0.0, 1.0, fall])
    met = eye + down * eye[2] / fall
    share = mirror_fraction("water", fall / np.hypot(1.0, fall))
    behind = seen(lit, met + np.array([0.0, 0.0, 1e-3]), up)
    assert_allclose(seen(lit, eye, down), seen(dull, eye, down) + share * behind, rtol=2e-3)


def test_reflectances_of_ones_own_change_what_is_seen_in_proportion():
    bright = {**MATERIALS, "brick": replace(MATERIALS["brick"], diffuse=(0.224, 0.234, 0.268, 0.548))}
    wall = mesh_from([("brick", WALL)], "wall")
    plain, own = (
        seen(
            light_world(wall, SKY, shadows=False, materials=known, extent=[[-9.0, -9.0], [9.0, 9.0]]),
            [0.0, 0.0, 1.5],
            [0.0, 1.0, 0.1],
        )
        for known in (MATERIALS, bright)
    )
    assert_allclose(own, 2.0 * plain, rtol=1e-5)


def test_a_material_that_is_not_among_ones_own_is_refused():
    with pytest.raises(InputError, match="brick"):
        light_world(MESH, SKY, materials={"water": MATERIALS["water"], "soil": MATERIALS["soil"]})
