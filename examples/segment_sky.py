# %% [markdown]
# # Cutting out the sky
#
# A street and a forest trail under scattered clouds, in colour and at 350 nm. They are rendered, so that no photograph
# is needed and the sky is known exactly. Surfaces carry their texture, windows mirror the sky, shadows are not drawn.
# Numbers for real photographs are in docs/sky-segmentation.md.
#
#     python examples/segment_sky.py [FOLDER]
#
# leaves sky-segmentation.png and sky-segmentation.pdf in FOLDER, out/examples by default.

# %%
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from insectnav.experiments.figures import DOUBLE_COLUMN, journal_style, name_panel, save_figure
from insectnav.experiments.mask_pictures import overlay
from insectnav.metrics.segmentation import accuracy, intersection_over_union, skyline_error
from insectnav.vision.sky_segmentation import segment
from insectnav.worlds import World, render_layers
from insectnav.worlds.builders import BUILDERS, build_world
from insectnav.worlds.clouds import weather_clouds
from insectnav.worlds.materials import MATERIALS, mirror_fraction, reflectance
from insectnav.worlds.sky import Sky
from insectnav.worlds.skylight import BANDS
from insectnav.worlds.texture import texture, textured

SEED = 1
VIEWS = {"city": (0.1, np.pi / 2), "forest-trail": (0.5, 0.0)}  # way point as a share of the route, and heading [rad]
FINE, FACTOR = 0.125, 2  # [°] of the rays, and how many of them along each side of a pixel
ELEVATION, HALF_WIDTH = (-25.0, 45.0), 45.0  # [°] of the picture
NOISE = 0.01  # SD of the sensor as a share of white; assumed
GAMMA = 1.0 / 2.2  # of a camera that writes pictures for a screen
names = list(BANDS)
sky = Sky(sun_azimuth=np.deg2rad(140.0), sun_elevation=np.deg2rad(40.0), turbidity=3.0,
          clouds=weather_clouds("scattered", seed=4))  # fmt: skip


# %% A scene: radiance in each band, a white sheet in the open having 1, and which pixels show sky alone
def illuminated(mesh, normal):
    """Radiance of each triangle (triangle, band) under the sun and the open sky."""
    total, sun = sky.irradiance(names), sky.sun_irradiance(names)
    diffuse = total - sun * np.sin(sky.sun_elevation)
    lit = np.abs(normal @ sky.sun)[:, None] * sun
    light = ((0.5 + 0.5 * np.abs(normal[:, 2:])) * diffuse + lit) / total
    return light * np.stack([reflectance(mesh.materials, band) for band in names], axis=-1)[mesh.material]


def scene(name, share, heading):
    """Radiance (row, column, band) and sky (row, column)."""
    world = build_world(name, SEED)
    mesh, at = world.mesh, world.route[round(share * (len(world.route) - 1))]
    eye = np.array([[at[0], at[1], world.ground_height(at) + BUILDERS[name].eye_height]])
    corners = mesh.vertices.astype(float)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    shade = illuminated(mesh, normal)
    flat = World(mesh=mesh, brightness={"grey": np.zeros(len(corners))}, sky={"grey": 0.0}, ground={"grey": 0.0})
    layers = render_layers(flat, eye, [heading], ("triangle", "depth"), resolution_deg=FINE, elevation_deg=ELEVATION)
    middle, half = layers["triangle"].shape[2] // 2, round(HALF_WIDTH / FINE)
    triangle, depth = (layers[layer][0, :, middle - half : middle + half] for layer in ("triangle", "depth"))
    elevation = np.deg2rad(ELEVATION[1] - (np.arange(triangle.shape[0]) + 0.5) * FINE)[:, None]
    azimuth = heading + np.deg2rad((np.arange(2 * half) + 0.5) * FINE - HALF_WIDTH)
    rays = np.stack(np.broadcast_arrays(np.sin(azimuth) * np.cos(elevation), np.cos(azimuth) * np.cos(elevation),
                                        np.sin(elevation)), axis=-1)  # fmt: skip
    is_sky, is_mesh = triangle == -1, triangle >= 0
    picture = np.broadcast_to(MATERIALS["soil"].diffuse, (*triangle.shape, len(names))).copy()
    white = sky.irradiance(names) / np.pi
    picture[is_sky] = sky.radiance(rays[is_sky], names) / white
    picture[is_mesh] = shade[triangle[is_mesh]]
    grain = texture((eye + rays * np.where(is_sky, 0.0, depth)[..., None])[is_mesh], seed=SEED, coarsest=1.0,
                    n_octaves=7)  # fmt: skip
    picture[is_mesh] = textured(picture[is_mesh], grain[:, None], 0.2)
    for index, material in enumerate(mesh.materials):
        where = is_mesh & (mesh.material[np.maximum(triangle, 0)] == index)
        if where.any() and mirror_fraction(material, 1.0) > 0.0:  # what lies above the horizon is taken for sky
            face = normal[triangle[where]]
            along = (rays[where] * face).sum(axis=-1)
            mirrored = rays[where] - 2 * along[:, None] * face
            share_of_light = mirror_fraction(material, np.minimum(np.abs(along), 1.0))[:, None]
            picture[where] += share_of_light * sky.radiance(mirrored, names, sun_disc=False) / white
    return blocks(picture).mean(axis=(1, 3)), blocks(is_sky).mean(axis=(1, 3)) > 0.5


def blocks(picture):
    rows, columns = picture.shape[0] // FACTOR, picture.shape[1] // FACTOR
    return picture.reshape(rows, FACTOR, columns, FACTOR, *picture.shape[2:])


def photograph(radiance, gamma):
    """What a camera makes of it: exposed for the 98th percentile, with the noise of its sensor, as bytes."""
    exposed = radiance / np.quantile(radiance, 0.98)
    noisy = exposed + np.random.default_rng(SEED).normal(0.0, NOISE, exposed.shape)
    return np.rint(255 * np.clip(noisy, 0.0, 1.0) ** gamma).astype(np.uint8)


# %% Masks by three methods, and how far each is off
white_light = [names.index(band) for band in ("red", "green", "blue")]
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 3.9), layout="constrained")
    panels = iter(figure.subplots(2, 3).flat)
    letters = iter("abcdef")
    for name, (share, heading) in VIEWS.items():
        radiance, truth = scene(name, share, heading)
        colour = photograph(radiance[..., white_light], GAMMA)
        ultraviolet = photograph(radiance[..., names.index("uv")], 1.0)  # linear, as from a raw file
        for title, picture, method in (("colour, Otsu", colour, "otsu"), ("colour, skylight", colour, "skylight"),
                                       ("350 nm, watershed", ultraviolet, "watershed")):  # fmt: skip
            found = segment(picture, method)
            rate, overlap = accuracy(found.mask, truth), intersection_over_union(found.mask, truth)
            off = skyline_error(found.mask, truth)
            axes = next(panels)
            axes.imshow(overlay(picture, found.mask, found.valid), interpolation="antialiased")
            axes.set(xticks=[], yticks=[])
            axes.spines[:].set_visible(False)
            name_panel(axes, next(letters), f"{title}: {100 * rate:.1f} %")
            print(f"{name:14s} {title:20s} accuracy {100 * rate:5.1f} %, IoU {overlap:.3f}, skyline {off:4.1f} px off, "
                  f"confidence {found.confidence:.2f}")  # fmt: skip

    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(figure, folder, "sky-segmentation")
print(f"figure: {folder / 'sky-segmentation.png'}")
