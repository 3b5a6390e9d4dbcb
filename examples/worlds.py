# %% [markdown]
# # The worlds that can be built
#
# Each from above, and as its inhabitant sees it: what we see, and the ultraviolet that insects see besides. Light comes
# from a clear sky with the sun in the south-east.
#
#     python examples/worlds.py [FOLDER]
#
# leaves worlds.png and worlds.pdf in FOLDER, out/examples by default.

# %%
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from insectnav.experiments.figures import DOUBLE_COLUMN, journal_style, save_figure
from insectnav.vision import AHEAD, Camera, panorama
from insectnav.worlds import light_world, render
from insectnav.worlds.builders import BUILDERS, build_world
from insectnav.worlds.sky import Sky

SEED = 1
VIEWS = {  # way point, as a share of the route, and where the eye looks [rad]
    "ant-world": (0.0, 0.0),
    "shrubland": (1.0, 0.0),
    "city": (0.35, 0.0),
    "forest-trail": (0.25, 0.0),
    "suburban-street": (0.38, 0.0),
}
ELEVATION = (-15.0, 90.0)  # [°]
VISIBLE = ("red", "green", "blue")
sky = Sky(sun_azimuth=np.deg2rad(140.0), sun_elevation=np.deg2rad(40.0), turbidity=3.0)
white = sky.irradiance((*VISIBLE, "uv")) / np.pi  # radiance of a white sheet on the ground


def look(world, position, heading, camera):
    """Red, green and blue (row, column, 3), and ultraviolet, both relative to a white sheet."""
    layers = render(world, [position], heading, camera=camera, layers=(*VISIBLE, "uv"), supersampling=2)
    seen = np.stack([layers[band][0] for band in (*VISIBLE, "uv")], axis=-1) / white
    return seen[..., :3], seen[..., 3]


def from_above(mesh, at):
    """Height [m] and camera that shows a square of the world, as wide as its shorter side, in 240 pixels."""
    (low_x, low_y, _), (high_x, high_y, top) = mesh.bounds
    span = min(high_x - low_x, high_y - low_y)
    low_y = np.clip(at[1] - span / 2, low_y, high_y - span)
    height = 20 * span  # nearly parallel rays
    camera = Camera(
        model="pinhole", size=(240, 240), focal_length=(240 * height / span,) * 2, centre=(120.0, 120.0),
        field=(0.0, 0.5), mounting=(*AHEAD[:1], -np.pi / 2, 0.0),
    )  # fmt: skip
    return (low_x + span / 2, low_y + span / 2, height + top), camera, (low_x, low_x + span, low_y, low_y + span)


def displayed(radiance, exposure):
    """Values for a screen, 0…1."""
    return np.clip(exposure * radiance, 0.0, 1.0) ** (1 / 2.2)


# %% Build them, look around, and draw
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 6.0))
    grid = figure.add_gridspec(len(VIEWS), 3, width_ratios=(1.0, 2.6, 2.6), wspace=0.13, hspace=0.22,
                               left=0.06, right=0.985, bottom=0.065, top=0.965)  # fmt: skip
    for row, (name, (share, heading)) in enumerate(VIEWS.items()):
        world = build_world(name, SEED)
        mesh, route = world.mesh, world.route
        lit = light_world(world, sky)
        at = route[round(share * (len(route) - 1))]
        eye = (*at, world.ground_height(at) + BUILDERS[name].eye_height)
        visible_view, ultraviolet_view = look(lit, eye, heading, panorama(1.0, ELEVATION))
        plan, visible, ultraviolet = (figure.add_subplot(grid[row, column]) for column in range(3))
        above, camera, extent = from_above(mesh, at)
        plan.imshow(displayed(look(lit, above, 0.0, camera)[0], 1.8), extent=extent, interpolation="antialiased")
        plan.plot(*route.T, color="white", linewidth=0.7)
        plan.plot(*at, marker="o", color="#D55E00", markeredgecolor="white", markeredgewidth=0.5, markersize=3.5)
        plan.set(xlim=extent[:2], ylim=extent[2:], aspect="equal", anchor="W", xticks=[])
        plan.set_ylabel("y (m)", labelpad=1.0)
        plan.set_title(f"{'abcde'[row]}  {name}", loc="left", fontsize=7.0)
        for axes, kind, picture, map_name in ((visible, "visible", visible_view, None),
                                              (ultraviolet, "350 nm", ultraviolet_view, "gray")):  # fmt: skip
            bright = displayed(picture, 0.7 / np.quantile(picture, 0.9))
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
