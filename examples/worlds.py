# %% [markdown]
# # The worlds that can be built
#
# Each from above, and as its inhabitant sees it: what we see, and the ultraviolet that insects see besides. Light comes
# from a clear sky with the sun in the south-east; the surfaces carry their texture; shadows are not drawn.
#
#     python examples/worlds.py [FOLDER]
#
# leaves worlds.png and worlds.pdf in FOLDER, out/examples by default.

# %%
import sys
from pathlib import Path

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from insectnav.experiments.figures import DOUBLE_COLUMN, journal_style, save_figure
from insectnav.worlds import World, render_layers
from insectnav.worlds.builders import BUILDERS, build_world
from insectnav.worlds.materials import MATERIALS, mirror_fraction, reflectance
from insectnav.worlds.sky import Sky
from insectnav.worlds.skylight import BANDS
from insectnav.worlds.texture import texture, textured

SEED = 1
VIEWS = {  # way point, as a share of the route, and where the eye looks [rad]
    "ant-world": (0.0, 0.0),
    "shrubland": (1.0, 0.0),
    "city": (0.35, 0.0),
    "forest-trail": (0.25, 0.0),
    "suburban-street": (0.38, 0.0),
}
TWO_SIDED = ("leaves", "straw", "needles")
FINE, COARSE = 0.5, 1.0  # [°] of the rays and of the pixels
ELEVATION = (-15.0, 90.0)
sky = Sky(sun_azimuth=np.deg2rad(140.0), sun_elevation=np.deg2rad(40.0), turbidity=3.0)
names = list(BANDS)


def illuminated(mesh):
    """Radiance of each triangle in each band (triangle, band); a white sheet on level ground has 1."""
    corners = mesh.vertices.astype(float)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    total, sun = sky.irradiance(names), sky.sun_irradiance(names)
    diffuse = total - sun * np.sin(sky.sun_elevation)
    facing = normal @ sky.sun
    leaf = np.isin(np.array(mesh.materials)[mesh.material], TWO_SIDED)
    lit = np.where(leaf, 0.5 * np.abs(facing), np.maximum(facing, 0.0))  # half goes through a leaf, or is in the shade
    open_sky = np.where(leaf, 0.5, 0.5 + 0.5 * normal[:, 2])
    light = (open_sky[:, None] * diffuse + lit[:, None] * sun) / total
    return light * np.stack([reflectance(mesh.materials, band) for band in names], axis=-1)[mesh.material]


def panorama(world, position, heading):
    """What an eye sees in each band, (row, column, band) at 1°, and which part of it is sky."""
    shade = illuminated(world.mesh)
    bright = {band: np.clip(shade[:, k], 0.0, 1.0) for k, band in enumerate(names)}
    ground = dict(zip(names, MATERIALS["soil"].diffuse, strict=True))
    scene = World(mesh=world.mesh, brightness=bright, sky=dict.fromkeys(names, 0.0), ground=ground)
    layers = render_layers(
        scene, position, heading, ("triangle", "depth"), resolution_deg=FINE, elevation_deg=ELEVATION
    )
    triangle, depth = layers["triangle"][0], layers["depth"][0]
    rows, columns = triangle.shape
    elevation = np.deg2rad(ELEVATION[1] - (np.arange(rows) + 0.5) * FINE)[:, None]
    azimuth = heading[0] + np.deg2rad((np.arange(columns) + 0.5) * FINE - 180.0)
    east, north, up = np.sin(azimuth) * np.cos(elevation), np.cos(azimuth) * np.cos(elevation), np.sin(elevation)
    rays = np.stack(np.broadcast_arrays(east, north, up), axis=-1)
    is_sky, is_mesh = triangle == -1, triangle >= 0
    picture = np.broadcast_to(MATERIALS["soil"].diffuse, (rows, columns, 4)).copy()
    skylight = sky.radiance(rays, names) * np.pi / sky.irradiance(names)
    picture[is_sky] = skylight[is_sky]
    picture[is_mesh] = shade[triangle[is_mesh]]
    points = position + rays * np.where(np.isfinite(depth), depth, 0.0)[..., None]
    grain = texture(points[is_mesh], seed=SEED, coarsest=1.0, n_octaves=7)
    picture[is_mesh] = textured(picture[is_mesh], grain[:, None], 0.2)
    add_mirrored_sky(picture, world.mesh, triangle, rays)
    factor = round(COARSE / FINE)
    blocks = picture.reshape(rows // factor, factor, columns // factor, factor, 4)
    return blocks.mean(axis=(1, 3))


def add_mirrored_sky(picture, mesh, triangle, rays):
    """Windows, cars and metal mirror what is above the horizon; that another thing may be there is left out."""
    corners = mesh.vertices.astype(float)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    for index, name in enumerate(mesh.materials):
        where = (triangle >= 0) & (mesh.material[np.maximum(triangle, 0)] == index)
        if not where.any() or mirror_fraction(name, 1.0) == 0.0:
            continue
        face = normal[triangle[where]]
        along = (rays[where] * face).sum(axis=-1)
        mirrored = rays[where] - 2 * along[:, None] * face
        mirrored /= np.linalg.norm(mirrored, axis=-1, keepdims=True)
        share = mirror_fraction(name, np.minimum(np.abs(along), 1.0))[:, None]
        picture[where] += share * sky.radiance(mirrored, names, sun_disc=False) * np.pi / sky.irradiance(names)


def displayed(radiance, exposure):
    """Values for a screen, 0…1."""
    return np.clip(exposure * radiance, 0.0, 1.0) ** (1 / 2.2)


# %% Build them, look around, and draw
WHITE = [names.index(band) for band in ("red", "green", "blue")]
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 6.0))
    grid = figure.add_gridspec(len(VIEWS), 3, width_ratios=(1.0, 2.6, 2.6), wspace=0.13, hspace=0.22,
                               left=0.06, right=0.985, bottom=0.065, top=0.965)  # fmt: skip
    for row, (name, (share, heading)) in enumerate(VIEWS.items()):
        world = build_world(name, SEED)
        mesh, route = world.mesh, world.route
        at = route[round(share * (len(route) - 1))]
        eye = np.array([[at[0], at[1], world.ground_height(at) + BUILDERS[name].eye_height]])
        view = panorama(world, eye, np.array([heading]))
        plan, visible, ultraviolet = (figure.add_subplot(grid[row, column]) for column in range(3))
        colours = displayed(illuminated(mesh)[:, WHITE], 1.8)
        order = np.argsort(mesh.vertices[:, :, 2].max(axis=1), kind="stable")
        plan.add_collection(PolyCollection(mesh.vertices[order, :, :2], facecolors=colours[order],
                                           linewidths=0.0, antialiased=False, rasterized=True))  # fmt: skip
        plan.plot(*route.T, color="white", linewidth=0.7)
        plan.plot(*at, marker="o", color="#D55E00", markeredgecolor="white", markeredgewidth=0.5, markersize=3.5)
        (low_x, low_y, _), (high_x, high_y, _) = mesh.bounds
        span = min(high_x - low_x, high_y - low_y)  # a square of it, the eye within
        low_y = np.clip(at[1] - span / 2, low_y, high_y - span)
        plan.set(xlim=(low_x, low_x + span), ylim=(low_y, low_y + span), aspect="equal", anchor="W", xticks=[])
        plan.set_ylabel("y (m)", labelpad=1.0)
        plan.set_title(f"{'abcde'[row]}  {name}", loc="left", fontsize=7.0)
        for axes, kind, picture, map_name in ((visible, "visible", view[..., WHITE], None),
                                              (ultraviolet, "350 nm", view[..., 0], "gray")):  # fmt: skip
            bright = displayed(picture, 0.7 / np.quantile(picture.mean(axis=2) if picture.ndim > 2 else picture, 0.97))
            axes.imshow(
                bright, cmap=map_name, vmin=0, vmax=1, extent=(-180, 180, *ELEVATION), interpolation="antialiased"
            )
            axes.set(xticks=(-180, -90, 0, 90, 180), yticks=(0, 45, 90))
            axes.tick_params(labelbottom=row == len(VIEWS) - 1, labelleft=axes is visible)
            axes.set_xlabel("to the right of straight ahead (°)" if row == len(VIEWS) - 1 else "")
            axes.set_ylabel("elevation (°)" if axes is visible else "", labelpad=1.0)
            if row == 0:
                axes.set_title(kind, fontsize=7.0)
        print(f"{name:16s} {mesh.n_triangles:6d} triangles, {len(route):5d} way points")
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(figure, folder, "worlds")
print(f"figure: {folder / 'worlds.png'}")
