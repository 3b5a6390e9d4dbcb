# %% [markdown]
# # Two folders of pictures: where was each of the second taken?
#
# A rendered city is walked twice, in May and in January, and an ultraviolet camera that sees all round leaves a folder
# of pictures of each walk, with a table of where they were taken. The command line makes a map of the first folder and
# finds the pictures of the second in it; the page that it leaves shows how well. With folders of your own begin at "A
# map".
#
#     python examples/place_map_from_folders.py [FOLDER]

# %%
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np

from insectnav.angles import bearing, wrap
from insectnav.vision import panorama
from insectnav.worlds import light_world, render
from insectnav.worlds.builders import build_world
from insectnav.worlds.sky import Sky

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples/place-map")
folder.mkdir(parents=True, exist_ok=True)


# %% Two walks of 700 m, a picture every 5 m and every 5.5 m, 2 m above the ground, in pixels of 3°
def walk(name, world, sky, start, spacing, aside, sway_deg, seed):
    """Leave pictures of ultraviolet light along the world's route, and the table of their positions."""
    reached = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(world.route, axis=0), axis=1))])
    along = np.arange(start, 700.0, spacing)
    here, before, after = (
        np.stack([np.interp(along + step, reached, world.route[:, k]) for k in (0, 1)], axis=-1) for step in (0, -1, 1)
    )
    heading = bearing(after - before)
    place = here + aside * np.stack([np.cos(heading), -np.sin(heading)], axis=-1)  # to the right of the way
    sway = np.deg2rad(sway_deg) * np.random.default_rng(seed).normal(size=len(place))
    eye = np.column_stack([place, np.full(len(place), 2.0)])
    camera = panorama(3.0)  # from −15° to 90°
    light = render(light_world(world, sky), eye, wrap(heading + sway), camera=camera, layers=("uv",), supersampling=2)
    grey = np.clip(255.0 * (light["uv"] / np.quantile(light["uv"], 0.97)) ** 0.45, 0, 255).astype(np.uint8)
    (folder / name).mkdir(exist_ok=True)
    rows = ["file,x_m,y_m"]
    for k, (picture, (x, y)) in enumerate(zip(grey, place, strict=True)):
        cv2.imwrite(str(folder / name / f"{k:04d}.png"), picture)
        rows.append(f"{k:04d}.png,{x:.3f},{y:.3f}")
    (folder / f"{name}.csv").write_text("\n".join(rows) + "\n")


may = build_world("city", seed=1)
january = build_world("city", seed=1, foliage=0.1, time_s=500.0)  # leaves have gone, cars and people moved on
high_sun = Sky(sun_azimuth=np.deg2rad(140.0), sun_elevation=np.deg2rad(45.0))
low_sun = Sky(sun_azimuth=np.deg2rad(220.0), sun_elevation=np.deg2rad(12.0))
walk("may", may, high_sun, 0.0, 5.0, 0.0, 0.0, seed=1)
walk("january", january, low_sun, 20.0, 5.5, -1.0, 8.0, seed=2)


# %% A map of the first folder, and the second located in it: what one types in a shell
def insectnav(*words):
    """Run the command and show what it says."""
    print("$ insectnav", *(word.replace(f"{folder}/", "") for word in words))
    done = subprocess.run([sys.executable, "-m", "insectnav.cli", *words], capture_output=True, encoding="utf-8")
    if done.returncode:
        sys.exit(done.stderr)
    print(done.stdout.replace(f"{folder}/", ""))


route = str(folder / "route.map")
if not (folder / "route.map").exists():
    insectnav(
        "map", "build", str(folder / "may"), route, "--camera", "panorama", "--descriptor", "zernike", "--sky", "otsu",
        "--positions", str(folder / "may.csv"), "--freeze",
    )  # fmt: skip
insectnav(
    "map", "locate", route, str(folder / "january"), "--positions", str(folder / "january.csv"), "--tolerance-m", "10",
    "--sequence-length", "20", "--out-dir", str(folder / "located"),
)  # fmt: skip

# %% Look at it
print(f"page: {folder / 'located' / 'page.html'}")
