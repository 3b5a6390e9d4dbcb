"""Shadow maps: which places a far light reaches, the sun or a part of the sky."""

from typing import Any

import numpy as np

from insectnav.angles import Floats

MAX_PIXELS = 4096  # along a side of the sun's map, 64 MiB
SKY_PIXELS = 512  # along a side of the map of each part of the sky
LEAST_PIXEL = 0.004  # [m]


def shadow_map(corners: Any, towards: Floats, n_pixels: int = MAX_PIXELS, least_pixel: float = LEAST_PIXEL) -> Any:
    """Map of the depths of triangles along a direction, for `insectnav.worlds.shadow_kernel.lit_share`.

    Parameters
    ----------
    corners : (triangle, 3, 3) array [m]
    towards : (3,) unit vector to the light
    n_pixels : int
        Along the longer side.
    least_pixel : float
        Size of the pixels if there would be more than needed [m].

    Notes
    -----
    Williams 1978, doi 10.1145/965139.807402, with parallel light; edges mixed after Reeves, Salesin & Cook 1987, doi
    10.1145/37402.37435.
    """
    from insectnav.worlds.shadow_kernel import NOTHING, ShadowMap, draw_depths

    frame = light_frame(towards)
    plane = np.asarray(corners, np.float64).reshape(-1, 3) @ frame[:2].T
    low, high = plane.min(axis=0), plane.max(axis=0)
    pixel = max(float((high - low).max()) / (n_pixels - 2), least_pixel)
    n_columns, n_rows = (int(n) + 2 for n in np.ceil((high - low) / pixel))
    found = ShadowMap(
        depth=np.full((n_rows, n_columns), NOTHING, np.float32), frame=frame, corner=low - pixel, pixel=pixel
    )
    draw_depths(np.ascontiguousarray(corners, np.float32), found)
    return found


def sky_maps(corners: Any, directions: Floats, n_pixels: int = SKY_PIXELS) -> Any:
    """Coarse maps for many directions (direction, 3) at once, for `insectnav.worlds.shadow_kernel.is_open`."""
    from insectnav.worlds.shadow_kernel import NOTHING, ShadowMap

    maps = [shadow_map(corners, towards, n_pixels) for towards in directions]
    n_rows, n_columns = (max(found.depth.shape[axis] for found in maps) for axis in (0, 1))
    depth = np.full((len(maps), n_rows, n_columns), NOTHING, np.float32)
    for k, found in enumerate(maps):
        depth[k, : found.depth.shape[0], : found.depth.shape[1]] = found.depth
    return ShadowMap(
        depth=depth,
        frame=np.stack([found.frame for found in maps]),
        corner=np.stack([found.corner for found in maps]),
        pixel=np.array([found.pixel for found in maps]),
    )


def light_frame(towards: Floats) -> Floats:
    """Orthonormal rows (3, 3): across, up and towards the light."""
    towards = np.asarray(towards, np.float64)
    aside = np.array([1.0, 0.0, 0.0]) if abs(towards[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    across = np.cross(aside, towards)
    across /= np.linalg.norm(across)
    return np.stack([across, np.cross(towards, across), towards])
