# %% [markdown]
# # What a camera makes of a view
#
# A street under a clear sky, seen by a fisheye camera that looks up, in ultraviolet and in green: as it is, as a sensor
# reads it in much and in little light, and with the stray light of a lens that the sun shines into.
#
#     python examples/sensor.py [FOLDER]
#
# leaves sensor.png and sensor.pdf in FOLDER, out/examples by default.

# %%
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, journal_style, name_panel, save_figure
from insectnav.vision import (
    LensFlare,
    Meter,
    Sensor,
    add_lens_flare,
    auto_exposure,
    expose,
    fisheye,
    halo_radiance,
    ideal_sensor,
    srgb_encoded,
)
from insectnav.worlds import light_world, render
from insectnav.worlds.builders import BUILDERS, build_world
from insectnav.worlds.sky import Sky

BAND_NAMES = ("uv", "green")
SEED, N_PIXELS = 1, 240
sky = Sky(sun_azimuth=np.deg2rad(-25.0), sun_elevation=np.deg2rad(42.0), turbidity=2.5)

# %% Radiance of the view, and whether the sun is to be seen
built = build_world("suburban-street", SEED)
world = light_world(built, sky)
x, y = built.route[round(0.38 * (len(built.route) - 1))]
eye = [(x, y, built.ground_height((x, y)) + BUILDERS["suburban-street"].eye_height)]
camera = fisheye((N_PIXELS, N_PIXELS), np.pi)
seen = render(world, eye, camera=camera, layers=BAND_NAMES, supersampling=2)
views = {band: seen[band][0] for band in BAND_NAMES}
white = dict(zip(BAND_NAMES, sky.irradiance(BAND_NAMES) / np.pi, strict=True))
visible = float(render(world, eye, directions=sky.sun, layers=("sky",))["sky"][0])
print(f"sun at {np.rad2deg(sky.sun_elevation):.0f}°, {100 * visible:.0f} % of it to be seen")

# %% Four cameras. The exposure lets two pixels in a hundred saturate, the same for all of a band
meter, mask = Meter(rule="percentile", percentile=98.0, level=1.0), camera.pixels_seen()
flare = LensFlare()
pictures = {}
for band, view in views.items():
    exposure = float(auto_exposure(view, meter, mask=mask))
    bright = Sensor(saturation_radiance=exposure)
    # A hundredth of the light, and a gain that fills the range with it
    dim = replace(bright, full_well=bright.full_well / 100)
    lit = add_lens_flare(view, camera, sky.sun, sky.sun_irradiance([band])[0], flare, visible_share=visible)
    pictures[band] = {
        "ideal": expose(view, ideal_sensor(exposure, bits=8), seed=SEED),
        "noise by day": expose(view, bright, seed=SEED, channel=band),
        "noise in 1/100 of the light": expose(view, dim, seed=SEED, channel=band),
        "lens flare, noise by day": expose(lit, bright, seed=SEED, channel=band),
    }
    grey = mask & (np.abs(view / exposure - 0.3) < 0.02)
    spread = [
        np.std(picture[grey] / 255 / (1 - bright.black_level) - view[grey] / exposure)
        for picture in list(pictures[band].values())[1:3]
    ]
    added = np.median((lit - view)[mask & (view < 0.1 * exposure)]) / exposure
    print(
        f"{band:6s} saturates at {exposure:.3f} W/m²/nm/sr, white sheet {white[band]:.3f}; noise at 30 % of it "
        f"{100 * spread[0]:.1f} and {100 * spread[1]:.1f} %; flare in the darks {100 * added:.1f} %"
    )

# %% Draw: pictures as on a screen, and what the flare is made of
sensor = Sensor(saturation_radiance=1.0)
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 5.4), layout="constrained")
    top, bottom = figure.subfigures(2, 1, height_ratios=(2.0, 1.0))
    axes = top.subplots(2, 4)
    for row, band in enumerate(BAND_NAMES):
        for column, (name, picture) in enumerate(pictures[band].items()):
            panel = axes[row, column]
            black = 0.0 if name == "ideal" else sensor.black_level
            light = np.clip((picture / 255 - black) / (1.0 - black), 0.0, 1.0)
            panel.imshow(np.ma.masked_array(srgb_encoded(light), ~mask), cmap="gray", vmin=0.0, vmax=1.0)
            panel.set(xticks=[], yticks=[])
            panel.spines[:].set_visible(False)
            if row == 0:
                name_panel(panel, "abcd"[column], name)
        axes[row, 0].set_ylabel({"uv": "ultraviolet, 350 nm", "green": "green, 520 nm"}[band], fontsize=8.0)

    noise, halo = bottom.subplots(1, 2)
    share = np.geomspace(3e-4, 0.9, 25)
    patches = np.repeat(share[:, None], 4000, axis=1).reshape(25, 40, 100)
    for full_well, colour, words in ((sensor.full_well, "blue", "by day"), (sensor.full_well / 100, "orange", "1/100")):
        one = replace(sensor, full_well=full_well, bits=16)
        numbers = expose(patches, one, seed=SEED).reshape(25, -1).astype(float)
        noise.plot(share, numbers.std(axis=1) / one.largest_number / (1 - one.black_level), "o", markersize=2.5,
                   color=COLOURS[colour], label=f"{words}, measured")  # fmt: skip
        expected = np.sqrt(share * full_well + one.read_noise**2) / full_well
        noise.plot(share, expected, color=COLOURS[colour], label="EMVA 1288")
    noise.set(xscale="log", yscale="log", xlabel="light / saturation", ylabel="standard deviation / range")
    noise.legend(ncols=2)
    name_panel(noise, "e", "noise")
    angle = np.geomspace(0.05, 60.0, 200)
    light = sky.sun_irradiance(["green"])[0]
    halo.plot(angle, light * halo_radiance(np.deg2rad(angle), flare), color=COLOURS["red"], label="halo")
    veil = flare.veiling_glare * light * np.sin(sky.sun_elevation) / np.pi
    halo.axhline(veil, color=COLOURS["purple"], label="veil by the sun")
    halo.axhline(np.median(views["green"][mask]), color=COLOURS["grey"], linestyle="--", label="median of the view")
    halo.set(xscale="log", yscale="log", xlabel="angle from the sun (deg)", ylabel="W m$^{-2}$ nm$^{-1}$ sr$^{-1}$")
    halo.legend()
    name_panel(halo, "f", "stray light, green")

    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(figure, folder, "sensor")
print(f"figure: {folder / 'sensor.png'}")
