"""Real skies turned and tilted: found over all rotations, by spherical harmonics, Zernike functions and contours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.recordings.files import MISSING, N_SKIES, sky_masks
from insectnav.matching import RotationIndex, build_rotation_index, rotation_between
from insectnav.vision import fisheye, rotation_matrix, to_world
from insectnav.vision.descriptors import panorama_contour_amplitudes, sphere_amplitudes, zernike_amplitudes
from insectnav.vision.sphere import equirectangular

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Reals = NDArray[np.floating[Any]]
Bools = NDArray[np.bool_]

FIGURE = "recording"
TITLE = "real skies turned and tilted: places found over all rotations and by three kinds of amplitudes"
ROTATION, HARMONICS, ZERNIKE, CONTOUR = "rotation matching", "harmonics", "Zernike", "contour"
WHOLE = "harmonics, uncropped"
COLOUR = {ROTATION: "blue", HARMONICS: "orange", ZERNIKE: "green", CONTOUR: "grey", WHOLE: "red"}
WAYS = tuple(COLOUR)
N_QUERIES, N_DEGREES = 2 * N_SKIES, 60
CAMERA, GRID, RAYS = fisheye((320, 320), np.pi), equirectangular(1.0), equirectangular(0.5)


@dataclass(frozen=True, kw_only=True)
class Cell:
    """Skies tilted by one angle.

    Parameters
    ----------
    tilt_deg : angle between the upward axes of map and query, towards any side
    n_queries : evenly through the walk, each turned anyhow
    n_skies : of the map; 0 if the photographs were not found
    """

    tilt_deg: float
    n_queries: int
    n_skies: int


class View(NamedTuple):
    """A sky on the directions of `GRID`, in the frame of the camera that looks."""

    cropped: Reals  # share of sky where the camera looks, 0 elsewhere
    seen: Bools  # where it looks
    whole: Reals  # all of the sky that the photograph showed, also where this camera does not look


def grid(scale: str) -> Sequence[Cell]:
    """Tilts from 0 to 60° by tens, each sky twice; or three tilts of eight skies."""
    n_skies = len(sky_masks())
    tilts, n = (range(0, 61, 10), N_QUERIES) if scale == "full" else (range(0, 61, 30), 8)
    return [Cell(tilt_deg=float(tilt), n_queries=n if n_skies else 0, n_skies=n_skies) for tilt in tilts]


def look(mask: Bools, rotation: Reals) -> View:
    """What a camera of 180°, photograph ← camera, sees of the sky; what the photograph did not show is ground."""
    own = CAMERA.project(RAYS.directions)[1]
    place, is_shown = CAMERA.project(to_world(RAYS.directions, rotation))
    column, row = (np.where(is_shown, np.clip(axis, 0, 319), 0).astype(int) for axis in place.T)
    sky = mask[row, column] & is_shown
    share = _means(own)
    return View(_means(sky & own) / np.maximum(share, 1e-9) * (share >= 0.5), share >= 0.5, _means(sky))


def _means(rays: Bools) -> Reals:
    return np.asarray(rays.reshape(180, 2, 360, 2).mean(axis=(1, 3)).ravel())


def describe(views: Sequence[View]) -> dict[str, Reals]:
    """Amplitudes of each kind, (view, feature)."""
    cropped = np.array([view.cropped for view in views])
    panorama = cropped.reshape(-1, 180, 360)[:, :90]  # from the zenith to the horizon of the camera
    return {
        HARMONICS: sphere_amplitudes(cropped, GRID, N_DEGREES),
        ZERNIKE: zernike_amplitudes(panorama),
        CONTOUR: panorama_contour_amplitudes(panorama),
        WHOLE: sphere_amplitudes(np.array([view.whole for view in views]), GRID, N_DEGREES),
    }


def _seen(views: Sequence[View]) -> tuple[Reals, Bools]:
    return np.array([view.cropped for view in views]), np.array([view.seen for view in views])


@lru_cache(maxsize=1)
def _map() -> tuple[RotationIndex, dict[str, Reals]]:
    views = [look(mask, np.eye(3)) for mask in sky_masks()]
    index = build_rotation_index(*_seen(views), GRID)
    return index, describe(views)


def simulate(cell: Cell, seed: int) -> Arrays:
    """Nearest place, and the nearest but the own one, of each query and way; −1 where there is none."""
    first = np.full((len(WAYS), N_QUERIES), -1)
    other, frame = first.copy(), np.full(N_QUERIES, -1)
    error = np.full(N_QUERIES, np.nan)
    if cell.n_queries:
        masks = sky_masks()
        frames = np.linspace(0, 2 * len(masks) - 1, cell.n_queries).round().astype(int) % len(masks)
        rotations = _rotations(cell, seed)
        views = [look(masks[k], rotation) for k, rotation in zip(frames, rotations, strict=True)]
        index, remembered = _map()
        match = index.match(*_seen(views))
        n = slice(0, cell.n_queries)
        frame[n], first[0, n] = frames, match.reference
        other[0, n] = np.where(match.reference == frames, match.runner_up, match.reference)
        error[n] = np.where(match.reference == frames, rotation_between(match.rotation, rotations), np.nan)
        for row, (name, spectra) in enumerate(describe(views).items(), 1):
            apart = np.linalg.norm(spectra[:, None] - remembered[name], axis=-1)
            first[row, n] = apart.argmin(axis=1)
            apart[np.arange(len(frames)), frames] = np.inf
            other[row, n] = apart.argmin(axis=1)
    return {
        "frame": (("query",), frame),
        "first": (("way", "query"), first, {"ways": "; ".join(WAYS)}),
        "other": (("way", "query"), other, {"long_name": "nearest place, the own one left out"}),
        "error": (("query",), error, {"units": "rad", "long_name": "of the rotation, where the place is right"}),
    }


def _rotations(cell: Cell, seed: int) -> Reals:
    """The tilt towards any azimuth, of a camera that is turned by any angle, (query, 3, 3)."""
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, int(cell.tilt_deg)])))
    turn, towards = rng.uniform(-np.pi, np.pi, (2, cell.n_queries))
    aside, turned = rotation_matrix(towards), rotation_matrix(turn)
    return np.asarray(aside @ rotation_matrix(0.0, -np.deg2rad(cell.tilt_deg)) @ aside.swapaxes(1, 2) @ turned)


def summarise(results: Results) -> Table:
    """A row for each tilt and way."""
    rows = []
    for cell, arrays in results:
        n = slice(0, cell.n_queries)
        frame, error = arrays["frame"][n], np.rad2deg(arrays["error"][n])
        is_known = np.isfinite(error)
        for row, way in enumerate(WAYS):
            found = arrays["first"][row, n] == frame
            neighbour = np.abs(arrays["other"][row, n] - frame) == 1
            measured = way == ROTATION and is_known.any()
            rows.append(
                {
                    "tilt_deg": cell.tilt_deg,
                    "way": way,
                    "kind": "real photographs" if cell.n_skies else MISSING,
                    "n": cell.n_queries,
                    "found": float(found.mean()) if cell.n_queries else float("nan"),
                    "neighbour_found": float(neighbour.mean()) if cell.n_queries else float("nan"),
                    "rotation_error_deg": float(np.median(error[is_known])) if measured else float("nan"),
                }
            )
    return rows


def draw(results: Results) -> Figure:
    """Shares found at first place, of the sky itself and of its neighbour, over the tilt."""
    from matplotlib.figure import Figure

    table = summarise(results)
    figure = Figure(figsize=(DOUBLE_COLUMN, 2.5), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    titles = (("a", "found", "the same sky"), ("b", "neighbour_found", "the sky before or after it"))
    for axes, (letter, name, title) in zip(panels, titles, strict=True):
        for way, colour in COLOUR.items():
            rows = [row for row in table if row["way"] == way]
            share = np.array([100.0 * row[name] for row in rows])
            spread = np.sqrt(share * (100.0 - share) / np.maximum([row["n"] for row in rows], 1))
            tilt = [row["tilt_deg"] for row in rows]
            style = "--" if way == WHOLE else "-"
            axes.errorbar(tilt, share, spread, fmt=style + "o", markersize=3, color=COLOURS[colour], label=way)
        if not results.cells[0].n_skies:
            axes.text(0.5, 0.5, "not found", transform=axes.transAxes, ha="center")
        axes.set(xlabel="tilt (deg)", xticks=range(0, 61, 10), ylim=(0, 104))
        name_panel(axes, letter, title)
    panels[0].set_ylabel("found at first place (%)")
    panels[1].legend(loc="upper right", ncols=2)
    return figure


def caption(results: Results) -> str:
    """What is shown, and of which skies."""
    cell = results.cells[0]
    used = f"n = {cell.n_queries} queries a tilt, {cell.n_skies} places" if cell.n_skies else MISSING
    return (
        f"Skies of photographs along one walk, about 4.4 s apart, marked by hand ({used}). Queries are the same "
        "masks turned at random and tilted towards a random side; the camera sees its own hemisphere, and what the "
        "photograph did not show is ground. a, Share of queries whose own place comes out first. b, The same where "
        "the own place is left out, and the one before or after it is right. Rotation matching compares what both "
        f"cameras saw, over all rotations; amplitudes are of {N_DEGREES} degrees of spherical harmonics, of Zernike "
        "functions to order 16, and of 32 frequencies of the outline. Dashed: harmonics, had the camera seen the "
        "whole sphere. Whiskers are one standard error."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Claims of section 4.1 that hold for any sky."""
    share = {(row["tilt_deg"], row["way"]): float(row["found"]) for row in table}
    near = {(row["tilt_deg"], row["way"]): float(row["neighbour_found"]) for row in table}
    error = float(np.sqrt(0.25 / max(int(table[0]["n"]), 1)))  # of a share, at most
    ours = {
        "found by harmonics at 60°, sphere seen whole": (share[60.0, WHOLE], error),
        "found by harmonics at 60°, cropped by the camera": (share[60.0, HARMONICS], error),
        "neighbours found at 0°, Zernike less contour": (
            near[0.0, ZERNIKE] - near[0.0, CONTOUR],
            float(np.sqrt(2.0)) * error,
        ),
    }
    crop = f"the camera crops the sphere, and the edge tilts with it: seen whole, {share[60.0, WHOLE]:.2f} are found"
    why = {
        "found by harmonics at 60°, cropped by the camera": crop,
        "neighbours found at 0°, Zernike less contour": f"contour {near[0.0, CONTOUR]:.2f}, Zernike "
        f"{near[0.0, ZERNIKE]:.2f}",
    }
    missing = "" if table[0]["n"] else MISSING
    return [
        judge(value, *ours[name], why=why.get(name, "measured"), not_comparable=missing)
        for name, value in published.items()
    ]
