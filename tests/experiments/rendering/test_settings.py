"""Light, cameras, places, paths and pictures, each against what can be said without them."""

from pathlib import Path

import numpy as np
import pytest

from insectnav.checks import InputError
from insectnav.experiments.rendering.cameras import CameraParams
from insectnav.experiments.rendering.light import LightParams
from insectnav.experiments.rendering.paths import PathParams, poses_in
from insectnav.experiments.rendering.pictures import (
    PictureParams,
    label_picture,
    light_picture,
    material_labels,
    metered,
    triangle_labels,
    white_sheet,
)
from insectnav.experiments.rendering.places import PlaceParams, open_place, parameter_values
from insectnav.experiments.rendering.scenes import moments, scene_at
from insectnav.worlds.sky import Sky

TINY = {"radius": 6.0, "clearing": 2.0, "tree_density": 0.05}
TRIANGLE = "v 0 5 0\nv 1 5 0\nv 0 5 3\nf 1 2 3\n"


def tiny(**more) -> PlaceParams:
    return PlaceParams(world="ant-world", changes=TINY, **more)


# Light.


@pytest.mark.parametrize("longitude", [-120.0, -5.98, 0.0, 77.0])
def test_sun_is_in_the_south_at_noon_of_solar_time_everywhere(longitude: float):
    sky = LightParams(date="2014-06-20", time="12:00", latitude_deg=50.0, longitude_deg=longitude).sky(0.0)
    # 20 June 2014: the sun is 1.6 min behind the mean sun and 23.4° north of the equator.
    assert np.rad2deg(sky.sun_elevation) == pytest.approx(90 - 50 + 23.4, abs=0.2)
    azimuth = np.rad2deg(sky.sun_azimuth) % 360.0
    assert azimuth == pytest.approx(180.0, abs=1.5)
    assert azimuth < 180.0


def test_time_with_an_offset_is_that_time():
    moments_utc = [LightParams(time=text).moment(0.0) for text in ("09:30Z", "10:30+01:00")]
    assert moments_utc == [np.datetime64("2014-04-11T09:30", "us")] * 2
    assert LightParams(time="09:30Z").moment(90.5) == np.datetime64("2014-04-11T09:31:30.5", "us")
    solar = LightParams(time="12:00", longitude_deg=15.0).moment(0.0)
    assert solar == np.datetime64("2014-04-11T11:00", "us")


def test_sun_that_is_given_stands_still_while_clouds_drift():
    light = LightParams(sun_deg=(140.0, 40.0), weather="scattered")
    first, later = light.sky(0.0), light.sky(600.0)
    assert np.rad2deg([first.sun_azimuth, first.sun_elevation]) == pytest.approx([140.0, 40.0])
    assert first.sun_elevation == later.sun_elevation
    assert later.time - first.time == 600.0
    clear = LightParams(sun_deg=(140.0, 40.0))
    assert clear.sky(0.0) == clear.sky(600.0)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"date": "11.4.2014"}, "expected them as 2014-04-11 and 09:30"),
        ({"time": "9 o'clock"}, "expected them as"),
        ({"latitude_deg": 120.0}, "swapped?"),
        ({"sun_deg": (40.0, 140.0)}, "azimuth comes first"),
        ({"weather": "sunny"}, "expected one of clear, scattered, broken, overcast"),
    ],
)
def test_bad_light_is_refused(given: dict, words: str):
    with pytest.raises(InputError) as refused:
        LightParams(**given)
    assert words in str(refused.value)
    with pytest.raises(InputError, match="the sun stands at"):
        LightParams(time="23:00").sky(0.0)


# Cameras.


def test_pinhole_camera_sees_its_field_from_edge_to_edge():
    camera = CameraParams(kind="pinhole", size=(30, 40), field_of_view_deg=90.0).camera()
    assert camera.pixels_seen().all()
    left, right = camera.look([[0.0, 15.0], [40.0, 15.0]])
    np.testing.assert_allclose(left, [-np.sqrt(0.5), np.sqrt(0.5), 0.0], atol=1e-9)
    np.testing.assert_allclose(right, [np.sqrt(0.5), np.sqrt(0.5), 0.0], atol=1e-9)


def test_fisheye_looks_up_and_a_panorama_all_round():
    up = CameraParams(kind="fisheye", size=(20, 20)).camera()
    np.testing.assert_allclose(up.look([10.0, 10.0]), [0.0, 0.0, 1.0], atol=1e-9)
    ahead = CameraParams(kind="fisheye", size=(20, 20), look="ahead").camera()
    np.testing.assert_allclose(ahead.look([10.0, 10.0]), [0.0, 1.0, 0.0], atol=1e-9)
    assert CameraParams().camera().size == (105, 360)  # thesis, section 4.3
    assert CameraParams(resolution_deg=5.0, elevation_deg=(-30.0, 60.0)).camera().size == (18, 72)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"kind": "fisheye", "resolution_deg": 1.0}, "--resolution has no meaning for a fisheye"),
        ({"size": (3, 4)}, "--size has no meaning for a panorama"),
        ({"resolution_deg": 0.7}, "expected to divide"),
        ({"kind": "pinhole", "field_of_view_deg": 180.0}, "a fisheye?"),
        ({"kind": "pinhole", "field_of_view_deg": 0.9}, "in radians?"),
        ({"kind": "pinhole", "size": (20_000, 20_000)}, "number of pixels"),
        ({"resolution_deg": 0.01}, "number of pixels"),
        ({"supersampling": 3}, "expected one of 1, 2, 4, 8"),
    ],
)
def test_bad_camera_is_refused(given: dict, words: str):
    with pytest.raises(InputError) as refused:
        CameraParams(**given)
    assert words in str(refused.value)


# Places.


def test_settings_take_the_kind_of_the_default():
    values = parameter_values("city", {"n_cars": "3", "street_width": "12, 14", "foliage": "0"})
    assert values == {"n_cars": 3, "street_width": (12.0, 14.0), "foliage": 0.0}
    assert parameter_values("ant-world", {"ground": "grass"}) == {"ground": "grass"}
    for settings, words in (({"n_cars": "3.5"}, "something like 60"), ({"street_width": "12"}, "like 11.0,22.0"),
                            ({"cars": "3"}, "did you mean n_cars?")):  # fmt: skip
        with pytest.raises(InputError) as refused:
            parameter_values("city", settings)
        assert words in str(refused.value)


def test_mesh_without_materials_is_flat_until_one_is_given(tmp_path: Path):
    path = tmp_path / "wall.obj"
    path.write_text(TRIANGLE)
    assert open_place(PlaceParams(world=str(path), changes={})).light == "flat"
    lit = open_place(PlaceParams(world=str(path), changes={}, material="brick"))
    assert (lit.light, lit.mesh.materials) == ("sky", ("brick",))
    with pytest.raises(InputError, match="expected --material NAME"):
        open_place(PlaceParams(world=str(path), changes={}, light="sky"))
    named = tmp_path / "named.obj"
    named.write_text("usemtl brick\n" + TRIANGLE)
    assert open_place(PlaceParams(world=str(named), changes={})).light == "sky"


def test_cars_move_with_the_time_of_the_traverse_and_houses_do_not():
    params = PlaceParams(world="suburban-street", changes={"length": 40.0, "n_people": 0, "back_trees": 0.0})
    first, later = (open_place(params, seconds).mesh for seconds in (0.0, 2.0))
    kept = {one.tobytes() for one in first.vertices} & {one.tobytes() for one in later.vertices}
    assert 0.8 * first.n_triangles < len(kept) < first.n_triangles


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"world": "cty"}, "did you mean city?"),
        ({"world": "city", "material": "leaves"}, "--material has no meaning for the world 'city'"),
        ({"world": "a.obj", "changes": {"foliage": 1.0}}, "--set has no meaning"),
        ({"world": "ant-world", "world_time_s": 3.0}, "nothing moves in ant-world"),
        ({"world": "city", "changes": {"time_s": 1.0}}, "expected --world-time"),
        ({"world": "a.obj", "material": "leaves", "light": "flat"}, "expected one of the two"),
    ],
)
def test_bad_place_is_refused(given: dict, words: str):
    with pytest.raises(InputError) as refused:
        PlaceParams(**({"changes": {}} | given))
    assert words in str(refused.value)


# Paths.


def test_one_picture_is_taken_in_the_middle_of_the_route():
    place = open_place(tiny())
    poses = poses_in(place, PathParams())
    np.testing.assert_allclose(poses.position, [[*place.route.mean(axis=0).tolist(), 0.01]], atol=1e-6)


def test_traverse_has_its_spacing_rate_or_number():
    place = open_place(tiny())  # 1.8 m long
    assert len(poses_in(place, PathParams(spacing=0.6))) == 4
    assert len(poses_in(place, PathParams(frame_rate=2.0, speed=0.6))) == 7
    four = poses_in(place, PathParams(n_frames=4, start=0.3, stop=1.5))
    np.testing.assert_allclose(four.distance, [0.3, 0.7, 1.1, 1.5])
    back = poses_in(place, PathParams(n_frames=4, is_reversed=True))
    np.testing.assert_allclose(back.position[0, :2], [0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(np.abs(np.rad2deg(back.heading)), 180.0)


def test_tilt_and_heading_are_those_given():
    poses = poses_in(open_place(tiny()), PathParams(n_frames=3, heading_deg=90.0, pitch_deg=30.0, roll_deg=-10.0))
    for name, value in (("heading", 90.0), ("pitch", 30.0), ("roll", -10.0)):
        np.testing.assert_allclose(np.rad2deg(getattr(poses, name)), value)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"spacing": 1.0, "n_frames": 3}, "--spacing and --frames are given"),
        ({"at": (0.0, 0.0), "positions": "a.csv"}, "--positions and --at are given"),
        ({"start": 1.0}, "--start needs a traverse"),
        ({"n_frames": 10**9}, "expected 1 to 1e+06"),
        ({"pitch_deg": 100.0}, "pitch is 100"),
        ({"yaw_jitter_deg": 200.0}, "jitter"),
    ],
)
def test_bad_path_is_refused(given: dict, words: str):
    with pytest.raises(InputError) as refused:
        PathParams(**given)
    assert words in str(refused.value)


# Moments.


def test_frames_of_an_interval_share_a_moment():
    parts = moments(np.array([0.0, 4.0, 9.99, 10.0, 35.0, 39.0]), 10.0)
    assert [tuple(part) for part in parts] == [(0, 3, 0.0), (3, 4, 10.0), (4, 6, 30.0)]
    assert [tuple(part) for part in moments(np.array([12.0]), 10.0)] == [(0, 1, 10.0)]


def test_scene_keeps_what_does_not_change():
    params, light = tiny(), LightParams(sun_deg=(90.0, 30.0))
    first = scene_at(params, light, 0.0)
    assert scene_at(params, light, 60.0, first) is first
    later = scene_at(params, LightParams(), 60.0, first)
    assert later.place is first.place
    assert later.sky != first.sky


# Pictures.


def test_meter_brings_the_mean_to_a_quarter_and_leaves_out_what_is_not_seen():
    seen = np.array([[True, True, False]])
    radiance = np.array([[0.1, 0.3, 50.0]])[None, ..., None]
    assert metered(radiance, np.ones(1), seen, "mean") == pytest.approx(0.2 / 0.25)
    assert metered(radiance, np.array([2.0]), seen, "mean") == pytest.approx(0.1 / 0.25)


def test_white_sheet_in_the_light_of_the_scene_is_white():
    sky = Sky(sun_azimuth=0.0, sun_elevation=0.15, turbidity=5.0)
    sheet = sky.irradiance(("red", "green", "blue")) / np.pi
    white = float(sheet[1]) * white_sheet("visible", sky, "scene")
    picture = light_picture(np.broadcast_to(0.999 * sheet, (2, 2, 3)), "visible", white, 0, PictureParams())
    np.testing.assert_array_equal(picture, 255)
    daylight = Sky(sun_azimuth=1.0, sun_elevation=np.deg2rad(40.0), turbidity=3.0).irradiance(("red", "green"))
    assert white_sheet("visible", sky, "daylight")[0] == pytest.approx(daylight[0] / daylight[1], rel=1e-5)


def test_numbers_of_light_are_its_share_of_white():
    radiance = np.array([[0.0, 0.25, 0.5, 2.0]])[..., None]
    linear = PictureParams(bits=16)
    np.testing.assert_array_equal(light_picture(radiance, "uv", np.array([1.0]), 0, linear), [[0, 16384, 32768, 65535]])
    srgb = light_picture(radiance, "uv", np.array([1.0]), 0, PictureParams())
    np.testing.assert_array_equal(srgb, [[0, 137, 188, 255]])  # IEC 61966-2-1
    raw = light_picture(radiance, "uv", None, 0, PictureParams(bits=32, format="tiff"))
    np.testing.assert_array_equal(raw, radiance[..., 0].astype(np.float32))


def test_labels_of_materials():
    labels = triangle_labels(("leaves", "something"), np.array([1, 0, 0]))
    numbers = material_labels()
    assert len(set(numbers.values())) == len(numbers)
    assert max(numbers.values()) <= 255
    layers = {"triangle": np.array([[0, 1, -1, -2, -1]]), "sky": np.array([[0.0, 0.49, 0.5, 0.0, 0.0]])}
    seen = np.array([[True, True, True, True, False]])
    expected = [numbers[name] for name in ("other", "leaves", "sky", "bare ground", "not seen")]
    np.testing.assert_array_equal(label_picture(layers, "material", seen, labels, 8), [expected])
    np.testing.assert_array_equal(label_picture(layers, "sky_mask", seen, labels, 8), [[0, 0, 255, 0, 0]])
    np.testing.assert_array_equal(label_picture(layers, "sky_share", seen, labels, 8), [[0, 125, 128, 0, 0]])


@pytest.mark.parametrize(
    ("given", "light", "words"),
    [
        ({"pictures": ("infrared",)}, "sky", "picture 'infrared' is unknown"),
        ({"pictures": ("grey",)}, "sky", "there is no picture grey in the light sky"),
        ({"pictures": ("uv",)}, "flat", "there is no picture uv in the light flat"),
        ({"noise": True}, "flat", "no noise"),
        ({"bits": 32}, "sky", "--format tiff?"),
        ({"bits": 32, "format": "tiff", "noise": True}, "sky", "the radiance itself"),
        ({"exposure": "auto"}, "sky", "expected traverse, frame or a number"),
        ({"exposure": -1.0}, "sky", "exposure is -1"),
    ],
)
def test_bad_pictures_are_refused(given: dict, light: str, words: str):
    with pytest.raises(InputError) as refused:
        PictureParams(**given).chosen(light)
    assert words in str(refused.value)
