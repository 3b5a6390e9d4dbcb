"""Frames of a section of a walk: rendered, taken by two cameras, segmented, and what is kept to be compared."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.stone2014_places.mirror import (
    ELEVATIONS_DEG,
    MirrorPixels,
    in_mirror,
    mirror_pixels,
    unwrapped,
)
from insectnav.experiments.stone2014_places.walk import DAYS, VARIATIONS, lit_city, walked
from insectnav.records import Mesh
from insectnav.vision.cameras import panorama
from insectnav.vision.descriptors import binary_sky, contour_amplitudes, harmonic_amplitudes, zernike_amplitudes
from insectnav.vision.sensor import Sensor, auto_exposure, expose, white_balance
from insectnav.vision.sky_segmentation import segment
from insectnav.worlds.sky import Sky
from insectnav.worlds.views import render

TREE = ("leaves", "bark")  # materials
VISIBLE = ("red", "green", "blue")
LUMA = (0.299, 0.587, 0.114)  # ITU-R BT.601, of numbers as encoded
SKY_SIZE, GREY_SIZE, UNWRAPPED = 90, 16, (28, 180)  # [px] section II-F
MIRROR_SIZE = 691  # [px] section II-F
N_DEGREES = 60  # of spherical harmonics, as of `insectnav.vision.descriptors.DESCRIPTORS`
N_KEPT_SECTIONS = 64  # of sections: the experiments on this walk share frames if one process runs them all
DAYLIGHT = Sky(sun_azimuth=0.0, sun_elevation=float(np.deg2rad(45.0)))  # that whites are balanced for
# Both cameras encode for a screen at 8 bits, as JPEGs have it, and meter every frame for themselves, as video does.
# Well and noise are those of `Sensor`; both assumed.
CAMERA = Sensor(saturation_radiance=1.0, response="srgb")

Arrays = Mapping[str, tuple]
Bytes = NDArray[np.uint8]
Bools = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True)
class Section:
    """Some frames of one day, seen in the light of the first of them.

    Parameters
    ----------
    day : of `walk.DAYS`
    first : number of the first frame
    n_frames : frames kept; what lies beyond the last of the walk is padded
    every : step from frame to frame
    stop : number of the frame before which the walk ends
    resolution_deg : of the panorama that is rendered
    supersampling : rays along each side of its pixels
    mirror_size : rows and columns of the mirror picture
    variation : of `walk.VARIATIONS`
    """

    day: str
    first: int
    n_frames: int
    every: int = 1
    stop: int = 100_000
    resolution_deg: float = 1.0
    supersampling: int = 2
    mirror_size: int = MIRROR_SIZE
    variation: str = "as set"


def sections(n_frames: int, **settings: Any) -> list[dict[str, Any]]:
    """Settings of the sections of both days, each with so many frames."""
    step, stop = n_frames * settings.get("every", 1), settings.get("stop", 100_000)
    return [
        {"day": name, "first": first, "n_frames": n_frames} | settings
        for name, day in DAYS.items()
        for first in range(0, min(day.n_frames, stop), step)
    ]


@lru_cache(maxsize=N_KEPT_SECTIONS)
def section_arrays(section: Section, seed: int) -> Arrays:
    """What is kept of the frames of a section, with dimensions.

    Frames that are none, after the end of the walk, have the number -1 and are empty.
    """
    variation = VARIATIONS[section.variation]
    day = variation.day(section.day)
    held, straight = walked(section.day, seed, variation)
    numbers = section.first + section.every * np.arange(section.n_frames)
    numbers = numbers[numbers < min(section.stop, len(held))]
    world = lit_city(day, float(straight.time[section.first]), seed)
    camera = panorama(section.resolution_deg, ELEVATIONS_DEG)
    pixels = mirror_pixels(section.mirror_size, section.resolution_deg)
    views = render(
        world, held.position[numbers], held.heading[numbers], held.pitch[numbers], held.roll[numbers],
        camera=camera, layers=("uv", *VISIBLE, "sky", "triangle"), supersampling=section.supersampling, workers=1,
    )  # fmt: skip
    views["tree"] = shows_tree(world.mesh, views.pop("triangle"))
    frames = [
        _kept({name: layer[k] for name, layer in views.items()}, pixels, variation.segmentation, seed, noise)
        for k, noise in enumerate((100_000 * day.number + numbers).tolist())
    ]
    kept = {
        "number": numbers,
        "position": held.position[numbers, :2],
        "distance": held.distance[numbers],
        "heading": held.heading[numbers],
        "course": straight.heading[numbers],
        **{name: np.stack([frame[name] for frame in frames]) for name in frames[0]},
    }
    return {name: (_dimensions(name, values), _padded(values, section.n_frames, name)) for name, values in kept.items()}


def _kept(view: Mapping[str, Any], pixels: MirrorPixels, method: str, seed: int, noise: int) -> dict[str, Any]:
    """What is kept of one view: skies of bits, greys, colours and amplitudes."""
    uv = uv_picture(view["uv"], pixels, seed, noise)
    sky = segment(uv, method, view="up", valid=pixels.seen).mask
    outline = unwrapped(sky, pixels)
    colours = visible_picture(view, seed, noise)
    grey = grey_of(colours)
    truth = in_mirror(view["sky"] >= 0.5, pixels)
    return {
        "mirror_sky": np.packbits(sky),
        "binary_sky": np.packbits(binary_sky(sky, SKY_SIZE)),
        "uv": reduced(unwrapped(uv, pixels), UNWRAPPED),
        "colours": reduced(colours, UNWRAPPED),
        "grey": reduced(in_mirror(grey, pixels), (GREY_SIZE, GREY_SIZE)),
        "grey_unwrapped": reduced(grey, (GREY_SIZE, GREY_SIZE)),
        "contour": contour_amplitudes(sky).astype(np.float32),
        "zernike": zernike_amplitudes(outline).astype(np.float32),
        "harmonics": harmonic_amplitudes(outline, n_degrees=N_DEGREES).astype(np.float32),
        "sky_share": above_horizon(view["sky"]),
        "tree_share": above_horizon(view["tree"]),
        "right_pixels": np.float32((sky == truth)[pixels.seen].mean()),
    }


def shows_tree(mesh: Mesh, triangle: NDArray[np.int32]) -> Bools:
    """Whether the nearest thing in each pixel is a tree, from numbers of triangles (...)."""
    is_tree = np.isin(np.asarray(mesh.materials)[np.asarray(mesh.material)], TREE)
    return (triangle >= 0) & is_tree[np.maximum(triangle, 0)]


def above_horizon(layer: NDArray[Any]) -> np.float32:
    """Mean of a panorama (rows, columns) over the solid angle above its horizon."""
    low, high = np.deg2rad(ELEVATIONS_DEG)
    rows = len(layer)
    elevation = high - (np.arange(rows) + 0.5) * (high - low) / rows
    weight = np.cos(elevation) * (elevation > 0.0)
    return np.float32(layer.mean(axis=1) @ weight / weight.sum())


def uv_picture(radiance: NDArray[Any], pixels: MirrorPixels, seed: int, noise: int) -> Bytes:
    """What the ultraviolet camera makes of the mirror, (size, size) uint8."""
    light = in_mirror(radiance, pixels)
    full = auto_exposure(light, mask=pixels.seen)
    return expose(
        light, CAMERA, seed=seed, channel="uv", saturation_radiance=full, first_image=noise, workers=1
    ).astype(np.uint8)


def visible_picture(view: Mapping[str, Any], seed: int, noise: int) -> Bytes:
    """What the camera for visible light makes of the panorama, (rows, columns, 3) uint8."""
    white = DAYLIGHT.irradiance(VISIBLE) / np.pi
    light = white_balance(np.stack([view[band] for band in VISIBLE], axis=-1), white)
    light = light / float(auto_exposure(light.mean(axis=-1)))
    numbers = expose(light, CAMERA, seed=seed, channel="visible", has_bands=True, first_image=noise, workers=1)
    return numbers.astype(np.uint8)


def grey_of(colours: Bytes) -> Bytes:
    """Grey of pictures in colour, (..., 3) to (...)."""
    return np.rint(colours @ np.array(LUMA)).astype(np.uint8)


def reduced(picture: NDArray[Any], size: tuple[int, int]) -> NDArray[Any]:
    """Mean of the pixels that each of fewer pixels covers, of the same type."""
    import cv2

    return np.asarray(cv2.resize(picture, size[::-1], interpolation=cv2.INTER_AREA), picture.dtype)


def _dimensions(name: str, values: NDArray[Any]) -> tuple[str, ...]:
    return ("frame", *(f"{name}_{axis}" for axis in range(1, values.ndim)))


def _padded(values: NDArray[Any], n_frames: int, name: str) -> NDArray[Any]:
    """As many frames in all sections; the number of those that are none is -1."""
    filling = np.full((n_frames - len(values), *values.shape[1:]), -1 if name == "number" else 0, values.dtype)
    return np.concatenate([values, filling])
