"""Fig. 4.2: the real spherical harmonics on the sphere, and how many of them a sky takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2016_places.one_sky import CAMERA, one_sky, sky_text, source
from insectnav.vision import resampler, rotation_matrix, to_world
from insectnav.vision.descriptors import amplitude_spectrum, harmonic_pairs, real_harmonics, sphere_coefficients
from insectnav.vision.sphere import gauss_legendre

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "Fig. 4.2"
TITLE = "the real spherical harmonics drawn on the sphere, and the amplitudes of a sky"
N_DRAWN, N_DEGREES, SIZE = 5, 60, 96  # degrees that are drawn, degrees of the sky, pixels of a sphere
LOOK = np.deg2rad((20.0, -25.0))  # [rad] heading and pitch of who looks at the spheres
POSE = np.deg2rad((70.0, 35.0, 20.0))  # [rad] heading, pitch and roll by which the sky is turned
N_RINGS = 120  # of the Gauss-Legendre grid, exact to degree 119


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One sky.

    Parameters
    ----------
    sky : "photograph" or "rendered"
    """

    sky: str


def grid(scale: str) -> Sequence[Cell]:
    """The one sky at any scale."""
    return [Cell(sky=source())]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Pictures of the harmonics, and of the sky its amplitudes, level and turned, and what is left out by degrees."""
    grid_ = gauss_legendre(N_RINGS)
    mask = one_sky(cell.sky).astype(np.float32)
    see = resampler(CAMERA, grid_)
    level = np.asarray(see(mask, unseen=0.0), np.float64)
    coefficients = sphere_coefficients(level, grid_, N_DEGREES)
    # The series itself turned, so that nothing is cropped: its values along turned directions, analysed anew.
    turned = real_harmonics(N_DEGREES, to_world(grid_.directions, rotation_matrix(*POSE))) @ coefficients
    again = sphere_coefficients(turned, grid_, N_DEGREES)
    few = real_harmonics(N_DRAWN, grid_.directions)
    gram = few.T @ (few * grid_.weights[:, None])
    power = np.sum(level**2 * grid_.weights)
    degree = harmonic_pairs(N_DEGREES)[0]
    kept = np.cumsum(np.bincount(degree, coefficients**2))
    return {
        "picture": (("pair", "row", "column"), _pictures()),
        "amplitude": (("pose", "degree"), np.stack([amplitude_spectrum(c) for c in (coefficients, again)])),
        "left_out": (
            ("degree",),
            np.sqrt(np.maximum(1.0 - kept / power, 0.0)),
            {"units": "root mean square of the sky"},
        ),
        "off_orthonormal": ((), np.float64(np.abs(gram - np.eye(len(gram))).max())),
    }


def _pictures() -> NDArray[Any]:
    """Values of the first harmonics on the visible half of a sphere, NaN beside it."""
    axis = (np.arange(SIZE) + 0.5) / SIZE * 2.1 - 1.05
    right, up = np.meshgrid(axis, -axis)
    square = right**2 + up**2
    towards = np.sqrt(np.maximum(1.0 - square, 0.0))
    seen = np.stack([right, -towards, up], axis=-1)  # who looks along +y sees the side that faces −y
    directions = to_world(seen / np.linalg.norm(seen, axis=-1, keepdims=True), rotation_matrix(*LOOK))
    values = real_harmonics(N_DRAWN, directions)
    return np.moveaxis(np.where(square[..., None] <= 1.0, values, np.nan), -1, 0).astype(np.float32)


def summarise(results: Results) -> Table:
    """Amplitudes, and what is left out, by degree."""
    ((cell, arrays),) = results
    return [
        {
            "sky": cell.sky,
            "degree": degree,
            "amplitude": float(arrays["amplitude"][0, degree]),
            "amplitude_turned": float(arrays["amplitude"][1, degree]),
            "left_out_up_to_degree": float(arrays["left_out"][degree]),
            "off_orthonormal": float(arrays["off_orthonormal"]),
        }
        for degree in range(N_DEGREES)
    ]


def draw(results: Results) -> Figure:
    """A sphere for each harmonic, in the order of the published figure, and the sky's amplitudes."""
    from matplotlib.figure import Figure

    ((_, arrays),) = results
    figure = Figure(figsize=(DOUBLE_COLUMN, 3.2), layout="constrained")
    axes = figure.subplot_mosaic("aab;aac", width_ratios=(1.0, 1.0, 1.0))
    _draw_spheres(axes["a"], arrays["picture"])
    upper, lower = axes["b"], axes["c"]
    degrees = np.arange(N_DEGREES)
    upper.bar(degrees, arrays["amplitude"][0], color=COLOURS["sky"], label="level")
    upper.plot(degrees, arrays["amplitude"][1], ".", color=COLOURS["red"], markersize=2.5, label="turned and tilted")
    upper.set(yscale="log", ylabel="amplitude")
    upper.legend()
    name_panel(upper, "b", "amplitudes of a sky")
    lower.plot(degrees, 100.0 * arrays["left_out"], color=COLOURS["blue"])
    lower.set(xlabel="degree l", ylabel="left out (%)", ylim=(0, None))
    name_panel(lower, "c", "what higher degrees hold")
    return figure


def _draw_spheres(axes: Axes, pictures: NDArray[Any]) -> None:
    """A row for each degree, a column for each order."""
    for picture, degree, order in zip(pictures, *harmonic_pairs(N_DRAWN), strict=True):
        most = np.nanmax(np.abs(picture))
        place = (order - 0.47, order + 0.47, degree + 0.47, degree - 0.47)
        axes.imshow(picture, cmap="RdBu_r", vmin=-1.2 * most, vmax=1.2 * most, extent=place)
    last = N_DRAWN - 1
    axes.set(
        xlim=(-last - 0.6, last + 0.6), ylim=(last + 0.6, -0.6), aspect="equal", xlabel="order m", ylabel="degree l"
    )
    axes.set(xticks=range(-last, last + 1), yticks=range(N_DRAWN))
    name_panel(axes, "a", "real spherical harmonics")


def caption(results: Results) -> str:
    """What is shown."""
    ((cell, arrays),) = results
    return (
        f"a, The real spherical harmonics of the degrees l below {N_DRAWN} on a sphere seen from 25° above, positive "
        "red, negative blue, each to its own greatest value. b, Amplitudes of a sky, the root of the squares summed "
        "over the orders m, level (bars) and after a turn in all three axes (dots). c, What is left out by a sum up to "
        f"each degree, as a share of the root mean square of the sky: {100 * arrays['left_out'][-1]:.0f} % at "
        f"{N_DEGREES - 1}. "
        f"{sky_text(cell.sky)}"
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """What the caption and the text say."""
    level, turned = (np.array([row[name] for row in table]) for name in ("amplitude", "amplitude_turned"))
    left_out = [float(row["left_out_up_to_degree"]) for row in table]
    ours = {
        "departure from orthonormal": float(table[0]["off_orthonormal"]),
        "left out up to the highest degree over up to degree 4": left_out[-1] / left_out[4],
        "change of an amplitude by a rotation": float(np.abs(turned - level).max() / level.max()),
    }
    return [judge(value, ours[name], why=f"measured to degree {N_DEGREES - 1}") for name, value in published.items()]
