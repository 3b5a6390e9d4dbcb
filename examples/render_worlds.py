# %% [markdown]
# # Every world in daylight
#
# One panorama of each world, in visible light and in the ultraviolet that insects see besides: a clear morning, and the
# suburban street once more under an overcast sky in January.
#
#     python examples/render_worlds.py [FOLDER]
#
# leaves render-worlds.png and render-worlds.pdf in FOLDER, out/examples by default. The same on the command line:
#
#     insectnav render city --at 0,100 --resolution 0.5 --elevation=-30,60

# %%
import sys
import tempfile
from pathlib import Path

from matplotlib.figure import Figure

from insectnav.datasets.image_folder import read_image
from insectnav.experiments.figures import DOUBLE_COLUMN, journal_style, name_panel, save_figure
from insectnav.experiments.rendering.cameras import CameraParams
from insectnav.experiments.rendering.job import run
from insectnav.experiments.rendering.light import LightParams
from insectnav.experiments.rendering.paths import PathParams
from insectnav.experiments.rendering.pictures import PictureParams
from insectnav.experiments.rendering.places import PlaceParams
from insectnav.experiments.rendering.plan import RenderParams, planned

ELEVATION = (-30.0, 60.0)
CAMERA = CameraParams(resolution_deg=0.5, elevation_deg=ELEVATION, supersampling=2)
PICTURES = PictureParams(pictures=("visible", "uv"))
MORNING = LightParams(date="2014-04-11", time="09:00")
JANUARY = LightParams(date="2014-01-15", time="12:00", weather="overcast")
VIEWS = [  # what to call it, world, seed, distance along its route [m], parameters, light
    ("ant world", "ant-world", 1, 5.0, {}, MORNING),
    ("shrubland", "shrubland", 1, 0.2, {}, MORNING),
    ("city", "city", 1, 690.0, {}, MORNING),
    ("forest trail", "forest-trail", 1, 38.0, {}, MORNING),
    ("suburban street", "suburban-street", 1, 76.0, {}, MORNING),
    ("the same street in January, overcast", "suburban-street", 1, 76.0, {"foliage": 0.0}, JANUARY),
]

# %% Render, and draw
with journal_style(), tempfile.TemporaryDirectory() as temporary:
    figure = Figure(figsize=(DOUBLE_COLUMN, 6.6))
    grid = figure.add_gridspec(len(VIEWS), 2, left=0.06, right=0.985, bottom=0.05, top=0.965, wspace=0.05, hspace=0.22)
    for row, (title, world, seed, distance, changes, light) in enumerate(VIEWS):
        plan = planned(
            RenderParams(
                place=PlaceParams(world=world, seed=seed, changes=changes),
                light=light,
                path=PathParams(n_frames=1, start=distance, stop=distance),
                camera=CAMERA,
                pictures=PICTURES,
            )
        )
        frames = Path(temporary) / str(row)
        told = run(plan, frames)
        print(f"{title:38s} {plan.place.mesh.n_triangles:6d} triangles, {told['seconds']:5.1f} s")
        for column, name in enumerate(PICTURES.pictures):
            axes = figure.add_subplot(grid[row, column])
            axes.imshow(read_image(frames / name / "000000.png"), cmap="gray", vmin=0, vmax=255,
                        extent=(-180, 180, *ELEVATION), interpolation="antialiased")  # fmt: skip
            axes.set(xticks=(-180, -90, 0, 90, 180), yticks=(-30, 0, 30, 60))
            axes.tick_params(labelbottom=row == len(VIEWS) - 1, labelleft=column == 0)
            if column == 0:
                name_panel(axes, "abcdef"[row], title)
                axes.set_ylabel("elevation (°)", labelpad=1.0)
            elif row == 0:
                axes.set_title("350 nm", loc="right")
            if row == len(VIEWS) - 1:
                axes.set_xlabel("to the right of straight ahead (°)")
                axes.get_xticklabels()[0].set_horizontalalignment("left")
                axes.get_xticklabels()[-1].set_horizontalalignment("right")
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(figure, folder, "render-worlds")
print(f"figure: {folder / 'render-worlds.png'}")
