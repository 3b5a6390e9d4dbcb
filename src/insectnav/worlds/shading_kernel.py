"""Light on surfaces, compiled: what radiance comes from each sample of a pixel, and their mean.

Sunlight falls on what no other surface keeps it from (`insectnav.worlds.shadow_kernel`). Skylight comes from some tens
of parts of the sky, each of which may be hidden; where one is hidden, the light of what stands in the world comes
instead, and from below the horizon that of the ground. Thin things, as leaves, let a share of the light through.
"""

from typing import Any, NamedTuple

import numpy as np

from insectnav.lanes.compiled import kernel, lane_function
from insectnav.worlds.shadow_kernel import is_open, lit_share
from insectnav.worlds.texture_kernel import texture_at

N_BANDS = 4
SKY = -1  # in place of the index of a triangle; any other below 0 is the level ground


class Surfaces(NamedTuple):
    """What light falls on."""

    normal: Any  # (triangle + 1, 3) unit vectors; the last is the level ground's
    material: Any  # (triangle + 1,)
    diffuse: Any  # (material, band) share of the light that is scattered back
    through: Any  # (material, band) share that is scattered to the other side
    contrast: Any  # (material,) of the texture
    mirror: Any  # (material, 3) refractive index, number of surfaces, share mirrored by bare metal


class Light(NamedTuple):
    """Light of one moment; radiance in W m⁻² nm⁻¹ sr⁻¹, irradiance in W m⁻² nm⁻¹."""

    sun: Any  # (3,) unit vector
    sun_irradiance: Any  # (band,) of a plane that faces it
    disc: Any  # (band,) radiance of its disc
    disc_cosine: float  # of the radius of the disc
    sky: Any  # (row, column, band) radiance at elevations from 0 to 90° and azimuths from −180 to 180°, ends included
    part: Any  # (part, 3) unit vectors to parts of the sky
    part_light: Any  # (part, band) radiance times solid angle
    ground_light: Any  # (band,) radiance of the ground around
    wall_light: Any  # (band,) radiance of what stands around
    has_shadows: bool


@lane_function
def sky_place(light, x, y, z):
    """Entry of the table of the sky below and left of a direction, and how far it is to the next."""
    n_rows, n_columns = light.sky.shape[0], light.sky.shape[1]
    row = np.arctan2(max(z, 0.0), np.sqrt(x * x + y * y)) * (n_rows - 1) / (0.5 * np.pi)
    column = (np.arctan2(x, y) + np.pi) * (n_columns - 1) / (2.0 * np.pi)
    i, j = min(np.int64(row), n_rows - 2), min(np.int64(column), n_columns - 2)
    return i, j, row - i, column - j


@lane_function
def sky_radiance(light, place, band):
    """Radiance of the sky without the sun's disc, between four entries of the table."""
    table, (i, j, a, b) = light.sky, place
    low = table[i, j, band] * (1.0 - b) + table[i, j + 1, band] * b
    high = table[i + 1, j, band] * (1.0 - b) + table[i + 1, j + 1, band] * b
    return low * (1.0 - a) + high * a


@lane_function
def sun_in(light, x, y, z):
    """1 where a direction hits the sun's disc, else 0."""
    return 1.0 if x * light.sun[0] + y * light.sun[1] + z * light.sun[2] >= light.disc_cosine else 0.0


@lane_function
def mirrored_share(mirror, material, cosine):
    """Share that a surface mirrors: Fresnel's equations for a pile of plates, see `materials.mirror_fraction`."""
    index, n, metal = mirror[material, 0], mirror[material, 1], mirror[material, 2]
    if metal > 0.0:
        return metal
    if index == 1.0:
        return 0.0
    inside = np.sqrt(1.0 - (1.0 - cosine * cosine) / (index * index))
    across = ((cosine - index * inside) / (cosine + index * inside)) ** 2
    upright = ((index * cosine - inside) / (index * cosine + inside)) ** 2
    return 0.5 * (n * across / (1.0 + (n - 1.0) * across) + n * upright / (1.0 + (n - 1.0) * upright))


@lane_function
def gather_skylight(light, sky_maps, point, normal, front, back):
    """Irradiance of both sides of a surface by the sky and by what hides parts of it, into front and back (band,)."""
    nx, ny, nz = normal
    below = 0.5 * np.pi * (1.0 - nz)  # of the ground seen by the front, as the sky of even radiance would be
    for band in range(N_BANDS):
        front[band] = below * light.ground_light[band]
        back[band] = (np.pi - below) * light.ground_light[band]
    solid_angle = 2.0 * np.pi / light.part.shape[0]
    for k in range(light.part.shape[0]):
        cosine = nx * light.part[k, 0] + ny * light.part[k, 1] + nz * light.part[k, 2]
        side = 1.0 if cosine >= 0.0 else -1.0
        free = (not light.has_shadows) or is_open(
            sky_maps, k, point[0], point[1], point[2], side * nx, side * ny, side * nz
        )
        for band in range(N_BANDS):
            comes = light.part_light[k, band] if free else solid_angle * light.wall_light[band]
            if cosine >= 0.0:
                front[band] += comes * cosine
            else:
                back[band] -= comes * cosine


@lane_function
def mirrored_light(light, sky_maps, point, normal, ray, sunlit, mirrored):
    """Radiance from where a mirror looks, into mirrored (band,); whether it is free is asked of the nearest part."""
    along = ray[0] * normal[0] + ray[1] * normal[1] + ray[2] * normal[2]
    x, y, z = ray[0] - 2 * along * normal[0], ray[1] - 2 * along * normal[1], ray[2] - 2 * along * normal[2]
    free = z >= 0.0
    if free and light.has_shadows:
        nearest, best = 0, -2.0
        for k in range(light.part.shape[0]):
            cosine = x * light.part[k, 0] + y * light.part[k, 1] + z * light.part[k, 2]
            if cosine > best:
                nearest, best = k, cosine
        free = is_open(sky_maps, nearest, point[0], point[1], point[2], normal[0], normal[1], normal[2])
    glint, place = sunlit * sun_in(light, x, y, z), sky_place(light, x, y, z)
    for band in range(N_BANDS):
        if free:
            mirrored[band] = sky_radiance(light, place, band) + glint * light.disc[band]
        else:
            mirrored[band] = light.wall_light[band] if z >= 0.0 else light.ground_light[band]


@lane_function
def sun_cosine(light, normal):
    """Cosine of the angle between the normal and the sun."""
    return normal[0] * light.sun[0] + normal[1] * light.sun[1] + normal[2] * light.sun[2]


@lane_function
def sunlight(light, sun_map, point, normal):
    """Share of the sunlight that reaches a point."""
    if not light.has_shadows:
        return 1.0
    side = 1.0 if sun_cosine(light, normal) >= 0.0 else -1.0
    return lit_share(sun_map, point[0], point[1], point[2], side * normal[0], side * normal[1], side * normal[2])


@lane_function
def facing_normal(surfaces, index, ray):
    """Normal of a triangle on the side from which it is seen."""
    x, y, z = surfaces.normal[index, 0], surfaces.normal[index, 1], surfaces.normal[index, 2]
    side = -1.0 if x * ray[0] + y * ray[1] + z * ray[2] > 0.0 else 1.0
    return side * x, side * y, side * z


@lane_function
def find_point(eye, ray, triangle, nearness):
    """Where a ray ends on a triangle or the level ground, and how far that is."""
    if triangle >= 0:
        distance = 1.0 / nearness
    else:
        distance = min(-eye[2] / min(ray[2], -1e-9), 1e6)
    return (eye[0] + distance * ray[0], eye[1] + distance * ray[1], eye[2] + distance * ray[2]), distance


@lane_function
def grain(surfaces, octaves, material, point, width):
    """Factor of the texture on the reflectance, not below 0."""
    contrast = surfaces.contrast[material]
    if contrast == 0.0:
        return 1.0
    return max(1.0 + contrast * texture_at(point[0], point[1], point[2], octaves, width), 0.0)


@lane_function
def add_sky(light, ray, total, pixel):
    """Add what a ray brings from the sky."""
    disc, place = sun_in(light, ray[0], ray[1], ray[2]), sky_place(light, ray[0], ray[1], ray[2])
    for band in range(N_BANDS):
        total[pixel, band] += sky_radiance(light, place, band) + disc * light.disc[band]


@lane_function
def add_surface(surfaces, light, sun_map, sky_maps, point, normal, ray, material, texture, work, total, pixel):
    """Add what a ray brings from a surface on which the skylight (front and back in work) is known."""
    front, back, mirrored = work[0], work[1], work[2]
    towards_sun, sunlit = sun_cosine(light, normal), sunlight(light, sun_map, point, normal)
    cosine = -(ray[0] * normal[0] + ray[1] * normal[1] + ray[2] * normal[2])
    share = mirrored_share(surfaces.mirror, material, min(cosine, 1.0))
    if share > 0.0:
        mirrored_light(light, sky_maps, point, normal, ray, sunlit, mirrored)
    for band in range(N_BANDS):
        direct = light.sun_irradiance[band] * sunlit * abs(towards_sun)
        lit = front[band] + (direct if towards_sun > 0.0 else 0.0)
        behind = back[band] + (direct if towards_sun < 0.0 else 0.0)
        diffuse, through = surfaces.diffuse[material, band], surfaces.through[material, band]
        most = 1.0 / (diffuse + through)  # of the factor: no more light leaves than came
        radiance = min(texture, most) * (diffuse * lit + through * behind) / np.pi
        total[pixel, band] += radiance + (share * mirrored[band] if share > 0.0 else 0.0)


@kernel
def shade_pixels(samples, eyes, pixel_angle, surfaces, octaves, light, sun_map, sky_maps, total):
    """Write the mean radiance (pixel, band) of the samples of each pixel to ``total``.

    Skylight and texture are found once for each surface within a pixel, at the first sample that meets it; sun, shadow
    and mirrors for each sample. ``samples`` are rays, triangles and nearness, ``eyes`` (pixel, 3) where the rays start,
    ``pixel_angle`` [rad] what the texture is blurred over.
    """
    rays, triangles, nearness = samples
    n_pixels, n_samples, n_triangles = rays.shape[0], rays.shape[1], surfaces.material.shape[0] - 1
    work = np.empty(N_BANDS), np.empty(N_BANDS), np.empty(N_BANDS)
    for pixel in range(n_pixels):
        eye, known, texture = (eyes[pixel, 0], eyes[pixel, 1], eyes[pixel, 2]), -3, 1.0
        for band in range(N_BANDS):
            total[pixel, band] = 0.0
        for sample in range(n_samples):
            ray = rays[pixel, sample, 0], rays[pixel, sample, 1], rays[pixel, sample, 2]
            triangle = triangles[pixel, sample]
            if triangle == SKY:
                add_sky(light, ray, total, pixel)
                continue
            index = triangle if triangle >= 0 else n_triangles
            material, normal = surfaces.material[index], facing_normal(surfaces, index, ray)
            point, distance = find_point(eye, ray, triangle, nearness[pixel, sample])
            if index != known:
                known = index
                gather_skylight(light, sky_maps, point, normal, work[0], work[1])
                cosine = -(ray[0] * normal[0] + ray[1] * normal[1] + ray[2] * normal[2])
                width = distance * pixel_angle / np.sqrt(max(cosine, 0.01))
                texture = grain(surfaces, octaves, material, point, width)
            add_surface(surfaces, light, sun_map, sky_maps, point, normal, ray, material, texture, work, total, pixel)
        for band in range(N_BANDS):
            total[pixel, band] /= n_samples
