"""Angles of rotations, against SciPy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from insectnav.checks import InputError
from insectnav.matching import RotationMatches, rotation_angles, rotation_between
from insectnav.vision import rotation_matrix

HALF_TURN, QUARTER = st.floats(-3.1, 3.1), st.floats(-1.5, 1.5)


@given(HALF_TURN, QUARTER, HALF_TURN)
def test_angles_are_those_that_made_the_rotation(heading, pitch, roll):
    assert_allclose(rotation_angles(rotation_matrix(heading, pitch, roll)), [heading, pitch, roll], atol=1e-9)


@pytest.mark.parametrize("pitch", [-np.pi / 2, np.pi / 2])
def test_an_eye_that_looks_straight_up_or_down_keeps_its_rotation(pitch):
    rotation = rotation_matrix(0.7, pitch, -0.4)
    assert_allclose(rotation_matrix(*rotation_angles(rotation)), rotation, atol=1e-7)


def test_angle_between_rotations_is_that_of_scipy():
    first, second = Rotation.random(50, random_state=1), Rotation.random(50, random_state=2)
    expected = (first.inv() * second).magnitude()
    assert_allclose(rotation_between(first.as_matrix(), second.as_matrix()), expected, atol=1e-7)
    tiny = rotation_matrix(1e-9) @ first.as_matrix()
    assert_allclose(rotation_between(tiny, first.as_matrix()), 1e-9, rtol=1e-3)


def test_a_match_gives_its_angles_and_its_tilt():
    rotation = np.stack([rotation_matrix(0.5), rotation_matrix(-2.0, 0.3), rotation_matrix(1.0, -0.2, 0.6)])
    zeros = np.zeros(3)
    match = RotationMatches(
        reference=zeros.astype(int),
        rotation=rotation,
        score=zeros,
        runner_up=zeros.astype(int),
        ratio=zeros,
        overlap=zeros,
    )
    assert_allclose(match.heading, [0.5, -2.0, 1.0])
    assert_allclose(match.pitch, [0.0, 0.3, -0.2], atol=1e-12)
    assert_allclose(match.roll, [0.0, 0.0, 0.6], atol=1e-12)
    assert_allclose(match.tilt, [0.0, 0.3, np.arccos(np.cos(0.2) * np.cos(0.6))], atol=1e-12)


@pytest.mark.parametrize(
    ("rotation", "sentence"),
    [
        (np.eye(4), r"rotation has shape \(4, 4\), expected \(\.\.\., 3, 3\)"),
        (np.full((3, 3), np.nan), "rotation is nan at index 0, 0"),
    ],
)
def test_what_is_no_rotation_is_refused(rotation, sentence):
    with pytest.raises(InputError, match=sentence):
        rotation_angles(rotation)
