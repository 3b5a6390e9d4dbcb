"""Bodies of triangles: closed, outward, and put where they belong."""

import numpy as np
import pytest

from insectnav.worlds.shapes import (
    GRID,
    ball,
    box,
    frustum,
    generator,
    joined,
    mesh_from,
    placed,
    quads,
    spikes,
    triangle_areas,
    upright_quads,
)


def enclosed_volume(triangles: np.ndarray) -> float:
    """Volume by the divergence theorem; positive if all faces look outwards, as far as faces through 0 are missing."""
    return float(np.linalg.det(triangles).sum() / 6)


@pytest.mark.parametrize(
    ("body", "volume"),
    [  # each lacks its floor on z = 0 only, through the origin: that adds nothing
        (box(2.0, 3.0, 4.0), 24.0),
        (frustum(4, 1.0, 0.0, 3.0), 2.0),
        (frustum(64, 1.0, 0.0, 3.0), np.pi * np.sin(2 * np.pi / 64) / (2 * np.pi / 64)),
        (ball(), 2.5361507),  # icosahedron of circumradius 1: (10 + 2√5) / … = 2.536 (tables)
    ],
)
def test_bodies_look_outwards_and_have_their_volume(body: np.ndarray, volume: float):
    assert enclosed_volume(body) == pytest.approx(volume, rel=1e-6)


def test_areas_of_a_right_triangle_and_of_rectangles():
    np.testing.assert_allclose(triangle_areas([[(0, 0, 0), (3, 0, 0), (0, 4, 0)]]), [6.0])
    assert triangle_areas(upright_quads([(0.0, 0.0, 1.0), (5.0, 5.0, 5.0)], 2.0, 1.5)).sum() == pytest.approx(6.0)
    assert len(quads(np.zeros((5, 7, 4, 3)))) == 70


def test_upright_rectangles_look_along_y():
    triangles = upright_quads([(0.0, 0.0, 1.0)], 2.0, 1.0)
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    np.testing.assert_allclose(normals / 2.0, [(0.0, 1.0, 0.0)] * 2, atol=1e-12)


def test_placing_turns_clockwise_and_moves():
    ahead = np.array([[(0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)]])
    east = placed(ahead, [(10.0, 20.0, 30.0)], np.pi / 2)[0, 0]
    np.testing.assert_allclose(east, [(11.0, 20.0, 30.0), (10.0, 19.0, 30.0), (10.0, 20.0, 31.0)], atol=1e-12)


def test_placing_many_is_placing_each():
    positions, headings = np.arange(12.0).reshape(4, 3), np.array([0.0, 1.0, -2.0, 3.0])
    together = placed(box(1.0, 2.0, 3.0), positions, headings)
    for k in range(4):
        np.testing.assert_array_equal(together[k], placed(box(1.0, 2.0, 3.0), positions[k], headings[k])[0])


def test_spikes_run_from_start_to_end():
    starts, ends = np.array([(0.0, 0.0, 0.0), (1.0, 1.0, 1.0)]), np.array([(0.0, 0.0, 2.0), (4.0, 1.0, 1.0)])
    triangles = spikes(starts, ends, np.array([0.1, 0.2])).reshape(2, 3, 3, 3)
    np.testing.assert_allclose(triangles[:, :, 2], np.repeat(ends[:, None], 3, axis=1))
    distance = np.linalg.norm(triangles[:, :, 0] - starts[:, None], axis=-1)
    np.testing.assert_allclose(distance, np.repeat([[0.1], [0.2]], 3, axis=1))
    assert np.linalg.det(triangles[0]).sum() / 6 == pytest.approx(2.0 / 3 * 0.75 * np.sqrt(3) * 0.01)  # outwards


def test_mesh_knows_the_material_of_each_triangle_and_lies_on_the_grid():
    parts = [
        ("brick", box(1.0, 1.0, 1.0)),
        ("tiles", ball() + 5.0),
        ("brick", box(2.0, 2.0, 2.0)),
        ("leaves", joined([])),
    ]
    mesh = mesh_from(parts, "test")
    assert mesh.materials == ("brick", "tiles")
    assert np.bincount(mesh.material).tolist() == [20, 20]
    np.testing.assert_array_equal(mesh.vertices / GRID, np.round(mesh.vertices / GRID))


def test_mesh_leaves_out_what_the_grid_flattens():
    mesh = mesh_from([("brick", box(1.0, 1.0, 1.0)), ("leaves", 1e-6 * ball())], "test")
    assert mesh.n_triangles == 10


def test_random_numbers_follow_from_seed_and_purpose():
    draws = {(seed, name): generator(seed, name).random(3).tolist() for seed in (0, 1) for name in ("a", "b")}
    assert draws[0, "a"] == generator(0, "a").random(3).tolist()
    assert len({tuple(draw) for draw in draws.values()}) == 4
