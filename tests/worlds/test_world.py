"""What a world is made of, and what is none."""

import dataclasses
import os
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.records import Mesh
from insectnav.worlds import World, flat_world, load_world, render_panorama
from insectnav.worlds.builders import build_world
from insectnav.worlds.world import check_positions
from solid_shapes import box, soup

DATA = Path(os.environ.get("INSECTNAV_DATA") or Path(__file__).resolve().parents[3] / "shared" / "data")


def a_world(**changes) -> World:
    fields = {
        "mesh": Mesh(vertices=box(0, 0, 2, 2)),
        "brightness": {"uv": 0.1, "green": np.linspace(0, 1, 10)},
        "sky": {"uv": 1.0, "green": 0.5},
        "ground": {"uv": 0.05, "green": 0.1},
    }
    return World(**(fields | changes))


def test_one_number_stands_for_all_triangles_and_arrays_are_copies():
    world = a_world()
    assert world.bands == ("uv", "green")
    assert_array_equal(world.brightness["uv"], np.full(10, np.float32(0.1)))
    for array in (*world.brightness.values(), world.corners, world.extent):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    with pytest.raises(dataclasses.FrozenInstanceError):
        world.sky = {}


def test_extent_is_that_of_the_mesh_unless_given():
    assert_array_equal(a_world().extent, [[-1, -1], [1, 1]])
    assert_array_equal(a_world(extent=((-5, -4), (5, 4))).extent, [[-5, -4], [5, 4]])


def test_published_greys():
    world = flat_world(Mesh(vertices=box(0, 0, 2, 2)))
    assert world.brightness["grey"][0] == np.float32(64 / 255)
    assert (world.sky["grey"], world.ground["grey"]) == (1.0, 0.1)
    grey = np.linspace(0.2, 0.9, 10)
    own = flat_world(Mesh(vertices=box(0, 0, 2, 2), grey=grey))
    assert_allclose(own.brightness["grey"], grey, rtol=1e-6)
    assert flat_world(own.mesh, plants=0.3).brightness["grey"][3] == np.float32(0.3)


def test_a_world_from_a_file_is_that_of_its_mesh(tmp_path):
    triangles = soup(1, 50)
    np.savez(tmp_path / "scrub.npz", vertices=triangles, grey=np.linspace(0, 1, 50))
    world = load_world(tmp_path / "scrub.npz", sky=0.9)
    assert (world.mesh.name, world.mesh.n_triangles, world.sky["grey"]) == ("scrub", 50, 0.9)
    assert_allclose(world.brightness["grey"], np.linspace(0, 1, 50), rtol=1e-6)
    same = flat_world(Mesh(vertices=triangles, grey=np.linspace(0, 1, 50)), sky=0.9)
    assert_array_equal(render_panorama(world, [[0, 0]], 0.0), render_panorama(same, [[0, 0]], 0.0))
    assert load_world(same.mesh).mesh is same.mesh


def test_a_built_world_by_name_has_the_flat_greys_of_its_materials():
    mesh = build_world("ant-world", seed=3, tree_density=0.0).mesh
    world = load_world("ant-world", seed=3, tree_density=0.0)
    assert_array_equal(world.mesh.vertices, mesh.vertices)
    is_sand = mesh.material == mesh.materials.index("sand")
    assert_array_equal(world.brightness["grey"], np.where(is_sand, np.float32(0.1), np.float32(64 / 255)))


@pytest.mark.data
@pytest.mark.skipif(not DATA.is_dir(), reason=f"no folder {DATA}")
@pytest.mark.parametrize(
    ("name", "n_triangles", "n_below"),
    [("antworld_clearing_stone2018.npz", 3222, 0), ("antworld_seville2009.npz", 5000, 131)],
)
def test_public_ant_worlds(name, n_triangles, n_below):
    mesh = load_world(DATA / name).mesh
    assert mesh.n_triangles == n_triangles
    assert mesh.bounds[0, 2] >= 0
    assert [note.rpartition(": ")[2] for note in mesh.notes] == ([str(n_below)] if n_below else [])


def test_positions_get_the_height_of_an_ant():
    assert_array_equal(check_positions(a_world(), [[0.5, -1]]), [[0.5, -1, 0.01]])
    assert_array_equal(check_positions(a_world(), [[1, 1, 3]]), [[1, 1, 3]])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"brightness": {}}, "the world has no bands"),
        ({"brightness": {"red": 0.1}}, "band of the sky 'red' is unknown: expected one of uv, green"),
        ({"ground": {"uv": 0.1}}, "band of the ground 'green' is unknown: expected one of uv"),
        ({"brightness": {"uv": 64}}, "brightness in uv is 64, expected 0 to 1: in 0 to 255?"),
        ({"brightness": {"uv": np.full(9, 0.1)}}, "brightness in uv has shape (9,), expected (10,)"),
        ({"brightness": {"uv": [0.1] * 9 + [np.nan]}}, "brightness in uv reaches nan"),
        ({"sky": {"uv": 2.0, "green": 1}}, "brightness of the sky is 2, expected 0 to 1"),
        ({"extent": (1, 2)}, "extent has shape (2,), expected (2, 2)"),
        ({"extent": ((0, 0), (np.inf, 0))}, "extent is inf at index 1, 0"),
    ],
)
def test_what_is_no_world_is_refused(changes, words):
    with pytest.raises(InputError) as caught:
        a_world(**changes)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("source", "options", "words"),
    [
        ("ant-word", {}, "world without the ending of a file 'ant-word' is unknown: expected one of ant-world, "),
        ("ant-word", {}, "(did you mean ant-world?)"),
        ("world.stl", {}, "'world.stl' is no mesh, expected a file that ends in .npz, .obj, .ply, .glb"),
        ("missing.npz", {}, "'missing.npz': there is no such file"),
        ("missing.npz", {"seed": 3}, "option 'seed' is unknown: expected one of up, metres_per_unit"),
        ("ant-world", {"tree_densty": 1}, "did you mean tree_density?"),
    ],
)
def test_what_cannot_be_loaded_is_refused(source, options, words):
    with pytest.raises(InputError) as caught:
        load_world(source, **options)
    assert words in str(caught.value)
