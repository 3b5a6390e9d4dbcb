"""A world under a sky: its surfaces in the light of one moment, in radiance.

Assumptions: surfaces scatter alike to all sides, but for the mirrors among them; light that was scattered by two
surfaces or more counts as if it came from all of them alike, in the mean of what stands in the world; the air between
is clear; the ground beyond the mesh is level and of one material. By rays mirrors show what is there, once; in
panoramas, and in each other, they show the sky where the nearest part of it is free, and else that mean.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats
from insectnav.checks import InputError, check_choice, check_count, check_range
from insectnav.records import Mesh
from insectnav.vision.sphere import directions, fibonacci
from insectnav.worlds.built_world import BuiltWorld
from insectnav.worlds.materials import MATERIALS, Material, mirror_optics, reflectance, transmittance
from insectnav.worlds.shadow_map import shadow_map, sky_maps
from insectnav.worlds.sky import Sky
from insectnav.worlds.skylight import BANDS, sky_quadrature
from insectnav.worlds.texture import pack_octaves
from insectnav.worlds.world import World, flat_world

LIGHT_BANDS = tuple(BANDS)
N_SKY_PARTS = 32
SKY_TABLE_DEG = 0.5  # between the entries of the table of the sky's radiance


@dataclass(frozen=True, kw_only=True)
class Grain:
    """Texture of the surfaces, see `insectnav.worlds.texture`; the same on all of them but mirrors, which have none.

    Parameters
    ----------
    contrast : float
        Standard deviation of the reflectance over its mean; 0 is flat.
    coarsest : float
        Size of the coarsest pattern [m].
    n_octaves : int
        Each is half as large as the one before.
    seed : int
        Not negative.
    """

    contrast: float = 0.2  # assumed
    coarsest: float = 1.0  # [m] assumed
    n_octaves: int = 8  # down to 8 mm, what one degree spans at half a metre
    seed: int = 0

    def __post_init__(self) -> None:
        check_range("contrast", self.contrast, 0.0, 1.0)
        check_count("seed of the texture", self.seed, minimum=0)


@dataclass(frozen=True, kw_only=True, eq=False)
class LitWorld:
    """Surfaces and a sky; made by `light_world`, seen by `insectnav.worlds.render`.

    Parameters
    ----------
    shape : World
        The mesh, and where an eye may be.
    sky : Sky
    grain : Grain
    ground : str
        Material of the level ground where there is no mesh, in `insectnav.worlds.materials.MATERIALS`.
    shadows : bool
        Whether surfaces keep the light of sun and sky from each other.
    materials : name → Material
        Optics of all that the mesh names, and of the ground.
    """

    shape: World
    sky: Sky
    grain: Grain
    ground: str
    shadows: bool = True
    materials: Mapping[str, Material] = field(default_factory=lambda: MATERIALS, repr=False)
    _kept: dict[str, tuple[Any, ...]] = field(default_factory=dict, repr=False)  # see `_kept_or_made`

    @property
    def mesh(self) -> Mesh:
        """The surfaces."""
        return self.shape.mesh

    @property
    def extent(self) -> Any:
        """Least and greatest x, y (2, 2) [m] of positions within the world."""
        return self.shape.extent

    @property
    def bands(self) -> tuple[str, ...]:
        """Names of the bands."""
        return LIGHT_BANDS

    def under(self, sky: Sky) -> Self:
        """The same surfaces under another sky."""
        return replace(self, sky=sky)

    @cached_property
    def packed(self) -> "PackedLight":
        """Everything that light does here, in the form that kernels read; worked out once."""
        return _pack(self)


@dataclass(frozen=True, kw_only=True, eq=False)
class PackedLight:
    """Arguments of `insectnav.worlds.shading_kernel.shade_pixels`."""

    surfaces: Any
    octaves: Any
    light: Any
    sun_map: Any
    sky_maps: Any


def light_world(
    world: BuiltWorld | Mesh,
    sky: Sky,
    *,
    grain: Grain | None = None,
    ground: str = "soil",
    material: str | None = None,
    shadows: bool = True,
    extent: npt.ArrayLike | None = None,
    materials: Mapping[str, Material] = MATERIALS,
) -> LitWorld:
    """A built world or a mesh under a sky.

    Parameters
    ----------
    world : BuiltWorld or Mesh
        Its materials are names in `insectnav.worlds.materials.MATERIALS`.
    sky : Sky
    grain : Grain or None
        Texture of the surfaces; None for that of the world's own seed.
    ground : str
        Material of the level ground beyond the mesh, or below it where it has none.
    material : str or None
        One material for all triangles, for a mesh that brings none.
    shadows : bool
        Without them all surfaces lie open to sun and sky.
    extent : as of `insectnav.worlds.World`
    materials : name → Material
        Others than those of the table, or with other reflectances: ``MATERIALS | {"snow": Material(...)}``.

    Raises
    ------
    InputError
        If a material is unknown.
    """
    mesh = world.mesh if isinstance(world, BuiltWorld) else world
    if material is not None:
        mesh = replace(mesh, material=None, materials=(material,))
    for name in mesh.materials:
        if name not in materials:
            raise InputError(
                f"the mesh has a material {name!r} of which no reflectance is known, expected one of "
                f"{', '.join(materials)}: give one for all triangles as material=…"
            )
    check_choice("ground", ground, tuple(materials))
    if grain is None:
        grain = Grain(seed=world.seed if isinstance(world, BuiltWorld) else 0)
    shape = flat_world(mesh, extent=None if extent is None else np.asarray(extent))
    return LitWorld(shape=shape, sky=sky, grain=grain, ground=ground, shadows=shadows, materials=materials)


def _pack(world: LitWorld) -> PackedLight:
    from insectnav.worlds.shading_kernel import Light

    surfaces = _pack_surfaces(world)
    octaves = pack_octaves(world.grain.seed, world.grain.coarsest, world.grain.n_octaves)
    mesh, sky = world.mesh, world.sky
    corners = mesh.vertices
    parts, part_light = _kept_or_made(world, "parts", (sky,), lambda: sky_parts(sky))
    if world.shadows:
        maps = _kept_or_made(world, "sky maps", (mesh,), lambda: sky_maps(corners, parts))  # whatever the sky
        sun_map = _kept_or_made(world, "sun map", (mesh, sky), lambda: shadow_map(corners, sky.sun))
    else:
        maps, sun_map = sky_maps(corners[:1], parts, 4), shadow_map(corners[:1], sky.sun, 4)
    sun_irradiance = sky.sun_irradiance(LIGHT_BANDS).astype(np.float64)
    radius = sky.sun_diameter / 2.0
    light = Light(
        sun=np.asarray(sky.sun, np.float64),
        sun_irradiance=sun_irradiance,
        disc=sun_irradiance / (2.0 * np.pi * (1.0 - np.cos(radius))),
        disc_cosine=float(np.cos(radius)),
        sky=_kept_or_made(world, "sky", (sky,), lambda: sky_table(sky)),
        part=parts,
        part_light=part_light,
        ground_light=np.zeros(len(LIGHT_BANDS)),
        wall_light=np.zeros(len(LIGHT_BANDS)),
        has_shadows=world.shadows,
    )
    packed = PackedLight(surfaces=surfaces, octaves=octaves, light=light, sun_map=sun_map, sky_maps=maps)
    ground_light, wall_light = _mean_light(world, packed)
    light = light._replace(ground_light=ground_light, wall_light=wall_light)
    return replace(packed, light=light)


def _kept_or_made(world: LitWorld, name: str, causes: tuple[Any, ...], make: Callable[[], Any]) -> Any:
    """What was made last of the same objects for this world, or for one that it was changed from, or what is made now.

    Worlds that differ in materials or sky alone share what does not depend on these, which takes most of the time.
    """
    kept = world._kept.get(name)
    if kept is None or any(one is not other for one, other in zip(kept[0], causes, strict=True)):
        kept = world._kept[name] = (causes, make())
    return kept[1]


def _pack_surfaces(world: LitWorld) -> Any:
    """Normals and optics; the level ground comes last."""
    from insectnav.worlds.shading_kernel import Surfaces

    mesh, materials = world.mesh, (*world.mesh.materials, world.ground)
    corners = mesh.vertices.astype(np.float64)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    known = world.materials
    mirror = mirror_optics(materials, known)
    is_mirror = (mirror[:, 0] > 1.0) | (mirror[:, 2] > 0.0)
    return Surfaces(
        normal=np.concatenate([normal, [[0.0, 0.0, 1.0]]]),
        material=np.append(np.asarray(mesh.material), len(materials) - 1).astype(np.int64),
        diffuse=np.stack([reflectance(materials, band, known) for band in LIGHT_BANDS], axis=-1),
        through=np.stack([transmittance(materials, band, known) for band in LIGHT_BANDS], axis=-1),
        contrast=np.where(is_mirror, 0.0, world.grain.contrast),
        mirror=mirror,
    )


def _mean_light(world: LitWorld, packed: PackedLight) -> tuple[Floats, Floats]:
    """Mean radiance (band,) of the ground and of all that stands on it, by the light that comes straight to them.

    Each triangle is seen at its centre, from its front, and weighs as much as its area. Where the mesh has no ground
    that of the level ground in the open is taken, and where it has nothing but ground, the ground's.
    """
    from insectnav.worlds.shading_kernel import shade_pixels

    mesh, surfaces = world.mesh, packed.surfaces
    corners = mesh.vertices.astype(np.float64)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=-1)
    centre, normal = corners.mean(axis=1), surfaces.normal[:-1]
    diffuse, open_light = surfaces.diffuse, world.sky.irradiance(LIGHT_BANDS) / np.pi
    of_ground = np.array([world.materials[name].is_ground for name in mesh.materials])[np.asarray(mesh.material)]
    plain = surfaces._replace(mirror=np.tile([1.0, 1.0, 0.0], (len(diffuse), 1)), contrast=np.zeros(len(diffuse)))
    n = mesh.n_triangles
    radiance = np.empty((n, len(LIGHT_BANDS)))
    samples = -normal[:, None], np.arange(n, dtype=np.int32)[:, None], np.ones((n, 1), np.float32)
    rest = packed.octaves, packed.light, packed.sun_map, packed.sky_maps
    shade_pixels(samples, centre + normal, 0.0, plain, *rest, radiance)
    level = diffuse[-1] * open_light
    ground = np.average(radiance[of_ground], axis=0, weights=area[of_ground]) if of_ground.any() else level
    walls = ground if of_ground.all() else np.average(radiance[~of_ground], axis=0, weights=area[~of_ground])
    return ground, walls


def sky_table(sky: Sky) -> npt.NDArray[np.float32]:
    """Radiance (row, column, band) of the sky without its disc: elevations 0 to 90°, azimuths −180 to 180°."""
    n_rows, n_columns = round(90.0 / SKY_TABLE_DEG) + 1, round(360.0 / SKY_TABLE_DEG) + 1
    elevation, azimuth = np.linspace(0.0, np.pi / 2, n_rows), np.linspace(-np.pi, np.pi, n_columns)
    rays = directions(azimuth, elevation[:, None])
    return sky.radiance(rays, LIGHT_BANDS, sun_disc=False)


def sky_parts(sky: Sky, n_parts: int = N_SKY_PARTS) -> tuple[Floats, Floats]:
    """Directions (part, 3) of parts of the sky of equal size, and radiance times solid angle of each (part, band).

    Level ground gets from all parts together what it gets from the whole sky without the sun.
    """
    spread = fibonacci(n_parts, (0.0, 90.0)).directions
    fine, weights = sky_quadrature()  # the weights hold the sine of the elevation
    nearest = np.argmax(fine @ spread.T, axis=-1)
    radiance = sky.radiance(fine, LIGHT_BANDS, sun_disc=False) * (weights / fine[:, 2])[:, None]
    light = np.stack([radiance[nearest == part].sum(axis=0) for part in range(n_parts)])
    level = weights @ sky.radiance(fine, LIGHT_BANDS, sun_disc=False)
    return np.asarray(spread, np.float64), light * (level / (spread[:, 2] @ light))
