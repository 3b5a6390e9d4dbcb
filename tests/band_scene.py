"""A rendered street in two bands that look different, and pictures of it by a camera that has moved."""

from functools import lru_cache

import numpy as np
from scipy.ndimage import map_coordinates

from insectnav.worlds import World, render_layers
from insectnav.worlds.builders import BUILDERS, build_world
from insectnav.worlds.materials import reflectance
from insectnav.worlds.texture import texture, textured

FINE = 2  # pixels of the rendering in a pixel of the picture, along each side
RESOLUTION_DEG = 0.125  # of the rendering
ELEVATION_DEG = (-15.0, 60.0)
SKY = {"uv": 0.9, "green": 0.45}  # brightness, assumed
GROUND = {"uv": 0.03, "green": 0.12}


@lru_cache(maxsize=1)
def scene() -> dict[str, np.ndarray]:
    """Brightness (rows, columns) of each band, in 0…1, all round."""
    built = build_world("city", 1)
    bright = {band: reflectance(built.mesh.materials, band)[built.mesh.material] for band in SKY}
    world = World(mesh=built.mesh, brightness=bright, sky=SKY, ground=GROUND)
    at = built.route[len(built.route) // 3]
    eye = np.array([[*at, built.ground_height(at) + BUILDERS["city"].eye_height]])
    layers = render_layers(
        world, eye, np.zeros(1), (*SKY, "depth"), resolution_deg=RESOLUTION_DEG, elevation_deg=ELEVATION_DEG
    )
    depth = layers["depth"][0]
    rows, columns = depth.shape
    elevation = np.deg2rad(ELEVATION_DEG[1] - (np.arange(rows) + 0.5) * RESOLUTION_DEG)[:, None]
    azimuth = np.deg2rad((np.arange(columns) + 0.5) * RESOLUTION_DEG - 180.0)
    rays = np.stack(
        [np.sin(azimuth) * np.cos(elevation), np.cos(azimuth) * np.cos(elevation), np.sin(elevation) + 0 * azimuth],
        axis=-1,
    )
    is_near = np.isfinite(depth)
    grain = texture((eye + rays * np.where(is_near, depth, 0.0)[..., None])[is_near], seed=2, n_octaves=6)
    found = {}
    for band in SKY:
        found[band] = layers[band][0].astype(float)
        found[band][is_near] = textured(found[band][is_near], grain, 0.3)
    return found


def photograph(
    band: str,
    shape: tuple[int, int],
    matrix: np.ndarray | None = None,
    corner: tuple[int, int] = (60, 300),
    noise: float = 0.01,
    seed: int = 0,
) -> np.ndarray:
    """Brightness of a band in 0…1, (rows, columns), by a camera with noise.

    ``matrix`` (2, 3) leads from a pixel of an unmoved picture to where this one shows it; pixels as columns and rows,
    the first one's centre at (0.5, 0.5). ``corner`` is the upper left one of the unmoved picture, in the rendering.
    """
    rows, columns = np.indices(shape) + 0.5
    if matrix is not None:
        back = np.linalg.inv(np.vstack([matrix, [0.0, 0.0, 1.0]]))
        columns, rows = (
            back[0, 0] * columns + back[0, 1] * rows + back[0, 2],
            (back[1, 0] * columns + back[1, 1] * rows + back[1, 2]),
        )
    places = FINE * np.stack([rows, columns]) - 0.5 + np.array(corner)[:, None, None]
    parts = [
        map_coordinates(scene()[band], places + np.array([dr, dc])[:, None, None], order=1, mode="nearest")
        for dr in (-0.5, 0.5)
        for dc in (-0.5, 0.5)
    ]
    grain = np.random.default_rng([seed, len(band)]).normal(0.0, noise, shape)
    return np.clip(np.mean(parts, axis=0) + grain, 0.0, 1.0)


def moved(
    shape: tuple[int, int],
    shift: tuple[float, float] = (0.0, 0.0),
    rotation_deg: float = 0.0,
    scale: float = 1.0,
    shear: float = 0.0,
) -> np.ndarray:
    """Matrix (2, 3) of a motion about the middle of a picture: scaled, sheared, turned clockwise, then shifted."""
    angle = np.deg2rad(rotation_deg)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    linear = scale * turn @ np.array([[1.0, shear], [0.0, 1.0]])
    middle = np.array(shape)[::-1] / 2.0
    return np.hstack([linear, (middle + shift - linear @ middle)[:, None]])
