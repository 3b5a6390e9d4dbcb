"""Light that a lens spreads over the picture: veiling glare, the halo of the sun, and ghosts.

Three parts, each a stated share of light. Veiling glare: of all the light that falls on the lens, sun included, an even
veil; what it takes is missing in the picture. Halo: of the sun's light, spread about the sun. Ghosts: of the sun's
light, reflected twice between surfaces of glass, an evenly bright spot on the line through sun and optical axis.

ISO 9358:1994 defines the veiling glare index by a black spot in an even bright field. So the veil here has the index
times the mean radiance before the lens, E / π, where E sums radiance times the cosine of the angle from the axis;
outside the picture the scene is taken to be as bright as its mean.

Energy: the veil gives a level sensor before the lens the irradiance `veiling_glare` times that of the light that falls
on it; halo and ghost summed over all directions are their share of the sun's irradiance. The image of the sun itself is
not dimmed by halo and ghosts: it is some ten thousand times as bright as what saturates a sensor.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_range, check_shape
from insectnav.vision.camera_models import PROJECTIONS
from insectnav.vision.cameras import EQUIRECTANGULAR, Camera
from insectnav.vision.picture_stacks import Stack, radiance_stack
from insectnav.vision.sphere import check_directions, great_circle_angle, to_eye, to_world

SUN_DIAMETER = float(np.deg2rad(0.53))  # [rad] mean, as of `insectnav.worlds.sky`
GHOST_EDGE = 0.3  # of a ghost's solid angle, over which its rim fades; assumed
COATED = 0.013**2  # two reflections at magnesium fluoride on crown glass, 1.3 % each at the best wavelength
Reals = NDArray[np.floating[Any]]


@dataclass(frozen=True, kw_only=True)
class Ghost:
    """One image of the sun by two reflections.

    In first-order optics its place in the picture is in proportion to that of the sun (Lee & Eisemann 2013, doi
    10.1111/cgf.12145). A sun outside the field of the lens makes none.

    Parameters
    ----------
    share : of the sun's light
    place : distance from the optical axis in the picture over that of the sun; positive on the far side of the axis
    radius : [rad] of the spot
    """

    share: float
    place: float
    radius: float

    def __post_init__(self) -> None:
        check_range("share of a ghost", self.share, 0.0, 1.0)
        check_range("place of a ghost", self.place, -10.0, 10.0)
        check_range("radius of a ghost", self.radius, 1e-4, np.pi / 2, "rad", "degrees?")


@dataclass(frozen=True, kw_only=True)
class LensFlare:
    """How much light a lens spreads, and where; no lens in particular.

    Parameters
    ----------
    veiling_glare : share, the veiling glare index of ISO 9358
    halo : share of the sun's light
    halo_core : [rad] angle from the sun within which the halo is even
    halo_slope : power of the angle by which it falls beyond
    ghosts : of the sun
    """

    veiling_glare: float = 0.02  # assumed
    # Assumed: 0.05 in telescopes (King 1971), less in clean coated lenses (Abraham & van Dokkum 2014)
    halo: float = 0.02
    halo_core: float = float(np.deg2rad(0.3))  # [rad] assumed: about the radius of the sun
    # Instruments of all kinds fall by the square or a little faster: King 1971, Sandin 2014
    halo_slope: float = 2.0
    ghosts: tuple[Ghost, ...] = (  # shares from `COATED`, places and radii assumed
        Ghost(share=COATED, place=1.0, radius=float(np.deg2rad(1.2))),
        Ghost(share=COATED, place=0.55, radius=float(np.deg2rad(3.0))),
        Ghost(share=COATED, place=-0.35, radius=float(np.deg2rad(2.0))),
    )

    def __post_init__(self) -> None:
        check_range("veiling_glare", self.veiling_glare, 0.0, 1.0, "", "per cent?")
        check_range("halo", self.halo, 0.0, 1.0, "", "per cent?")
        check_range("halo_core", self.halo_core, 1e-5, np.pi / 2, "rad", "degrees?")
        check_range("halo_slope", self.halo_slope, 0.5, 6.0)
        scattered = self.veiling_glare + self.halo + sum(ghost.share for ghost in self.ghosts)
        check_range("veiling_glare, halo and ghosts together", scattered, 0.0, 1.0)


NO_FLARE = LensFlare(veiling_glare=0.0, halo=0.0, ghosts=())


def add_lens_flare(
    radiance: ArrayLike,
    camera: Camera,
    sun: ArrayLike,
    sun_irradiance: ArrayLike,
    flare: LensFlare,
    *,
    visible_share: ArrayLike = 1.0,
    sun_diameter: float = SUN_DIAMETER,
    has_bands: bool = False,
) -> Reals:
    """Pictures with the lens's stray light, of the shape and precision of the radiance; same as it without flare.

    Parameters
    ----------
    radiance : (..., rows, columns) array [W m⁻² nm⁻¹ sr⁻¹], (..., rows, columns, band) if `has_bands`
        With or without the disc of the sun. Pixels that the camera does not see stay as they are.
    camera : Camera
        A panorama counts as made from a lens that looks up.
    sun : (3,) or (..., 3) array
        Unit vector to the sun in the frame of the eye: ``to_eye(sky.sun, rotation_matrix(heading, pitch, roll))``. It
        need not be in the picture.
    sun_irradiance : (...) array, (..., band) if `has_bands` [W m⁻² nm⁻¹]
        Of a plane that faces the sun, by the sun alone: `Sky.sun_irradiance`.
    flare : LensFlare
    visible_share : (...) array
        Share of the sun's disc that shines on the lens: 0 behind a tree, or with a hood.
    sun_diameter : [rad] of the disc drawn in the pictures, which is left out of their mean for the sun is counted apart
    has_bands : bool
        Whether the last axis is that of bands.

    Raises
    ------
    InputError
        If the radiance is no picture of this camera, or another input is out of range.

    Notes
    -----
    A lens is lit by a sun that is less than 90° from its axis, or in its field. The parts are described at the top of
    the module, at `halo_radiance` and at `Ghost`.
    """
    stack = radiance_stack(radiance, has_bands)
    if stack.pictures.shape[1:3] != tuple(camera.size):
        raise InputError(f"radiance has pictures of {stack.pictures.shape[1:3]} pixels, expected {camera.size}")
    check_range("sun_diameter", sun_diameter, 0.0, 0.5, "rad", "degrees?")
    suns = _sun_of_each(stack, sun)
    sunlight = _sunlight_of_each(stack, sun_irradiance, visible_share, has_bands)
    lens, result = _lens(camera), stack.pictures.copy()
    for k, picture in enumerate(stack.pictures):
        if k == 0 or (suns[k] != suns[k - 1]).any():
            pattern, weights = lens.sun_pattern(suns[k], flare), lens.weights(suns[k], sun_diameter)
        pixels = picture[lens.seen].astype(np.float64)
        # Not by @, whose order of sums depends on the number of threads
        mean = np.einsum("p,pb->b", weights, pixels)
        veil = flare.veiling_glare * (mean + sunlight[k] * max(lens.cosine(suns[k]), 0.0) / np.pi)
        result[k][lens.seen] = (1.0 - flare.veiling_glare) * pixels + veil + pattern[:, None] * sunlight[k]
    return stack.restored(result)


def _sun_of_each(stack: Stack, sun: ArrayLike) -> Reals:
    """Direction to the sun for each picture, (n, 3)."""
    vectors = np.asarray(check_directions("sun", sun), dtype=np.float64)
    check_shape("sun", vectors, (..., 3))
    try:
        return np.broadcast_to(vectors, (*stack.batch, 3)).reshape(len(stack.pictures), 3)
    except ValueError:
        raise InputError(f"sun has shape {vectors.shape}, expected (3,) or {(*stack.batch, 3)}") from None


def _sunlight_of_each(stack: Stack, sun_irradiance: ArrayLike, visible_share: ArrayLike, has_bands: bool) -> Reals:
    """Irradiance by what is seen of the sun, for each picture and band (n, band)."""
    irradiance = stack.values_of_each("sun_irradiance", sun_irradiance, has_bands)
    visible = stack.values_of_each("visible_share", visible_share, False)
    check_range("sun_irradiance", irradiance, 0.0, np.inf)
    check_range("visible_share", visible, 0.0, 1.0, "", "per cent?")
    return irradiance * visible


def halo_radiance(angle: ArrayLike, flare: LensFlare) -> Reals:
    """Radiance of the halo (...) [1/sr] at angles (...) [rad] from a sun of irradiance 1.

    Notes
    -----
    (1 - cos α + c)^(-slope / 2) at the angle α, c = halo_core² / 2, scaled to integrate to 1 over the sphere: like
    α^(-slope) beyond the core. The wings of images fall so: by the inverse square of the angle over a factor of 1000,
    up to 6°, with 5 % of the light (King 1971, doi 10.1086/129100); at least by it in a survey of instruments (Sandin
    2014, doi 10.1051/0004-6361/201423429); by that of its sine up to a right angle from polished and dusty surfaces
    (KenKnight 1984, ntrs.nasa.gov/citations/19850009602); telephoto lenses with good coatings have several times less
    of it (Abraham & van Dokkum 2014, doi 10.1086/674875).
    """
    core, power = flare.halo_core**2 / 2.0, flare.halo_slope / 2.0
    if power == 1.0:
        whole = np.log((2.0 + core) / core)
    else:
        whole = ((2.0 + core) ** (1.0 - power) - core ** (1.0 - power)) / (1.0 - power)
    # 2 sin²(α / 2) is 1 - cos α without the loss of digits near the sun
    from_sun = 2.0 * np.sin(np.asarray(angle, dtype=np.float64) / 2.0) ** 2
    return np.asarray(flare.halo * (from_sun + core) ** -power / (2.0 * np.pi * whole))


def pixel_solid_angles(camera: Camera) -> Reals:
    """Solid angle of each pixel, (rows, columns) [sr]; NaN where a pixel shows no direction.

    Parameters
    ----------
    camera : Camera

    Notes
    -----
    sin θ dθ over ρ dρ, for the angle θ from the axis and the distance ρ from the centre of the picture, at the centre
    of each pixel.
    """
    lens = _lens(camera)
    along, across = camera.focal_length
    if camera.model == EQUIRECTANGULAR:
        return np.asarray(np.hypot(lens.local[..., 0], lens.local[..., 2]) / (along * across))
    theta, step = np.maximum(lens.angle, 1e-3), 1e-4
    slope = (lens.radius(theta + step) - lens.radius(theta - step)) / (2.0 * step)
    return np.asarray(np.sin(theta) / (lens.radius(theta) * slope) / (along * across))


class _Lens:
    """The camera's lens: directions in its frame, with the optical axis along +y.

    A panorama stands for the picture of an equidistant lens that looks up.
    """

    def __init__(self, camera: Camera) -> None:
        self.camera = camera
        is_panorama = camera.model == EQUIRECTANGULAR
        self.projection = PROJECTIONS["equidistant" if is_panorama else camera.model]
        right, ahead, up = camera.rotation.T
        self.rotation = np.stack([right, up, -ahead], axis=-1) if is_panorama else camera.rotation
        self.field = np.pi if is_panorama else camera.field[1]
        self.directions, self.seen = camera.pixel_directions(), camera.pixels_seen()
        self.local = to_eye(self.directions, self.rotation)
        self.angle = np.arctan2(np.hypot(self.local[..., 0], self.local[..., 2]), self.local[..., 1])

    def radius(self, theta: Reals) -> Reals:
        return self.projection.radius(theta, self.camera.coefficients)

    def cosine(self, direction: Reals) -> float:
        return float(direction @ self.rotation[:, 1])

    def weights(self, sun: Reals, sun_diameter: float) -> Reals:
        """Part of each pixel seen in the light before the lens, (pixel), which sums to 1; none for the sun's pixels."""
        seen = self.seen
        solid = pixel_solid_angles(self.camera)[seen]
        # Half a diagonal beyond the disc, for a pixel whose centre is off the disc may show its edge.
        reach = sun_diameter / 2.0 + np.sqrt(solid)
        weights = solid * np.maximum(np.cos(self.angle[seen]), 0.0)
        weights[great_circle_angle(self.directions[seen], sun) <= reach] = 0.0
        if not weights.sum() > 0.0:
            raise InputError("the camera shows nothing before its lens but the sun, expected pixels within 90° of it")
        return np.asarray(weights / weights.sum())

    def sun_pattern(self, sun: Reals, flare: LensFlare) -> Reals:
        """Radiance (pixel) [1/sr] of halo and ghosts of a sun of irradiance 1."""
        theta = float(great_circle_angle(sun, self.rotation[:, 1]))
        looks = self.directions[self.seen]
        pattern = np.zeros(len(looks))
        if theta >= np.pi / 2 and theta > self.field:
            return pattern
        if flare.halo > 0.0:
            pattern += halo_radiance(great_circle_angle(looks, sun), flare)
        for ghost in flare.ghosts:
            centre = self._ghost_direction(sun, theta, ghost.place)
            if centre is not None and ghost.share > 0.0:
                pattern += _spot(great_circle_angle(looks, centre), ghost)
        return pattern

    def _ghost_direction(self, sun: Reals, theta: float, place: float) -> Reals | None:
        """Direction (3,) of a ghost in the eye; None if it lies out of the field."""
        if theta > self.field:
            return None
        distance = np.asarray(place * self.radius(np.asarray(theta)))
        angle = float(self.projection.angle(np.abs(distance), self.camera.coefficients, self.field))
        if not angle <= self.field:
            return None
        local = to_eye(sun, self.rotation)
        across = np.hypot(local[0], local[2])
        side = -np.sign(place) * np.sin(angle) / across if across > 0.0 else 0.0
        return to_world(np.array([side * local[0], np.cos(angle), side * local[2]]), self.rotation)


@lru_cache(maxsize=4)
def _lens(camera: Camera) -> _Lens:
    return _Lens(camera)


def _spot(angle: Reals, ghost: Ghost) -> Reals:
    """Radiance (...) [1/sr] at angles (...) [rad] from the centre of a ghost of a sun of irradiance 1."""
    # A rim that falls linearly in solid angle keeps the integral exactly.
    whole = 2.0 * np.sin(ghost.radius / 2.0) ** 2
    inside = np.clip((whole - 2.0 * np.sin(angle / 2.0) ** 2) / (GHOST_EDGE * whole) + 0.5, 0.0, 1.0)
    return np.asarray(ghost.share * inside / (2.0 * np.pi * whole))
