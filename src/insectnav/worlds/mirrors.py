"""What mirrors show, by a second ray from where the first one met them: windows, paint, water and metal."""

from typing import Any

import numpy as np

from insectnav.angles import Floats
from insectnav.worlds.rays import GROUND, cast_rays
from insectnav.worlds.world import World

LIFT = 1e-3  # [m] off the mirror at which the second ray starts


def without_mirrors(surfaces: Any) -> Any:
    """The same surfaces, of which none mirrors; those that did still have no texture."""
    return surfaces._replace(mirror=np.tile([1.0, 1.0, 0.0], (len(surfaces.mirror), 1)))


def add_mirrored(world: World, packed: Any, samples: Any, eye: Floats, pixel_angle: float, radiance: Floats) -> None:
    """Add to the radiance (pixel, band) of a view what its samples see in mirrors.

    Parameters
    ----------
    world : World
        The surfaces that rays meet.
    packed : `insectnav.worlds.lit_world.PackedLight`
    samples : rays (pixel, sample, 3), triangles and nearness (pixel, sample)
    eye : (3,) array [m]

    Notes
    -----
    A mirror seen in a mirror shows what `insectnav.worlds.shading_kernel.mirrored_light` takes it to show.
    """
    from insectnav.worlds.shading_kernel import shade_pixels
    from insectnav.worlds.surface_mirror_kernel import reflect

    rays, triangles, nearness = samples
    surfaces = packed.surfaces
    index = np.where(triangles == GROUND, len(surfaces.normal) - 1, triangles)
    optics = surfaces.mirror[surfaces.material]
    is_mirror = (optics[:, 0] > 1.0) | (optics[:, 2] > 0.0)
    pixel, sample = np.nonzero((index >= 0) & is_mirror[index])
    if not pixel.size:
        return
    met, n_bands = index[pixel, sample], radiance.shape[1]
    ray = rays[pixel, sample].astype(np.float64)
    start, second, share = (np.empty(shape) for shape in ((len(met), 3), (len(met), 3), len(met)))
    distance = 1.0 / np.maximum(nearness[pixel, sample].astype(np.float64), 1e-6)
    reflect(ray, distance, np.asarray(eye, np.float64), surfaces.normal[met], optics[met], LIFT, start, second, share)
    triangle, far = cast_rays(world, start, second[:, None])
    with np.errstate(divide="ignore"):
        near = (1.0 / far).astype(np.float32)
    mirrored = np.empty((len(met), n_bands))
    rest = packed.octaves, packed.light, packed.sun_map, packed.sky_maps
    shade_pixels((second[:, None].astype(np.float32), triangle, near), start, pixel_angle, surfaces, *rest, mirrored)
    weighted = mirrored * (share / rays.shape[1])[:, None]
    for band in range(n_bands):
        radiance[:, band] += np.bincount(pixel, weighted[:, band], minlength=len(radiance))
