"""Rays along any directions: tilt and turn, values by hand, bad input."""

import builtins

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.vision.sphere import equirectangular, rotation_matrix, to_world
from insectnav.worlds import render
from solid_shapes import box, quad, soup, wall, world_of

AHEAD, RIGHT, UP = (0, 1, 0), (1, 0, 0), (0, 0, 1)


def test_values_along_single_rays():
    world = world_of(wall(-5, 2, 5, 2, 3))
    directions = np.array([AHEAD, (0, -1, 0), UP, (0, 0.6, 0.8), (0, 0, -1)])
    got = render(world, [[0, 0, 1.0]], 0.0, directions=directions, layers=("grey", "depth", "nearness", "triangle"))
    assert_array_equal(got["grey"][0], np.float32([64 / 255, 1, 1, 1, 0.1]))
    assert_allclose(got["depth"][0], [2, np.inf, np.inf, np.inf, 1], rtol=1e-6)
    assert_allclose(got["nearness"][0], [0.5, 0, 0, 0, 1], rtol=1e-6)
    assert got["triangle"][0, 0] in (0, 1)
    assert_array_equal(got["triangle"][0, 1:], [-1, -1, -1, -2])


@pytest.mark.parametrize(
    ("pose", "direction", "seen"),
    [  # a sign to the north (+y) of the eye
        ((0, 0, 0), AHEAD, True),
        ((np.pi / 2, 0, 0), AHEAD, False),
        ((-np.pi / 2, 0, 0), RIGHT, True),
        ((0, np.pi / 2, 0), (0, 0, -1), True),  # nose up: the belly looks ahead
        ((np.pi, -np.pi / 2, 0), (0, 0, -1), True),  # nose down: it looks back
        ((0, -np.pi / 2, 0), (0, 0, -1), False),
        ((-np.pi / 2, 0, 0.3), RIGHT, False),  # right side down
        ((-np.pi / 2, 0, 0.3), (np.cos(0.3), 0, np.sin(0.3)), True),
    ],
)
def test_turn_pitch_and_roll(pose, direction, seen):
    sign = quad((-0.2, 2, 0.81), (0.21, 2, 0.81), (0.21, 2, 1.22), (-0.2, 2, 1.22))
    heading, pitch, roll = pose
    got = render(world_of(sign), [[0, 0, 1.0]], heading, pitch, roll, directions=direction, layers=("alpha",))
    assert got["alpha"].shape == (1,)
    assert bool(got["alpha"][0]) is seen


def test_tilting_the_eye_is_turning_its_directions():
    world, rng = world_of(soup(2)), np.random.default_rng(1)
    look = equirectangular(10.0).directions
    heading, pitch, roll = rng.uniform(-1, 1, (3, 4))
    positions = np.column_stack([rng.uniform(-3, 3, (4, 2)), np.full(4, 0.3)])
    tilted = render(world, positions, heading, pitch, roll, directions=look, layers=("grey",))["grey"]
    for i in range(4):
        turned = to_world(look, rotation_matrix(heading[i], pitch[i], roll[i]))
        level = render(world, positions[i : i + 1], 0.0, directions=turned, layers=("grey",))["grey"][0]
        assert (tilted[i] != level).mean() < 0.01  # directions are rounded once more


def test_shape_follows_the_directions():
    world, look = world_of(soup(2)), equirectangular(30.0).directions.reshape(6, 12, 3)
    views = render(world, np.zeros((5, 2)), 0.0, directions=look, layers=("grey",))["grey"]
    assert (views.shape, views.dtype) == ((5, 6, 12), np.float32)
    assert_array_equal(views[3], render(world, [[0, 0]], 0.0, directions=look, layers=("grey",))["grey"][0])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"directions": [(0, 0, 2.0)]}, "directions"),
        ({"directions": [(0, 1)]}, "directions"),
        ({"layers": ("uv",)}, "layer 'uv' is unknown: expected one of grey"),
        ({"pitch": [0.0, 0.0]}, "pitch has shape (2,), expected (1,)"),
        ({"roll": 45}, "roll is 45, expected radians within ±2π: degrees?"),
        ({"headings": np.nan}, "headings is nan"),
        ({"positions": [[9.1, 9.2]]}, "position 0 at (9.1, 9.2, 0.01) m is inside a solid"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(changes, words):
    arguments = {"positions": [[0, 0]], "headings": 0.0, "directions": [AHEAD, UP], "layers": ("grey",)} | changes
    with pytest.raises(InputError) as caught:
        render(world_of(box(9, 9, 2, 2)), **arguments)
    assert words in str(caught.value)


def test_without_embreex_the_sentence_says_how_to_get_it(monkeypatch):
    real_import = builtins.__import__

    def refuse(name, *arguments, **options):
        if name.startswith("embreex"):
            raise ImportError(name)
        return real_import(name, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", refuse)
    with pytest.raises(InputError, match=r"rays need the package embreex.*insectnav\[rays\]"):
        render(world_of(soup(1, 9)), [[0, 0]], 0.0, directions=[AHEAD], layers=("grey",))
