# %% [markdown]
# # Ultraviolet laid over green
#
# A rendered street, not a photograph, in two bands: walls as bright as the sky in green are dark in ultraviolet.
# Between the two pictures the camera was moved, turned and zoomed a little; mutual information finds by how much.
#
#     python examples/align_bands.py [FOLDER]
#
# leaves align-bands.png and align-bands.pdf in FOLDER, out/examples by default. Needs the extra `register`.

# %%
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.ndimage import map_coordinates

from insectnav.experiments.figures import DOUBLE_COLUMN, journal_style, name_panel, save_figure
from insectnav.vision.registration import RegistrationParams, align
from insectnav.worlds import World, render_layers
from insectnav.worlds.builders import BUILDERS, build_world
from insectnav.worlds.materials import reflectance

ROWS, COLUMNS, FINE = 240, 420, 2  # pixels of the pictures; pixels of the rendering across each
SKY, SOIL = {"uv": 0.9, "green": 0.45}, {"uv": 0.03, "green": 0.12}  # brightness, assumed

# %% Render both bands, twice as fine as the pictures
city = build_world("city", 1)
bright = {band: reflectance(city.mesh.materials, band)[city.mesh.material] for band in SKY}
at = city.route[len(city.route) // 3]
eye = np.array([[*at, city.ground_height(at) + BUILDERS["city"].eye_height]])
fine = render_layers(
    World(mesh=city.mesh, brightness=bright, sky=SKY, ground=SOIL), eye, np.zeros(1), tuple(SKY),
    resolution_deg=0.125, elevation_deg=(-10.0, 60.0), supersampling=2,
)  # fmt: skip


# %% Two photographs in 16 bits; the second by a camera that has moved
def photograph(band, matrix, seed):
    """A picture in which (column, row) of the first camera is at matrix · (column, row, 1)."""
    back = np.linalg.inv(np.vstack([matrix, [0.0, 0.0, 1.0]]))
    row, column = np.indices((ROWS, COLUMNS)) + 0.5
    x, y, _ = np.tensordot(back, np.stack([column, row, np.ones_like(row)]), axes=1)
    values = map_coordinates(fine[band][0], [FINE * y + 60, FINE * x + 1250], order=1, mode="nearest")
    values += np.random.default_rng(seed).normal(0.0, 0.01, values.shape)
    return np.rint(65535 * np.clip(values, 0.0, 1.0)).astype(np.uint16)


angle, zoom, shift = np.deg2rad(2.0), 1.03, np.array([11.0, -7.5])
linear = zoom * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
middle = np.array([COLUMNS, ROWS]) / 2
true = np.hstack([linear, (middle + shift - linear @ middle)[:, None]])
green, ultraviolet = photograph("green", np.eye(2, 3), 1), photograph("uv", true, 2)

# %% Lay the one over the other
found = align(green, ultraviolet, RegistrationParams(transform="similarity"))
corners = np.array([[x, y, 1.0] for x in (0, COLUMNS) for y in (0, ROWS)])
error = np.hypot(*((found.matrix - true) @ corners.T)).max()
print(f"shift {found.shift_px.round(2)} pixels, {np.rad2deg(found.rotation):.2f}°, scale {found.scale:.4f}")
print(f"wrong by at most {error:.3f} pixels at the corners")
print(f"mutual information {found.mutual_information_before:.3f} before, {found.mutual_information:.3f} nat after")


# %% Draw: green and ultraviolet over each other, each in a colour of its own
def overlay(first, second):
    first, second = (np.sqrt(np.clip(picture / np.quantile(picture, 0.99), 0, 1)) for picture in (first, second))
    return np.stack([second, first, second], axis=-1)  # magenta and green: white where both are bright


with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 4.25), layout="constrained")
    axes = figure.subplot_mosaic("ab;cd")
    for letter, picture, title in (("a", green, "rendered, green"), ("b", ultraviolet, "rendered, 350 nm, moved")):
        axes[letter].imshow(picture, cmap="gray", vmin=0, vmax=np.quantile(picture, 0.995))
        name_panel(axes[letter], letter, title)
    axes["c"].imshow(overlay(green, ultraviolet))
    name_panel(axes["c"], "c", f"as they are, {found.mutual_information_before:.2f} nat")
    laid = overlay(green, found.aligned)
    laid[~found.valid] = 0.5
    axes["d"].imshow(laid)
    name_panel(axes["d"], "d", f"aligned, {found.mutual_information:.2f} nat, off by {error:.2f} pixels at most")
    for panel in axes.values():
        panel.set(xticks=[], yticks=[])
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(figure, folder, "align-bands")
print(f"figure: {folder / 'align-bands.png'}")
