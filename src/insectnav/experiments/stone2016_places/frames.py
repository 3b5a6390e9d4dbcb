"""What the two cameras of the paper record on a passage, and what each method keeps of a frame.

Both look up through a fisheye lens of 185° and 1.19 mm; that it is equidistant is our reading, the text names no
projection. One takes the red, green and blue bands, the other the ultraviolet one of 350 nm; exposure is automatic.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.experiment import Arrays
from insectnav.experiments.stone2016_places.passages import PASSAGES, ground_of, lit_passage, poses_of
from insectnav.experiments.stone2016_places.sites import SITES
from insectnav.vision.cameras import Camera, fisheye
from insectnav.vision.descriptors import patch_normalised, sphere_amplitudes
from insectnav.vision.descriptors.patch_normalised import NOTHING
from insectnav.vision.lens_flare import LensFlare, add_lens_flare
from insectnav.vision.resampling import Resampler, resampler
from insectnav.vision.sensor import MID_GREY, Sensor, auto_exposure, expose, white_balance
from insectnav.vision.sky_segmentation import segment
from insectnav.vision.sphere import SphereGrid, gauss_legendre, rotation_matrix, thesis, to_eye
from insectnav.worlds.rays import SKY, cast_rays
from insectnav.worlds.sky import Sky
from insectnav.worlds.views import render

FIELD_OF_VIEW = float(np.deg2rad(185.0))
# [px] of the round picture in a frame of 270 rows, which FAB-MAP was given: 1.19 mm · 185° over a sensor 4.55 mm high.
FULL_SIZE = 228
VISIBLE = ("red", "green", "blue")
GREY = (0.299, 0.587, 0.114)  # ITU-R BT.601
DAYLIGHT = Sky(sun_azimuth=0.0, sun_elevation=float(np.deg2rad(45.0)))  # that whites are balanced for
# Well and noise are those of `Sensor`; pictures are encoded for a screen, as video is.
SENSOR = Sensor(saturation_radiance=1.0, black_level=0.0, response="srgb")
LENS = LensFlare()
# "the watershed method described in chapter 3" (section 4.4.3), in the reading that the walk of chapter 3 settled
WATERSHED = "watershed-islands"
N_BANDS = 120  # of spherical harmonics, section IV-B
FRAMES_AT_ONCE = 16


@dataclass(frozen=True, kw_only=True)
class Section:
    """Frames of a passage that are rendered together.

    Parameters
    ----------
    site : name in `sites.SITES`
    site_seed : of what stands there
    time_s : of what moves [s]
    passage : number in `passages.PASSAGES`
    first, n_frames : of the frames
    of_frames : number of frames of the whole passage
    size : rows and columns of the round picture [px]
    supersampling : rays along each side of a pixel
    """

    site: str
    site_seed: int
    time_s: float
    passage: int
    first: int
    n_frames: int
    of_frames: int
    size: int = FULL_SIZE
    supersampling: int = 2

    @property
    def place(self) -> tuple[str, int, float]:
        """Site, seed and time, as `passages.ground_of` takes them."""
        return self.site, self.site_seed, self.time_s


@dataclass(frozen=True, kw_only=True, eq=False)
class Recorded:
    """Pictures of a section, (frame, rows, columns) uint8 each, and where the sky truly is."""

    visible: NDArray[np.uint8]  # (frame, rows, columns, 3)
    uv: NDArray[np.uint8]
    plain_uv: NDArray[np.uint8]  # without lens flare, with the same noise
    sky: NDArray[np.bool_]
    is_sunlit: NDArray[np.bool_]  # (frame,) whether the sun shines on the lens

    @property
    def grey(self) -> NDArray[np.uint8]:
        """Brightness of the visible pictures, ITU-R BT.601."""
        return np.rint(self.visible @ np.array(GREY)).astype(np.uint8)


@lru_cache(maxsize=4)
def camera_of(size: int) -> Camera:
    """The fisheye camera: it looks up, ahead is at the top of the picture."""
    return fisheye((size, size), FIELD_OF_VIEW)


@lru_cache(maxsize=1)
def sky_grid() -> SphereGrid:
    """The directions on which skies are compared: rings that carry 120 bands."""
    return gauss_legendre(N_BANDS)


@lru_cache(maxsize=4)
def sky_sampler(size: int, points: str) -> Resampler:
    """From pictures to the "rings" of `sky_grid`, or to the 2000 "points" of the paper, in the frame of the camera."""
    return resampler(camera_of(size), sky_grid() if points == "rings" else thesis())


def record(section: Section, seed: int) -> Recorded:
    """Render a section as both cameras see it."""
    parts = [
        _record(section, np.arange(first, min(first + FRAMES_AT_ONCE, section.first + section.n_frames)), seed)
        for first in range(section.first, section.first + section.n_frames, FRAMES_AT_ONCE)
    ]
    return Recorded(**{name: np.concatenate([vars(part)[name] for part in parts]) for name in vars(parts[0])})


def _record(section: Section, chosen: NDArray[np.int64], seed: int) -> Recorded:
    site, camera = SITES[section.site], camera_of(section.size)
    world = lit_passage(*section.place, section.passage)
    poses = poses_of(site, ground_of(*section.place), section.passage, section.of_frames, seed)
    pose = tuple(np.asarray(value)[chosen] for value in (poses.position, poses.heading, poses.pitch, poses.roll))
    bands = ("uv", *VISIBLE)
    layers = render(world, *pose, camera=camera, layers=(*bands, "sky"), supersampling=section.supersampling, workers=1)
    sun = np.asarray(world.sky.sun, np.float64)
    # Not by `render`, which looks long for a solid about each eye that sees no sky, as these do in the shade.
    met, _ = cast_rays(world.shape, pose[0], np.broadcast_to(sun, (len(chosen), 1, 3)))
    is_sunlit = met[:, 0] == SKY
    plain = np.stack([layers[band] for band in bands], axis=-1).astype(np.float64)
    light = add_lens_flare(
        plain,
        camera,
        to_eye(np.broadcast_to(sun, (len(chosen), 3)), rotation_matrix(*pose[1:])),
        world.sky.sun_irradiance(bands),
        LENS,
        visible_share=is_sunlit.astype(np.float64),
        sun_diameter=world.sky.sun_diameter,
        has_bands=True,
    )
    visible = white_balance(light[..., 1:], DAYLIGHT.irradiance(VISIBLE) / np.pi)
    first = 100_000 * section.passage + int(chosen[0])
    return Recorded(
        visible=_exposed(visible, visible.mean(axis=-1), camera, seed, "visible", first),
        uv=_exposed(light[..., 0], light[..., 0], camera, seed, "uv", first),
        plain_uv=_exposed(plain[..., 0], plain[..., 0], camera, seed, "uv", first),
        sky=layers["sky"] >= 0.5,
        is_sunlit=is_sunlit,
    )


def _exposed(light: Any, metered: Any, camera: Camera, seed: int, channel: str, first: int) -> Any:
    """Bytes; the meter looks at the round picture alone."""
    full = auto_exposure(metered, MID_GREY, mask=camera.pixels_seen())
    has_bands = light.ndim == 4
    full = np.broadcast_to(full[:, None], (len(full), 3)) if has_bands else full
    return expose(
        light, SENSOR, seed=seed, channel=channel, saturation_radiance=full, has_bands=has_bands, first_image=first,
        workers=1,
    )  # fmt: skip


def sky_masks(uv: NDArray[np.uint8], camera: Camera, method: str = "otsu") -> NDArray[np.bool_]:
    """Masks of the sky, (frame, rows, columns): Otsu's threshold on the mean of the channels, section III-A.

    A rendered camera for ultraviolet has one channel.
    """
    return np.stack([segment(picture, method, channels="mean", camera=camera).mask for picture in uv])


def keep(section: Section, seed: int, *, with_pictures: bool) -> Arrays:
    """What the methods compare, of each frame of a section.

    Skies are in the frame of the camera, and what it does not see counts as ground. "true" are those of the exact mask.
    """
    recorded, camera = record(section, seed), camera_of(section.size)
    masks = sky_masks(recorded.uv, camera)
    rings = sky_sampler(section.size, "rings")(masks, unseen=0.0)
    true_rings = sky_sampler(section.size, "rings")(recorded.sky, unseen=0.0)
    points = sky_sampler(section.size, "points")(masks, unseen=0.0)
    seen = camera.pixels_seen()
    right = (masks == recorded.sky)[:, seen].mean(axis=1)
    grey = recorded.grey
    show = len(grey) // 2
    poses = poses_of(SITES[section.site], ground_of(*section.place), section.passage, section.of_frames, seed)
    chosen = slice(section.first, section.first + section.n_frames)
    orientation = np.stack([poses.heading, poses.pitch, poses.roll], axis=-1)
    arrays: dict[str, Any] = {
        "amplitudes": (("frame", "band"), _amplitudes(rings, sky_grid())),
        "point_amplitudes": (("frame", "band"), _amplitudes(points, thesis())),
        "true_amplitudes": (("frame", "band"), _amplitudes(true_rings, sky_grid())),
        "patches": (("frame", "pixel"), patch_normalised(grey, rounded=True, flat_patch=NOTHING)),
        "sky": (("frame", "byte"), np.packbits(rings >= 0.5, axis=-1), {"units": "bits on gauss-legendre 120"}),
        "distance": (("frame",), np.asarray(poses.distance)[chosen], {"units": "m"}),
        "orientation": (("frame", "angle"), orientation[chosen], {"units": "rad of heading, pitch and roll"}),
        "accuracy": (("frame",), 100.0 * right, {"units": "percent"}),
        "sky_share": (("frame",), recorded.sky[:, seen].mean(axis=1)),
        "shown_visible": (("row", "column", "colour"), recorded.visible[show]),
        "shown_uv": (("row", "column"), recorded.uv[show]),
        "shown_mask": (("row", "column"), masks[show]),
    }
    if with_pictures:
        arrays["pictures"] = (("frame", "row", "column"), grey)
        arrays |= _otherwise(recorded, section.size)
    return arrays


def _otherwise(recorded: Recorded, size: int) -> dict[str, Any]:
    """Amplitudes of the sky without lens flare and by a watershed, how right both masks are, where the sun shone in."""
    camera, seen = camera_of(size), camera_of(size).pixels_seen()
    arrays: dict[str, Any] = {"is_sunlit": (("frame",), recorded.is_sunlit)}
    for name, uv, method in (("plain", recorded.plain_uv, "otsu"), ("watershed", recorded.uv, WATERSHED)):
        masks = sky_masks(uv, camera, method)
        rings = sky_sampler(size, "rings")(masks, unseen=0.0)
        right = (masks == recorded.sky)[:, seen].mean(axis=1)
        arrays[f"{name}_amplitudes"] = (("frame", "band"), _amplitudes(rings, sky_grid()))
        arrays[f"{name}_accuracy"] = (("frame",), 100.0 * right, {"units": "percent"})
    return arrays


def _amplitudes(values: NDArray[np.float32], grid: SphereGrid) -> NDArray[np.float32]:
    return sphere_amplitudes(values, grid, N_BANDS).astype(np.float32)


def sections(site: str, passage: int, *, seed: int, stretch: float, each: int, **how: Any) -> list[Section]:
    """A passage, or the first `stretch` of it (0 to 1), in sections of `each` frames.

    Parameters
    ----------
    site : name in `sites.SITES`
    passage : number in `passages.PASSAGES`
    seed : of what stands there
    stretch : share of the way
    each : frames of a section; what does not fill one is left out
    how : other fields of `Section`
    """
    n = SITES[site].n_frames
    n_sections = max(1, round(stretch * n) // each)
    assert 0 <= passage < len(PASSAGES[site])
    return [
        Section(site=site, site_seed=seed, passage=passage, first=k * each, n_frames=each, of_frames=n, **how)
        for k in range(n_sections)
    ]
