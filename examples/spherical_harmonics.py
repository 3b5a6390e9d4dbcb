# %% [markdown]
# # A sky's spectrum, level and tilted
#
# The outline of the sky above a place, seen by an eye that turns and tilts. Amplitudes of spherical harmonics stay as
# they are as long as the eye sees all of the sky; Zernike amplitudes stay when the eye turns, not when it tilts.
# After Stone, Differt, Milford & Webb, ICRA 2016.
#
#     python examples/spherical_harmonics.py [FOLDER]

# %%
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, journal_style, name_panel, save_figure
from insectnav.vision.descriptors import harmonic_amplitudes, zernike_amplitudes
from insectnav.vision.sphere import azimuth_elevation, equirectangular, rotation_matrix, to_world

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
folder.mkdir(parents=True, exist_ok=True)

# %% Trees around a place: each hides the sky up to its height, over its width
rng = np.random.default_rng(8)
tree_azimuth = rng.uniform(-np.pi, np.pi, 30)
tree_height, tree_width = np.deg2rad(rng.uniform(20, 65, 30)), np.deg2rad(rng.uniform(5, 20, 30))


def skyline(azimuth):
    """Elevation [rad] above which there is sky."""
    apart = np.abs((azimuth[:, None] - tree_azimuth + np.pi) % (2 * np.pi) - np.pi) / tree_width
    return np.max(tree_height * np.sqrt(np.maximum(1.0 - apart**2, 0.0)), axis=1, initial=np.deg2rad(5.0))


fine_azimuth = np.deg2rad(np.arange(-180.0, 180.0, 0.1))
fine_skyline = skyline(fine_azimuth)
pixels = equirectangular(0.5)  # two by two rays for each pixel of 1°


def panorama(heading_deg=0.0, pitch_deg=0.0):
    """Share of sky in each pixel of the whole sphere, (180, 360)."""
    eye = rotation_matrix(np.deg2rad(heading_deg), np.deg2rad(pitch_deg))
    azimuth, elevation = azimuth_elevation(to_world(pixels.directions, eye))
    is_sky = elevation > np.interp(azimuth, fine_azimuth, fine_skyline)
    return is_sky.reshape(180, 2, 360, 2).mean(axis=(1, 3))


# %% The same place level, turned by 70°, and tilted as well
poses = {"level": (0, 0), "turned by 70°": (70, 0), "turned by 70°, tilted by 15°": (70, 15)}
views = {name: panorama(*pose)[:105] for name, pose in poses.items()}  # −15° to 90°, as rendered panoramas
level = next(iter(views.values()))
for name, view in views.items():
    harmonic, zernike = (
        np.linalg.norm(describe(view) - describe(level)) / np.linalg.norm(describe(level))
        for describe in (harmonic_amplitudes, zernike_amplitudes)
    )
    print(f"{name:30s} harmonic amplitudes change by {100 * harmonic:.2f} %, Zernike by {100 * zernike:5.2f} %")

# %% How much the amplitudes change with tilt, if the whole sphere is seen and if only −15° to 90° is
tilts = np.arange(0, 61, 5)
spheres = np.array([panorama(0, tilt) for tilt in tilts])
spectra = {
    "harmonics, whole sphere": harmonic_amplitudes(spheres, elevation_deg=(-90.0, 90.0)),
    "harmonics, −15° to 90°": harmonic_amplitudes(spheres[:, :105]),
    "Zernike, −15° to 90°": zernike_amplitudes(spheres[:, :105]),
}

# %% Draw
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 3.6), layout="constrained")
    axes = figure.subplot_mosaic("aaabbb;ccddee", height_ratios=[1.0, 1.5])
    for letter, name in zip("ab", (*list(poses)[:1], list(poses)[2]), strict=True):
        axes[letter].imshow(views[name], cmap="gray", vmin=0, vmax=1, extent=(-180, 180, -15, 90), aspect="auto")
        axes[letter].set(xticks=range(-180, 181, 90), yticks=[0, 45, 90], xlabel="azimuth (deg)")
        name_panel(axes[letter], letter, name)
    axes["a"].set_ylabel("elevation (deg)")
    styles = zip((COLOURS["black"], COLOURS["sky"], COLOURS["red"]), ("-", "-", "--"), (2.2, 1.2, 0.7), strict=True)
    for (name, view), (colour, dashes, width) in zip(views.items(), styles, strict=True):
        line = {"color": colour, "linestyle": dashes, "linewidth": width, "label": name}
        axes["c"].semilogy(harmonic_amplitudes(view), **line)
        axes["d"].semilogy(zernike_amplitudes(view), **line)
    axes["c"].set(xlabel="degree l", ylabel="amplitude")
    axes["c"].legend(loc="upper right")
    axes["d"].set(xlabel="pair n, m", ylim=(1e-3, 10))
    name_panel(axes["c"], "c", "spherical harmonics")
    name_panel(axes["d"], "d", "Zernike")
    for (name, spectrum), colour in zip(spectra.items(), ("black", "blue", "orange"), strict=True):
        change = np.linalg.norm(spectrum - spectrum[0], axis=-1) / np.linalg.norm(spectrum[0])
        axes["e"].semilogy(tilts[1:], 100 * change[1:], ".-", color=COLOURS[colour], label=name)
    axes["e"].set(
        xlabel="tilt (deg)", ylabel="change (%)", ylim=(0.1, 9e3), xticks=[0, 30, 60], yticks=[0.1, 1, 10, 100]
    )
    axes["e"].legend(loc="upper left")
    name_panel(axes["e"], "e", "change under tilt")
    save_figure(figure, folder, "spherical-harmonics")
print(f"figure: {folder / 'spherical-harmonics.png'}")
