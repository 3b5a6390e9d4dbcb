# %% [markdown]
# # One street on two days
#
# A short walk along the suburban street, twice: on a clear morning in April, and on an overcast day in January when the
# trees are bare, cars and people are elsewhere, and the camera sways otherwise. The frames, their exact sky masks and
# their poses are what place recognition is trained and tested on.
#
#     python examples/render_traverse.py [FOLDER]
#
# leaves render-traverse.png and render-traverse.pdf in FOLDER, out/examples by default. The same on the command line:
#
#     insectnav render suburban-street --seed 1 --frames 3 --start 40 --stop 80 --out april --resolution 2 \
#         --yaw-jitter 6 --pitch-jitter 6 --roll-jitter 6 --lateral-jitter 0.3
#     insectnav render suburban-street --seed 1 --frames 3 --start 40 --stop 80 --out january --resolution 2 \
#         --yaw-jitter 6 --pitch-jitter 6 --roll-jitter 6 --lateral-jitter 0.3 --jitter-seed 1 \
#         --date 2014-01-15 --time 12:00 --weather overcast --foliage 0 --world-time 500

# %%
import csv
import sys
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from insectnav.datasets.image_folder import read_image
from insectnav.experiments.figures import DOUBLE_COLUMN, journal_style, save_figure
from insectnav.experiments.rendering.cameras import CameraParams
from insectnav.experiments.rendering.job import run
from insectnav.experiments.rendering.light import LightParams
from insectnav.experiments.rendering.paths import PathParams
from insectnav.experiments.rendering.places import PlaceParams
from insectnav.experiments.rendering.plan import RenderParams, planned

N_FRAMES, PICTURES = 3, ("visible", "uv", "sky_mask")
SWAY = {"yaw_jitter_deg": 6.0, "pitch_jitter_deg": 6.0, "roll_jitter_deg": 6.0, "lateral_jitter": 0.3}
DAYS = {
    "clear, April": RenderParams(
        place=PlaceParams(world="suburban-street", seed=1, changes={}),
        light=LightParams(date="2014-04-11", time="09:00"),
        path=PathParams(n_frames=N_FRAMES, start=40.0, stop=80.0, jitter_seed=0, **SWAY),
        camera=CameraParams(resolution_deg=2.0, elevation_deg=(-30.0, 90.0)),
    ),
    "overcast, January": RenderParams(
        place=PlaceParams(world="suburban-street", seed=1, changes={"foliage": 0.0}, world_time_s=500.0),
        light=LightParams(date="2014-01-15", time="12:00", weather="overcast"),
        path=PathParams(n_frames=N_FRAMES, start=40.0, stop=80.0, jitter_seed=1, **SWAY),
        camera=CameraParams(resolution_deg=2.0, elevation_deg=(-30.0, 90.0)),
    ),
}


def frames_of(folder):
    """Rows of the table of a traverse, and its pictures by name, (frame, row, column, ...)."""
    with (folder / "frames.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    return rows, {
        name: np.stack([read_image(folder / name / f"{row['file']}.png") for row in rows]) for name in PICTURES
    }


# %% Walk on both days, then look at the same places side by side
with tempfile.TemporaryDirectory() as temporary:
    walks = {}
    for number, (day, params) in enumerate(DAYS.items()):
        told = run(planned(params), Path(temporary) / str(number))
        walks[day] = frames_of(Path(temporary) / str(number))
        print(f"{day}: {told['frames']} frames in {told['seconds']:.1f} s")

(_, april), (_, january) = walks.values()
same = [np.mean(one == other) for one, other in zip(april["sky_mask"], january["sky_mask"], strict=True)]
print("sky masks of the two days agree in", ", ".join(f"{100 * share:.0f} %" for share in same), "of their pixels")

# %% Draw
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 4.9))
    halves = figure.add_gridspec(2, 1, left=0.075, right=0.985, bottom=0.08, top=0.93, hspace=0.2)
    for day, (title, (rows, pictures)) in enumerate(walks.items()):
        grid = halves[day].subgridspec(len(PICTURES), N_FRAMES, wspace=0.05, hspace=0.08)
        for line, name in enumerate(PICTURES):
            for column, row in enumerate(rows):
                axes = figure.add_subplot(grid[line, column])
                axes.imshow(pictures[name][column], cmap="gray", vmin=0, vmax=255, extent=(-180, 180, -30, 90),
                            aspect="auto")  # fmt: skip
                is_lowest = day == 1 and line == len(PICTURES) - 1
                axes.set(xticks=(-90, 0, 90), yticks=(0, 90))
                axes.tick_params(labelbottom=is_lowest, labelleft=column == 0)
                if is_lowest:
                    axes.set_xlabel("to the right of straight ahead (°)", labelpad=1.0)
                if column == 0:
                    axes.set_ylabel({"visible": "visible", "uv": "350 nm", "sky_mask": "mask"}[name], labelpad=1.0)
                if line == 0:
                    pitch, roll = (round(float(row[f"{angle}_deg"])) for angle in ("pitch", "roll"))
                    axes.text(1.0, 1.03, f"pitch {pitch}°, roll {roll}°", fontsize=6.0, ha="right", va="bottom",
                              transform=axes.transAxes)  # fmt: skip
                    if column == 0:
                        heading = f"$\\mathbf{{{'ab'[day]}}}$  {title}"
                        axes.text(0.0, 1.03, heading, fontsize=8.0, va="bottom", transform=axes.transAxes)
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(figure, folder, "render-traverse")
print(f"figure: {folder / 'render-traverse.png'}")
