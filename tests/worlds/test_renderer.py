"""Panoramas against pictures made by others, against rays, closed forms and symmetries."""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.vision.sphere import equirectangular
from insectnav.worlds import World, flat_world, load_world, render, render_layers, render_panorama
from solid_shapes import EVERYWHERE, box, quad, soup, sphere, turned, wall, world_of

DATA = Path(os.environ.get("INSECTNAV_DATA") or Path(__file__).resolve().parents[3] / "shared" / "data")
ANT_WORLDS = {"clearing": "antworld_clearing_stone2018.npz", "seville": "antworld_seville2009.npz"}
ALL_LAYERS = ("grey", "sky", "alpha", "nearness", "depth", "triangle")
WHOLE = (-90.0, 90.0)
seeds = st.integers(0, 2**32 - 1)


def ant_world(name: str) -> World:
    path = DATA / ANT_WORLDS[name]
    if not path.exists():
        pytest.skip(f"{path} is missing")
    world = load_world(path)
    if world.mesh.grey is not None:  # the golden views show plants at 0.6 of the file's grey
        world = flat_world(world.mesh, plants=np.float32(0.6) * world.mesh.grey)
    return world


# Pictures made by others.


@pytest.mark.data
@pytest.mark.parametrize("name", ["clearing", "seville"])
def test_golden_views_pixel_by_pixel(name, golden):
    outside = golden("ant_world_views")
    views = render_panorama(ant_world(name), outside["positions"], np.pi / 2, supersampling=1)
    off = np.rint(255 * views) != outside[f"{name}_AA1_views"]
    assert off.mean() <= 0.001


@pytest.mark.data
@pytest.mark.parametrize("name", ["clearing", "seville"])
def test_golden_views_supersampled(name, golden):
    outside = golden("ant_world_views")
    views = render_panorama(ant_world(name), outside["positions"], np.pi / 2)
    assert np.abs(255 * views - outside[f"{name}_AA4_views"]).mean() < 0.5


@pytest.mark.data
@pytest.mark.parametrize("name", ["clearing", "seville"])
def test_ant_worlds_equal_embree(name):
    rng = np.random.default_rng(3)
    assert_equals_embree(ant_world(name), rng.uniform(1, 9, (6, 2)), rng.uniform(-np.pi, np.pi, 6))


# The same by rays.


def assert_equals_embree(world, positions, headings, share_off=1e-4):
    """Equal but for samples that an edge passes within rounding; distances to single precision."""
    grid = equirectangular(1.0, (-15.0, 90.0))
    ours = render_layers(world, positions, headings, ALL_LAYERS)
    rays = render(world, positions, headings, directions=grid.directions.reshape(105, 360, 3), layers=ALL_LAYERS)
    same = ours["triangle"] == rays["triangle"]
    is_tie = np.isclose(ours["depth"], rays["depth"], rtol=1e-5)  # two triangles in one place
    assert (~same & ~is_tie).mean() <= share_off
    for layer in ("grey", "sky", "alpha"):
        assert_array_equal(ours[layer][same], rays[layer][same])
    for layer in ("nearness", "depth"):
        assert_allclose(ours[layer][same], rays[layer][same], rtol=2e-4)


@pytest.mark.parametrize("seed", range(4))
def test_random_triangles_equal_embree(seed):
    rng = np.random.default_rng(seed)
    world = world_of(soup(seed), plants=rng.uniform(0, 1, 300))
    positions = np.column_stack([rng.uniform(-8, 8, (5, 2)), rng.uniform(0.01, 3, 5)])
    assert_equals_embree(world, positions, rng.uniform(-np.pi, np.pi, 5))


# Closed forms.


def pixel_angles(rows=105, top=90.0):
    azimuth = np.deg2rad(np.arange(360) + 0.5 - 180)[None]
    return azimuth, np.deg2rad(top - (np.arange(rows) + 0.5))[:, None]


def test_depth_of_a_wall_in_closed_form():
    world = world_of(wall(-40, 2, 40, 2, 3))
    azimuth, elevation = pixel_angles()
    got = render_layers(world, [[0.0, 0.0, 1.0]], 0.0, ("depth", "alpha"))
    across = 2 / np.where(np.cos(azimuth) > 0, np.cos(azimuth), np.nan)  # horizontal distance
    height = 1 + across * np.tan(elevation)
    is_wall = (np.abs(across * np.sin(azimuth)) < 40) & (height > 0) & (height < 3)
    assert_array_equal(got["alpha"][0], is_wall)
    assert_allclose(got["depth"][0][is_wall], (across / np.cos(elevation))[is_wall], rtol=1e-6)


def test_ground_is_a_plane_and_the_sky_is_far():
    got = render_layers(world_of(box(9, 9, 1, 0.1)), [[0.0, 0.0, 0.25]], 0.0, ("nearness", "depth", "triangle", "grey"))
    _, elevation = pixel_angles()
    is_free = got["triangle"][0] < 0
    ground, sky = np.broadcast_to(elevation < 0, (105, 360)) & is_free, np.broadcast_to(elevation > 0, (105, 360))
    expected = np.broadcast_to(0.25 / np.sin(np.abs(elevation)), (105, 360))
    assert_allclose(got["depth"][0][ground], expected[ground], rtol=1e-6)
    assert_allclose(got["nearness"][0][ground], 1 / expected[ground], rtol=1e-6)
    assert np.isinf(got["depth"][0][sky & is_free]).all()
    assert (got["nearness"][0][sky & is_free] == 0).all()
    assert set(np.unique(got["triangle"][0][ground])) == {-2}
    assert set(np.unique(got["triangle"][0][sky & is_free])) == {-1}
    assert_array_equal(got["grey"][0][ground], np.float32(0.1))
    assert_array_equal(got["grey"][0][sky & is_free], np.float32(1))


@pytest.mark.parametrize(
    ("x", "y", "heading_deg", "column"),
    [
        (0, 5, 0, 180),
        (5, 0, 90, 180),
        (5, 0, 0, 270),
        (-5, 0, 0, 90),
        (0, 5, 90, 90),
        (3, 3, 45, 180),
        (0, -5, 179, 181),
    ],
)
def test_a_post_stands_where_it_should(x, y, heading_deg, column):
    world = world_of(box(x, y, 0.5, 2))
    view = render_panorama(world, [[0, 0]], [np.deg2rad(heading_deg)], supersampling=1)[0]
    seen = np.flatnonzero((view == np.float32(64 / 255)).any(axis=0))
    assert (seen.min() + seen.max() + 1) / 2 == pytest.approx(column, abs=1)


def test_the_nearer_hides_the_farther_in_any_order():
    near, far = wall(-1, 2, 1, 2, 1), wall(-5, 4, 5, 4, 1)
    for order in ((near, far), (far, near)):
        values = np.repeat([0.3 if order[0] is near else 0.6, 0.6 if order[0] is near else 0.3], 2)
        view = render_panorama(world_of(*order, plants=values), [[0, 0]], 0.0, supersampling=1)[0]
        assert view[85, 180] == np.float32(0.3)  # 4.5° up: over 1 m at 4 m distance is 14°
        assert view[85, 180 + 40] == np.float32(0.6)


# Symmetries.


@settings(max_examples=20, deadline=None)
@given(seeds, st.integers(-180, 180), st.sampled_from([1, 2]))
def test_turning_the_eye_by_whole_pixels_turns_the_picture(seed, pixels, supersampling):
    world = world_of(soup(seed, 40))
    views = render_panorama(world, np.zeros((2, 2)), np.deg2rad([0.0, pixels]), supersampling=supersampling)
    assert_array_equal(views[1], np.roll(views[0], -pixels, axis=-1))


@settings(max_examples=20, deadline=None)
@given(seeds, st.floats(-np.pi, np.pi))
def test_turning_the_world_with_the_eye_changes_nothing(seed, angle):
    triangles = soup(seed, 60)
    here = render_layers(world_of(triangles), [[0, 0]], 0.0, ("triangle",), elevation_deg=WHOLE)["triangle"]
    there = render_layers(world_of(turned(triangles, angle)), [[0, 0]], angle, ("triangle",), elevation_deg=WHOLE)
    # An edge moves by the rounding of its corners, 1e-6 rad at most: with 300 edges of a radian 5e-6 of all pixels.
    assert (here != there["triangle"]).mean() < 3e-4


@settings(max_examples=10, deadline=None)
@given(seeds, st.floats(-np.pi, np.pi))
def test_a_mirrored_world_gives_a_mirrored_picture(seed, heading):
    triangles = soup(seed, 60)
    here = render_layers(world_of(triangles), [[0, 0]], heading, ("triangle",))["triangle"]
    there = render_layers(world_of(triangles * [-1, 1, 1]), [[0, 0]], -heading, ("triangle",))["triangle"]
    assert (here != there[..., ::-1]).mean() < 3e-4


@settings(max_examples=10, deadline=None)
@given(seeds, st.floats(0.1, 10))
def test_a_scaled_world_looks_the_same(seed, factor):
    triangles, eye = soup(seed, 60), np.array([[0.3, -0.2, 0.5]])
    here = render_layers(world_of(triangles), eye, 0.0, ("triangle", "nearness"))
    there = render_layers(world_of(factor * triangles), factor * eye, 0.0, ("triangle", "nearness"))
    same = here["triangle"] == there["triangle"]
    assert (~same).mean() < 3e-4
    assert_allclose(factor * there["nearness"][same], here["nearness"][same], rtol=1e-3)


# Seam and poles.


@settings(max_examples=15, deadline=None)
@given(
    st.integers(2, 9), st.integers(3, 12), st.floats(-np.pi, np.pi), st.floats(-np.pi, np.pi),
    st.floats(-0.4, 0.4), st.floats(-0.4, 0.4),
)  # fmt: skip
def test_a_sphere_round_the_eye_has_no_hole(n_rings, n_sectors, turn, pitch, x, y):
    assert_no_hole(turned(sphere(n_rings, n_sectors, 2.0), turn, pitch), [[x, y, 0.1]], turn)


@pytest.mark.parametrize("n_sectors", [3, 4, 8, 45, 72, 360])
def test_corners_and_edges_exactly_at_the_poles_and_in_columns_leave_no_hole(n_sectors):
    assert_no_hole(sphere(6, n_sectors, 2.0), [[0.0, 0.0, 0.01]], 0.0)
    assert_no_hole(turned(sphere(6, n_sectors, 2.0), np.pi / 360), [[0.0, 0.0, 0.01]], 0.0)


def assert_no_hole(shell, eye, heading):
    """Nothing behind the shell is seen; a second one round it makes its inside a place where one may be."""
    world = world_of(shell, sphere(8, 8, 9.0))
    assert world.mesh.notes == ()
    seen = render_layers(world, eye, heading, ("triangle", "sky"), elevation_deg=WHOLE)
    assert seen["triangle"].min() >= 0
    assert seen["triangle"].max() < len(shell)
    assert (seen["sky"] == 0).all()


def test_the_seam_is_a_column_like_any_other():
    """A wall due south of the eye, behind it, looks as one due north before it."""
    north = render_panorama(world_of(soup(5, 80)), [[0, 0]], 0.0)
    south = render_panorama(world_of(turned(soup(5, 80), np.pi)), [[0, 0]], 0.0)
    assert (np.abs(np.roll(north, 180, axis=-1) - south) > 1e-6).mean() < 1e-3


def test_a_roof_over_the_eye_fills_the_zenith():
    roof = quad((-1, -1, 2), (1, -1, 2), (1, 1, 2), (-1, 1, 2))
    got = render_layers(world_of(roof), [[0.2, -0.3, 1.0]], 0.7, ("alpha", "depth"))
    assert (got["alpha"][0, :20] == 1).all()  # the nearest side is at 0.7 m: 35° from the zenith
    _, elevation = pixel_angles()
    assert_allclose(got["depth"][0, :20], np.broadcast_to(1 / np.sin(elevation[:20]), (20, 360)), rtol=1e-5)


@pytest.mark.parametrize("resolution_deg", [1.0, 5.0, 8.0])  # at 8° the middle of a column lies straight ahead
def test_a_wall_seen_edge_on_is_not_seen(resolution_deg):
    options = {"resolution_deg": resolution_deg, "elevation_deg": (-40, 80), "supersampling": 1}
    edge_on = world_of(wall(0, 1, 0, 3, 1), wall(0, -3, 0, -1, 1), wall(1, 0, 3, 0, 1))
    assert (render_layers(edge_on, [[0, 0]], 0.0, ("alpha",), **options)["alpha"] == 0).all()


# Supersampling and layers.


@pytest.mark.parametrize("supersampling", [2, 4, 8])
def test_supersampling_is_the_mean_of_finer_pixels(supersampling):
    world = world_of(soup(7), plants=np.linspace(0, 1, 300))
    layers = ("grey", "sky", "alpha", "nearness")
    coarse = render_layers(world, [[0.1, 0.2]], 0.3, layers, resolution_deg=3.0, supersampling=supersampling)
    fine = render_layers(world, [[0.1, 0.2]], 0.3, layers, resolution_deg=3.0 / supersampling)
    for layer in layers:
        blocks = fine[layer].astype(float).reshape(35, supersampling, 120, supersampling)
        assert_allclose(coarse[layer][0], blocks.mean(axis=(1, 3)), rtol=1e-5, atol=1e-6)


def test_sky_mask_is_what_alpha_leaves_above_the_horizon():
    got = render_layers(world_of(soup(8)), [[0, 0]], 0.3, ALL_LAYERS, supersampling=4)
    _, elevation = pixel_angles()
    above = np.broadcast_to(elevation > 0, (1, 105, 360))
    assert_allclose(got["sky"][above], 1 - got["alpha"][above], atol=1e-6)
    assert (got["sky"][~above] == 0).all()
    assert_allclose(1 / got["depth"], got["nearness"], rtol=1e-6)
    single = render_layers(world_of(soup(8)), [[0, 0]], 0.3, ALL_LAYERS)
    assert_array_equal(single["sky"], single["triangle"] == -1)
    assert_array_equal(single["alpha"], single["triangle"] >= 0)


def test_layers_come_alone_as_together_and_by_name():
    world = World(
        mesh=world_of(soup(9)).mesh,
        brightness={"uv": 0.04, "green": np.linspace(0, 1, 300)},
        sky={"uv": 1.0, "green": 0.6},
        ground={"uv": 0.03, "green": 0.2},
    )
    together = render_layers(world, [[0, 0]], 0.0, ("uv", "depth", "green", "triangle", "sky", "alpha"))
    assert list(together) == ["uv", "depth", "green", "triangle", "sky", "alpha"]
    for layer, picture in together.items():
        assert_array_equal(render_layers(world, [[0, 0]], 0.0, (layer,))[layer], picture)
    assert_array_equal(render_panorama(world, [[0, 0]], 0.0, band="uv", supersampling=1), together["uv"])
    values = np.append(np.linspace(0, 1, 300), [0.2, 0.6]).astype(np.float32)
    assert_array_equal(together["green"], values[together["triangle"]])


# Batches.


def test_batch_equals_loop_with_any_number_of_threads():
    world, rng = world_of(soup(10)), np.random.default_rng(0)
    positions, headings = rng.uniform(-8, 8, (75, 2)), rng.uniform(-np.pi, np.pi, 75)
    options = {"resolution_deg": 3.0, "supersampling": 2}
    expected = render_panorama(world, positions, headings, workers=1, **options)
    for workers in (2, 3, None):
        assert_array_equal(render_panorama(world, positions, headings, workers=workers, **options), expected)
    for i in (0, 31, 32, 74):
        assert_array_equal(render_panorama(world, positions[i : i + 1], headings[i], **options)[0], expected[i])


def test_progress_counts_all_views():
    finished = []
    render_panorama(world_of(soup(1, 9)), np.zeros((70, 2)), 0.0, resolution_deg=15.0, progress=finished.append)
    assert sum(finished) == 70


def test_shapes_and_kinds():
    world = world_of(soup(1, 9))
    assert render_panorama(world, np.zeros((0, 2)), np.zeros(0)).shape == (0, 105, 360)
    view = render_panorama(world, [[0, 0]], [0], resolution_deg=2.5, elevation_deg=(-5, 40), supersampling=1)
    assert (view.shape, view.dtype) == ((1, 18, 144), np.float32)
    at_eye_height = render_panorama(world, [[0, 0, 0.01]], 0.0)
    assert_array_equal(render_panorama(world, [[0, 0]], 0.0), at_eye_height)


# Bad input: each gives one sentence.


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"positions": [[99, 0]]}, "position 0 at (99, 0) m lies outside the world, which reaches from (-50, -50)"),
        ({"positions": [[0, 0, -1]]}, "position 0 has the eye -1 m high, expected above the ground, z > 0"),
        ({"positions": [[0, 0, 0]]}, "position 0 has the eye 0 m high"),
        ({"positions": [0, 0]}, "positions has shape (2,), expected (n, 2) or (n, 3)"),
        ({"positions": [[0, np.nan]]}, "positions is nan at index 0, 1"),
        ({"positions": [[9, 9]]}, "position 0 at (9, 9, 0.01) m is inside a solid or below the ground"),
        ({"headings": [0.0, 1.0]}, "headings has shape (2,), expected (1,)"),
        ({"headings": 90.0}, "headings is 90, expected radians within ±2π: degrees?"),
        ({"headings": [np.inf]}, "headings is inf at index 0"),
        ({"resolution_deg": 0.7}, "resolution is 0.7 degrees, expected a whole number of pixels in the full circle"),
        ({"resolution_deg": 2.0}, "expected a whole number of pixels in the range of elevations"),
        ({"resolution_deg": 0.017}, "resolution is 0.017, expected 0.02 to 45 degrees: in radians?"),
        ({"elevation_deg": (-15, 100)}, "elevation reaches 100, expected -90 to 90 degrees"),
        ({"elevation_deg": (40, 10)}, "elevation runs from 40 to 10 degrees, expected the lower border first"),
        ({"supersampling": 3}, "supersampling is '3', expected one of 1, 2, 4, 8"),
        ({"band": "gray"}, "band 'gray' is unknown: expected one of grey (did you mean grey?)"),
        ({"workers": 0}, "workers is 0, expected a whole number of at least 1"),
        ({"positions": np.zeros((10**6, 2)), "headings": 0.0}, "1000000 views take 141 GiB, expected at most 8"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(changes, words):
    arguments = {"positions": [[0, 0]], "headings": 0.0} | changes
    with pytest.raises(InputError) as caught:
        render_panorama(world_of(box(9, 9, 2, 2)), **arguments)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_unknown_layer_is_refused():
    with pytest.raises(InputError, match="layer 'dept' is unknown"):
        render_layers(world_of(soup(1, 9)), [[0, 0]], 0.0, ("dept",))


def test_extent_is_wide_enough_for_these_tests():
    assert_array_equal(world_of(soup(1, 9)).extent, EVERYWHERE)
