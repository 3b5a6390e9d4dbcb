"""The Mesh record: what is kept, what is left out, what is refused."""

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from insectnav.checks import InputError
from insectnav.records import Mesh
from solid_shapes import box, soup


def a_mesh(**changes) -> Mesh:
    return Mesh(**({"vertices": box(1, 2, 2, 3)} | changes))


def test_size_bounds_and_defaults():
    mesh = a_mesh()
    assert mesh.n_triangles == 10
    assert_array_equal(mesh.bounds, [[0, 1, 0], [2, 3, 3]])
    assert_array_equal(mesh.material, np.zeros(10))
    assert (mesh.materials, mesh.grey, mesh.notes) == (("plant",), None, ())


def test_arrays_are_copies_that_cannot_be_written():
    vertices, grey = soup(1, 10).astype(np.float32), np.full(10, 0.5, np.float32)
    mesh = a_mesh(vertices=vertices, grey=grey, material=np.arange(10, dtype=np.int32) % 2, materials=("leaf", "bark"))
    first = vertices[0].copy()
    vertices[0], grey[0] = -9, 0
    assert_array_equal(mesh.vertices[0], first)
    assert mesh.grey[0] == 0.5
    for array in (mesh.vertices, mesh.material, mesh.grey):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    with pytest.raises(dataclasses.FrozenInstanceError):
        mesh.name = "other"


def test_triangles_without_area_are_left_out_and_counted():
    vertices = box(0, 0, 2, 2)
    vertices[3] = vertices[3, 0]  # a point
    vertices[7, 2] = (vertices[7, 0] + vertices[7, 1]) / 2  # a line
    mesh = a_mesh(vertices=vertices, grey=np.arange(10) / 10, material=np.arange(10), materials=tuple("abcdefghij"))
    kept = [0, 1, 2, 4, 5, 6, 8, 9]
    assert_array_equal(mesh.vertices, vertices[kept].astype(np.float32))
    assert_array_equal(mesh.material, kept)
    assert_array_equal(mesh.grey, np.float32(kept) / np.float32(10))
    assert mesh.notes == ("triangles without area were left out: 2",)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_a_narrow_blade_of_any_size_is_kept(size):
    blade = size * np.array([[[0, 0, 0], [1e-3, 0, 0], [0.1, 0.2, 1]]])
    assert Mesh(vertices=blade).n_triangles == 1


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"vertices": np.zeros((0, 3, 3))}, "the mesh has 0 triangles, expected 1 to 5000000"),
        ({"vertices": np.zeros((4, 3))}, "vertices has shape (4, 3), expected (triangle, 3, 3)"),
        ({"vertices": np.ones((4, 3, 3))}, "no triangle of the mesh has an area"),
        ({"vertices": np.where(np.arange(9) == 5, np.nan, 1.0).reshape(1, 3, 3)}, "vertices is nan at index 0, 1, 2"),
        ({"vertices": 5000 * box(0, 0, 2, 2)}, "vertices reaches 10000, expected -4000 to 4000 m: not in metres"),
        ({"vertices": [["a"]]}, "expected real numbers"),
        ({"material": np.zeros(9, int)}, "material has shape (9,), expected (10,)"),
        ({"material": np.zeros(10)}, "material holds fractions"),
        ({"material": np.arange(10)}, "material reaches 9, expected 0 to 0: a material without a name?"),
        ({"grey": np.full(10, 64)}, "grey reaches 64, expected 0 to 1: in 0 to 255?"),
        ({"grey": np.full(9, 0.5)}, "grey has shape (9,), expected (10,)"),
    ],
)
def test_what_is_no_mesh_is_refused(changes, words):
    with pytest.raises(InputError) as caught:
        a_mesh(**changes)
    assert words in str(caught.value)
