# %% [markdown]
# # One sun, four weathers
#
# The sky over Seville on an April morning: clear, with scattered and broken clouds, and overcast; in colour, in green
# light and in ultraviolet, as an ant sees it, and the polarisation of its ultraviolet light.
#
#     python examples/skies.py [FOLDER]
#
# leaves skies.png and skies.pdf in FOLDER, out/examples by default.

# %%
import sys
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, RATES, journal_style, save_figure
from insectnav.worlds.clouds import WEATHERS
from insectnav.worlds.sky import sky_at
from insectnav.worlds.skylight import BANDS

TIME, LATITUDE_DEG, LONGITUDE_DEG, TURBIDITY, SEED = datetime(2014, 4, 11, 9, 30, tzinfo=UTC), 37.4, -5.98, 2.5, 15
N_PIXELS, SUPERSAMPLING = 240, 2
GAMMA = 1.0 / 2.2  # of the colour picture, for the screen


# %% Directions of a picture of the whole sky: zenith in the middle, horizon on the rim, north up and east on the left
def hemisphere(n):
    """Directions (n, n, 3), and which of them lie above the horizon."""
    across = (np.arange(n) + 0.5) / n * 2.0 - 1.0
    east, north = np.meshgrid(-across, -across)
    radius = np.hypot(east, north)
    from_zenith = np.minimum(radius, 1.0) * np.pi / 2.0
    level = np.sin(from_zenith) / np.maximum(radius, 1e-9)
    return np.stack([east * level, north * level, np.cos(from_zenith)], axis=-1), radius <= 1.0


def picture_place(directions):
    """Where directions lie in the picture, x to the right and y up, 1 being the horizon."""
    radius = np.arccos(np.clip(directions[..., 2], -1.0, 1.0)) / (np.pi / 2.0)
    level = np.maximum(np.hypot(directions[..., 0], directions[..., 1]), 1e-9)
    return -directions[..., 0] / level * radius, directions[..., 1] / level * radius


# %% The skies, in units of the radiance of a white sheet on the ground under the clear one
skies = {weather: sky_at(TIME, LATITUDE_DEG, LONGITUDE_DEG, weather, turbidity=TURBIDITY, seed=SEED)
         for weather in WEATHERS}  # fmt: skip
directions, above = hemisphere(N_PIXELS * SUPERSAMPLING)
coarse, coarse_above = hemisphere(17)
white = skies["clear"].irradiance() / np.pi


def fewer_pixels(picture):
    """Means of squares of pixels, against jagged edges."""
    shape = (N_PIXELS, SUPERSAMPLING, N_PIXELS, SUPERSAMPLING, *picture.shape[2:])
    return picture.reshape(shape).mean(axis=(1, 3))


light = {weather: fewer_pixels(sky.radiance(directions) / white) for weather, sky in skies.items()}
degree = {weather: fewer_pixels(sky.polarisation(directions).degree) for weather, sky in skies.items()}
outside = ~fewer_pixels(above).astype(bool)
sun = skies["clear"]
print(f"sun: azimuth {np.rad2deg(sun.sun_azimuth):.0f}°, elevation {np.rad2deg(sun.sun_elevation):.0f}°")

# %% How much the clouds stand out in each band: the spread of the radiance over the upper sky, over its mean
print("contrast above 30°       " + "".join(f"{name:>8s}" for name in BANDS))
high = directions[::8, ::8][directions[::8, ::8, 2] > 0.5]
for weather, sky in skies.items():
    radiance = sky.radiance(high, sun_disc=False)
    print(f"  {weather:22s} " + "".join(f"{value:8.2f}" for value in radiance.std(axis=0) / radiance.mean(axis=0)))


# %% One row of pictures each: colour, green, ultraviolet, polarisation
def e_vectors(sky):
    """Ends (line, 2, xy) of lines along the e-vectors, as long as the degree of polarisation."""
    sights = coarse[coarse_above]
    sights = sights[sky.polarisation(sights).degree > 0.03]
    found = sky.polarisation(sights)
    x, y = picture_place(sights)
    # In the picture, up along a meridian is towards the middle; seen from below, clockwise stays clockwise.
    upward = np.arctan2(-x, -y)
    bearing = upward + found.angle
    half = 0.09 * found.degree[:, None] * np.stack([np.sin(bearing), np.cos(bearing)], axis=-1)
    centre = np.stack([x, y], axis=-1)
    return np.stack([centre - half, centre + half], axis=1)


with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 6.6), layout="constrained")
    axes = figure.subplots(4, len(WEATHERS))
    names = list(BANDS)
    extent = (-1.0, 1.0, -1.0, 1.0)
    for column, weather in enumerate(WEATHERS):
        colour = np.clip(light[weather][..., [names.index(name) for name in ("red", "green", "blue")]], 0.0, 1.0)
        colour[outside] = 1.0
        axes[0, column].imshow(colour**GAMMA, extent=extent)
        for row, band in ((1, "green"), (2, "uv")):
            grey = np.ma.masked_array(light[weather][..., names.index(band)], outside)
            greys = axes[row, column].imshow(grey, cmap="gray", vmin=0.0, vmax=1.0, extent=extent)
        masked = np.ma.masked_array(degree[weather], outside)
        degrees = axes[3, column].imshow(masked, cmap=RATES, vmin=0.0, vmax=0.7, extent=extent)
        for line in e_vectors(skies[weather]):
            axes[3, column].plot(*line.T, color="white", linewidth=0.7)
        axes[0, column].set_title(weather)
    for panel in axes.flat:
        panel.set(xticks=[], yticks=[], xlim=(-1.04, 1.04), ylim=(-1.04, 1.04), aspect="equal")
        panel.spines[:].set_visible(False)
        panel.plot(*picture_place(sun.sun), marker="o", markersize=5.0, fillstyle="none", color=COLOURS["orange"])
    for label, row in (("colour", 0), ("green, 520 nm", 1), ("ultraviolet, 350 nm", 2), ("polarisation, 350 nm", 3)):
        axes[row, 0].set_ylabel(label, fontsize=8.0)
    for word, x, y in (("N", 0.0, 1.0), ("E", -1.0, 0.0), ("S", 0.0, -1.0), ("W", 1.0, 0.0)):
        axes[0, 0].text(0.9 * x, 0.9 * y, word, ha="center", va="center", fontsize=6.0, color="white")
    figure.colorbar(greys, ax=axes[1:3, :], shrink=0.6, label="radiance / that of a white sheet in clear weather")
    figure.colorbar(degrees, ax=axes[3, :], shrink=0.9, label="degree of polarisation")

    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(figure, folder, "skies")
print(f"figure: {folder / 'skies.png'}")
