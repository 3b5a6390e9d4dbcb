# %% [markdown]
# # Two strokes make a mask
#
# A rendered street, not a photograph: its true sky is known. A stroke of sky and one of ground grow over it by GrowCut;
# then a few corrections are painted where the mask is wrong, as a person would.
#
#     python examples/grow_cut.py [FOLDER]
#
# leaves grow-cut.png and grow-cut.pdf in FOLDER, out/examples by default.

# %%
import sys
from pathlib import Path

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from scipy.ndimage import distance_transform_edt

from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, RATES, journal_style, name_panel, save_figure
from insectnav.vision.growcut import StrokeGrower
from insectnav.worlds import World, render_layers
from insectnav.worlds.builders import BUILDERS, build_world
from insectnav.worlds.materials import reflectance

GROUND, SKY = 1, 2
COLOUR_BANDS = ("red", "green", "blue")
SKY_COLOUR = dict(zip(COLOUR_BANDS, (0.30, 0.36, 0.48), strict=True))  # brightness of an overcast sky, assumed
SOIL = dict(zip(COLOUR_BANDS, (0.13, 0.12, 0.10), strict=True))

# %% A street in colour, with the noise of a camera, and which part of it is sky
world = build_world("suburban-street", 1)
bright = {band: reflectance(world.mesh.materials, band)[world.mesh.material] for band in COLOUR_BANDS}
at = world.route[round(0.38 * (len(world.route) - 1))]
eye = np.array([[*at, world.ground_height(at) + BUILDERS["suburban-street"].eye_height]])
layers = render_layers(
    World(mesh=world.mesh, brightness=bright, sky=SKY_COLOUR, ground=SOIL), eye, np.zeros(1), (*COLOUR_BANDS, "sky"),
    resolution_deg=0.25, elevation_deg=(-15.0, 50.0), supersampling=2,
)  # fmt: skip
crop = (slice(None), slice(520, 920))
rng = np.random.default_rng(0)
picture = np.stack([layers[band][0][crop] for band in COLOUR_BANDS], axis=-1)
picture = np.clip(255.0 * (picture / 0.5) ** 0.45 + rng.normal(0.0, 3.0, picture.shape), 0, 255).astype(np.uint8)
is_sky = layers["sky"][0][crop] > 0.5
rows, columns = is_sky.shape


# %% Strokes; a correction is a dab in the middle of the largest patch that is wrong
def dab(strokes, row, column, radius, label):
    away = np.hypot(*np.indices(strokes.shape) - np.array([row, column])[:, None, None])
    strokes[away <= radius] = label


strokes = np.zeros((rows, columns), np.uint8)
strokes[10:14, 40:-40] = SKY
strokes[-14:-10, 40:-40] = GROUND
grower = StrokeGrower(picture)
first = grower.grow(strokes)
print(f"{columns} × {rows} pixels; first mask {100 * ((first.labels == SKY) == is_sky).mean():.2f} % right")
mended, n_dabs = first, 0
while n_dabs < 12:
    wrong = (mended.labels == SKY) != is_sky
    depth = distance_transform_edt(np.pad(wrong, 1))[1:-1, 1:-1]
    row, column = np.unravel_index(np.argmax(depth), depth.shape)
    if depth[row, column] < 2.0:
        break
    dab(strokes, row, column, max(1.0, 0.7 * depth[row, column]), SKY if is_sky[row, column] else GROUND)
    mended, n_dabs = grower.grow(strokes), n_dabs + 1
print(f"after {n_dabs} corrections {100 * ((mended.labels == SKY) == is_sky).mean():.2f} % right")

# %% Draw
painted = ListedColormap([(0, 0, 0, 0), COLOURS["red"], COLOURS["blue"]])
tint = ListedColormap([COLOURS["orange"], COLOURS["sky"]])
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 4.6), layout="constrained")
    axes = figure.subplot_mosaic("ab;cd")
    axes["a"].imshow(picture)
    start = np.zeros_like(strokes)
    start[10:14, 40:-40], start[-14:-10, 40:-40] = SKY, GROUND
    axes["a"].imshow(start, cmap=painted, vmin=0, vmax=2, interpolation="nearest")
    name_panel(axes["a"], "a", "rendered picture and two strokes")
    strength = axes["b"].imshow(first.strength, cmap=RATES, vmin=0.0, vmax=1.0)
    figure.colorbar(strength, ax=[axes["b"], axes["d"]], shrink=0.5, anchor=(0.0, 0.97), label="strength")
    name_panel(axes["b"], "b", "strength where the automaton rests")
    for letter, grown, title in (("c", first, "first mask"), ("d", mended, f"after {n_dabs} corrections")):
        axes[letter].imshow(picture)
        axes[letter].imshow(grown.labels == SKY, cmap=tint, alpha=0.45, interpolation="nearest")
        right = 100 * ((grown.labels == SKY) == is_sky).mean()
        name_panel(axes[letter], letter, f"{title}, {right:.1f} % of pixels right")
    axes["d"].imshow(strokes, cmap=painted, vmin=0, vmax=2, interpolation="nearest")
    for panel in axes.values():
        panel.set(xticks=[], yticks=[])
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(figure, folder, "grow-cut")
print(f"figure: {folder / 'grow-cut.png'}")
