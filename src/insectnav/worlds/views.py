"""Views of a world through any camera, held in any way: one call for flat worlds and for worlds in the light."""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats
from insectnav.checks import InputError, as_numbers, check_choice, check_finite, check_radians, check_shape, quoted
from insectnav.vision.cameras import AHEAD, Camera
from insectnav.vision.sphere import check_directions, rotation_matrix, to_world
from insectnav.worlds.lit_world import LitWorld
from insectnav.worlds.mirrors import add_mirrored, without_mirrors
from insectnav.worlds.rays import GROUND, SKY, cast_rays
from insectnav.worlds.renderer import (
    LAYERS,
    SUPERSAMPLING,
    Layers,
    check_size,
    draw_samples,
    render_layers,
    run_views,
)
from insectnav.worlds.solids import check_outside_solids
from insectnav.worlds.world import World, check_positions

Bools = npt.NDArray[np.bool_]


class Samples(NamedTuple):
    """What the rays of one view meet."""

    rays: Any  # (pixel, sample, 3) unit vectors in the world, float32
    triangle: Any  # (pixel, sample) int32, SKY or GROUND where there is none
    nearness: Any  # (pixel, sample) float32 [1/m], 0 for the sky


class Poses(NamedTuple):
    """Where eyes are and how they are held."""

    position: Any  # (view, 3) [m]
    rotation: Any  # (view, 3, 3), world ← eye
    level: Any  # (view,) [rad] headings of those that are level, NaN for the others


class Eye(NamedTuple):
    """The rays of an eye, in its own frame."""

    rays: Any  # (pixel, sample, 3) unit vectors
    shape: tuple[int, ...]  # of what is seen
    place: Any  # (pixel,) which elements of it the pixels are
    panorama: Any  # (resolution, elevations [°], supersampling) if the rays are all those of a panorama, else None
    pixel_angle: float  # [rad] width of a pixel; 0 for single rays


def render(
    world: World | LitWorld,
    positions: npt.ArrayLike,
    headings: npt.ArrayLike = 0.0,
    pitch: npt.ArrayLike = 0.0,
    roll: npt.ArrayLike = 0.0,
    *,
    camera: Camera | None = None,
    directions: npt.ArrayLike | None = None,
    layers: Sequence[str],
    supersampling: int = 4,
    workers: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> Layers:
    """What is seen through a camera, or along directions, from many places: bands and other layers by name.

    Parameters
    ----------
    world : World or LitWorld
    positions : (n, 2 or 3) array of x, y and perhaps z [m]; an eye without z is 0.01 m above the ground
    headings, pitch, roll : (n,) arrays, or one for all [rad], as of `insectnav.vision.sphere.rotation_matrix`
    camera : Camera or None
        `insectnav.vision.panorama(1.0)`, `fisheye(...)` and the like. Panoramas of all 360° are drawn by the compiled
        buffer of depths, whatever the tilt; other cameras by rays, which need the package embreex.
    directions : (..., 3) array of unit vectors, or None
        In place of a camera: x right, y ahead, z up in the frame of the eye; one ray each.
    layers : bands of the world, and any of "sky", "alpha", "nearness", "depth" and "triangle" of `render_layers`
    supersampling : 1, 2, 4 or 8 rays along each side of a camera's pixel, averaged
    workers, progress : as of `render_panorama`

    Returns
    -------
    name → (n, rows, columns) or (n, ...) array of float32, int32 for "triangle"
        Bands of a flat world are in 0…1, those of a lit one radiance in W m⁻² nm⁻¹ sr⁻¹. What a camera does not see is
        0 in every layer (-1 in "triangle"): `camera.pixels_seen()` tells which pixels that are.

    Raises
    ------
    InputError
        If a position is outside the world or inside a solid, an option makes no sense, or embreex is needed and not
        installed.

    Notes
    -----
    Light on surfaces: see `insectnav.worlds.lit_world`. Rays by Embree (Wald et al. 2014, doi 10.1145/2601097.2601199).
    """
    for layer in layers:
        check_choice("layer", layer, (*world.bands, *LAYERS))
    shape = world.shape if isinstance(world, LitWorld) else world
    position, rotation, level = _check_eyes(shape, positions, (headings, pitch, roll))
    whole = None if camera is None or directions is not None else whole_panorama(camera)
    if isinstance(world, World) and whole is not None and np.isfinite(level).all():
        options: Any = {"supersampling": supersampling, "workers": workers, "progress": progress}
        resolution, elevation = whole
        return render_layers(
            world, position, level, layers, resolution_deg=resolution, elevation_deg=elevation, **options
        )
    eye = _camera_eye(camera, supersampling) if directions is None else _single_rays(camera, directions)
    check_size((len(position), *eye.shape), len(layers))
    return _render_samples(world, Poses(position, rotation, level), eye, layers, workers, progress)


def _render_samples(
    world: World | LitWorld,
    poses: Poses,
    eye: Eye,
    layers: Sequence[str],
    workers: int | None,
    progress: Callable[[int], None] | None,
) -> Layers:
    """Each view from what each of its rays meets."""
    shape, n_views = world.shape if isinstance(world, LitWorld) else world, len(poses.position)
    found = _empty(layers, (n_views, math.prod(eye.shape)))
    has_no_sky = np.zeros(n_views, np.bool_)
    _make_ready(world, shape, eye)

    def run_task(first: int, last: int) -> None:
        for view in range(first, last):
            position = poses.position[view]
            samples = _meet(shape, position, poses.rotation[view], float(poses.level[view]), eye)
            has_no_sky[view] = not (samples.triangle == SKY).any() and (samples.rays[..., 2] > 0).any()
            values = _values(world, layers, samples, position, eye)
            for layer in layers:
                found[layer][view, eye.place] = values[layer]

    run_views(run_task, n_views, workers, progress)
    check_outside_solids(shape, poses.position, has_no_sky)
    return {layer: values.reshape(n_views, *eye.shape) for layer, values in found.items()}


def _make_ready(world: World | LitWorld, shape: World, eye: Eye) -> None:
    """Have what all views need made once, before several threads ask for it."""
    if isinstance(world, LitWorld):
        world.packed  # noqa: B018
    if eye.panorama is None:
        cast_rays(shape, np.zeros((1, 3)), np.zeros((1, 0, 3)))


def _check_eyes(world: World, positions: npt.ArrayLike, angles: tuple[npt.ArrayLike, ...]) -> tuple[Floats, Any, Any]:
    """Positions (n, 3), rotations (n, 3, 3), and headings (n,) of those that are level, NaN for the others."""
    position = check_positions(world, positions)
    given = []
    for name, angle in zip(("headings", "pitch", "roll"), angles, strict=True):
        array = as_numbers(name, angle).astype(np.float64)
        if array.ndim:
            check_shape(name, array, (len(position),))
        check_finite(name, array)
        check_radians(name, array)
        given.append(np.broadcast_to(array, len(position)))
    level = np.where((given[1] == 0.0) & (given[2] == 0.0), given[0], np.nan)
    return position, np.asarray(rotation_matrix(*given), dtype=np.float64), level


def _single_rays(camera: Camera | None, directions: npt.ArrayLike) -> Eye:
    if camera is not None:
        raise InputError("both a camera and directions are given, expected one of the two")
    look = np.asarray(check_directions("directions", directions), dtype=np.float64)
    shape = look.shape[:-1]
    return Eye(look.reshape(-1, 1, 3), shape, np.arange(look.size // 3), None, 0.0)


def _camera_eye(camera: Camera | None, supersampling: int) -> Eye:
    """Rays through the centres of equal parts of each pixel."""
    if camera is None:
        raise InputError("neither a camera nor directions are given, expected one of them, as camera=panorama(1.0)")
    if supersampling not in SUPERSAMPLING:
        raise InputError(f"supersampling is {quoted(supersampling)}, expected one of 1, 2, 4, 8")
    (rows, columns), s = camera.size, supersampling
    at = (np.arange(s) + 0.5) / s
    place = np.empty((rows, columns, s, s, 2))
    place[..., 0] = np.arange(columns)[:, None, None] + at
    place[..., 1] = np.arange(rows)[:, None, None, None] + at[:, None]
    seen = np.flatnonzero(camera.pixels_seen())
    if not seen.size:
        raise InputError("the camera sees no direction in any of its pixels, expected a field that its picture holds")
    rays = camera.look(place.reshape(rows * columns, s * s, 2)[seen])
    at_rim = ~np.isfinite(rays[..., 0])  # of a pixel whose centre is within the field
    middle = camera.look(np.stack([seen % columns, seen // columns], axis=-1) + 0.5)
    rays = np.where(at_rim[..., None], middle[:, None], rays)
    whole = whole_panorama(camera)
    panorama = None if whole is None else (*whole, s)
    return Eye(rays, camera.size, seen, panorama, float(1.0 / camera.focal_length[0]))


def whole_panorama(camera: Camera) -> tuple[float, tuple[float, float]] | None:
    """Resolution and range of elevations [°] of a camera that is a panorama of all 360°; None of any other."""
    (rows, columns), resolution = camera.size, 360.0 / camera.size[1]
    is_square = bool(np.isclose(camera.focal_length[1], camera.focal_length[0], rtol=1e-9))
    is_middle = bool(np.isclose(camera.centre[0], columns / 2.0))
    if not (camera.wraps and is_square and is_middle and camera.mounting == AHEAD and not camera.masked_sectors):
        return None
    top = camera.centre[1] * resolution
    low, high = round(top - rows * resolution, 9), round(top, 9)
    return (resolution, (low, high)) if -90.0 <= low < high <= 90.0 else None


def _empty(layers: Sequence[str], shape: tuple[int, ...]) -> Layers:
    return {
        layer: np.full(shape, SKY, np.int32) if layer == "triangle" else np.zeros(shape, np.float32) for layer in layers
    }


def _meet(world: World, position: Floats, rotation: Floats, heading: float, eye: Eye) -> Samples:
    """What the rays of a view meet."""
    rays = to_world(eye.rays.reshape(-1, 3), rotation)
    if eye.panorama is None:
        triangle, distance = cast_rays(world, position[None], rays[None])
        with np.errstate(divide="ignore"):
            nearness = (1.0 / distance[0]).astype(np.float32)
        triangle = triangle[0]
    else:
        triangle, nearness = draw_samples(world, position, rotation, heading, *eye.panorama)
        is_free = triangle < 0
        triangle = np.where(is_free, np.where(rays[:, 2] >= 0, SKY, GROUND), triangle).astype(np.int32)
        nearness = np.where(is_free, np.maximum(-rays[:, 2], 0.0) / position[2], nearness).astype(np.float32)
    shape = eye.rays.shape[:2]
    return Samples(rays.astype(np.float32).reshape(*shape, 3), triangle.reshape(shape), nearness.reshape(shape))


def _values(world: World | LitWorld, layers: Sequence[str], samples: Samples, position: Floats, eye: Eye) -> Layers:
    """Mean of each layer over the samples of each pixel, (pixel,)."""
    found: dict[str, Any] = {}
    nearness = samples.nearness.mean(axis=1)
    if isinstance(world, LitWorld) and set(world.bands) & set(layers):
        found |= _radiance(world, samples, position, eye)
    for layer in layers:
        if layer == "triangle":
            nearest = np.argmax(np.where(samples.triangle >= 0, samples.nearness, -1.0), axis=1)
            middle = samples.triangle.shape[1] // 2
            is_free = (samples.triangle < 0).all(axis=1)
            found[layer] = samples.triangle[np.arange(len(nearest)), np.where(is_free, middle, nearest)]
        elif layer == "nearness":
            found[layer] = nearness
        elif layer == "depth":
            with np.errstate(divide="ignore"):
                found[layer] = 1.0 / nearness
        elif layer in ("sky", "alpha"):
            found[layer] = (samples.triangle == SKY if layer == "sky" else samples.triangle >= 0).mean(axis=1)
        elif isinstance(world, World):
            background = np.array([world.ground[layer], world.sky[layer]], np.float32)
            found[layer] = np.append(world.brightness[layer], background)[samples.triangle].mean(axis=1)
    return found


def _radiance(world: LitWorld, samples: Samples, position: Floats, eye: Eye) -> Layers:
    """Bands of each pixel; by rays mirrors show what is there, unless all surfaces lie open."""
    from insectnav.worlds.shading_kernel import shade_pixels

    n_pixels, packed = len(samples.triangle), world.packed
    has_rays = eye.panorama is None and world.shadows
    radiance = np.empty((n_pixels, len(world.bands)))
    surfaces = without_mirrors(packed.surfaces) if has_rays else packed.surfaces
    optics = surfaces, packed.octaves, packed.light, packed.sun_map, packed.sky_maps
    shade_pixels(tuple(samples), np.tile(position, (n_pixels, 1)), eye.pixel_angle, *optics, radiance)
    if has_rays:
        add_mirrored(world.shape, packed, tuple(samples), position, eye.pixel_angle, radiance)
    return {band: radiance[:, k] for k, band in enumerate(world.bands)}
