"""Compound eyes: where each ommatidium looks, how widely, in which colours, and which e-vector it prefers.

The eyes of desert ants and of the honeybee are put together from published numbers. What is not published, or not known
to us, is an assumption and called so where it stands: the eyes have the right number of ommatidia, of the right width,
over about the right field, but no single ommatidium is one that was measured.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, as_numbers, check_choice, check_range, check_shape
from insectnav.rng import trial_streams
from insectnav.vision.sphere import (
    Reals,
    azimuth_elevation,
    check_directions,
    directions,
    fibonacci,
    great_circle_angle,
)

BANDS = ("uv", "blue", "green")
LEFT, RIGHT = -1, 1
_N_NEIGHBOURS = 6
Bools = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True, eq=False)
class CompoundEye:
    """One or both compound eyes of an animal; arrays are read-only copies.

    Parameters
    ----------
    name : what to call the eye in tables and figures
    directions : (n, 3) array of unit vectors in the frame of the head
    acceptance : (n,) array [rad], full width at half maximum Δρ of the Gaussian sensitivity of each ommatidium
    bands : spectral classes of receptors that occur
    has_band : (n, band) array of bool, which of them each ommatidium has
    side : (n,) array of -1 (left eye) or 1 (right eye)
    e_vector : (n, 3) array of unit vectors across the line of sight, the e-vector to which an ommatidium of the dorsal
        rim responds most, of either sign; NaN elsewhere
    polarisation_sensitivity : strongest over weakest response of a receptor of the dorsal rim as the e-vector turns;
        None if not given
    """

    name: str
    directions: Reals
    acceptance: Reals
    bands: tuple[str, ...]
    has_band: Bools
    side: NDArray[np.integer[Any]]
    e_vector: Reals
    polarisation_sensitivity: float | None = None

    def __post_init__(self) -> None:
        vectors = check_directions("directions", self.directions).astype(np.float64)
        check_shape("directions", vectors, ("n", 3))
        n = len(vectors)
        acceptance = np.array(as_numbers("acceptance", self.acceptance), dtype=np.float64)
        check_shape("acceptance", acceptance, (n,))
        check_range("acceptance", acceptance, 0.0, np.pi, "rad", "degrees?")
        for band in self.bands:
            check_choice("band", band, BANDS)
        has_band, side = np.array(self.has_band, dtype=bool), np.array(self.side)
        check_shape("has_band", has_band, (n, len(self.bands)))
        check_shape("side", side, (n,))
        if not np.isin(side, (LEFT, RIGHT)).all():
            raise InputError("side holds other values than -1 and 1, expected -1 for the left eye and 1 for the right")
        axes = np.array(as_numbers("e_vector", self.e_vector), dtype=np.float64)
        check_shape("e_vector", axes, (n, 3))
        is_rim = np.isfinite(axes).all(axis=-1)
        check_directions("e_vector", axes[is_rim])
        if (np.abs(np.sum(axes[is_rim] * vectors[is_rim], axis=-1)) > 1e-3).any():
            raise InputError("e_vector points along the line of sight of an ommatidium, expected vectors across it")
        if self.polarisation_sensitivity is not None:
            check_range("polarisation_sensitivity", self.polarisation_sensitivity, 1.0, np.inf)
        arrays = {"directions": vectors, "acceptance": acceptance, "has_band": has_band, "side": side, "e_vector": axes}
        for name, array in arrays.items():
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def n_ommatidia(self) -> int:
        """Number of ommatidia, of both eyes if there are two."""
        return len(self.side)

    @property
    def is_dorsal_rim(self) -> Bools:
        """Which ommatidia prefer an e-vector, (n,)."""
        return np.asarray(np.isfinite(self.e_vector).all(axis=-1))


def interommatidial_angles(directions: ArrayLike) -> Reals:
    """Mean angle from each direction to its six nearest neighbours.

    Parameters
    ----------
    directions : (n, 3) array of unit vectors of one eye, at least seven

    Returns
    -------
    (n,) array [rad]; at the edge of the eye, where some of the six are missing, too large
    """
    from scipy.spatial import cKDTree

    vectors = check_directions("directions", directions)
    check_shape("directions", vectors, ("n", 3))
    check_range("number of directions", len(vectors), _N_NEIGHBOURS + 1, np.inf)
    chord = cKDTree(vectors).query(vectors, _N_NEIGHBOURS + 1)[0][:, 1:]
    return np.mean(2.0 * np.arcsin(np.clip(chord / 2, 0.0, 1.0)), axis=-1)


def both_eyes(
    name: str,
    right: ArrayLike,
    acceptance: ArrayLike,
    *,
    bands: tuple[str, ...] = BANDS,
    has_band: ArrayLike | None = None,
    is_rim: ArrayLike | None = None,
    polarisation_sensitivity: float | None = None,
) -> CompoundEye:
    """Two eyes, the left the mirror image of the right; the left comes first.

    Parameters
    ----------
    name : what to call the eyes
    right : (n, 3) array of unit vectors of the right eye
    acceptance : (n,) array [rad]
    bands : spectral classes that occur
    has_band : (n, band) array of bool; None if every ommatidium has all
    is_rim : (n,) array of bool, the dorsal rim; None for none. Its e-vector axes lie along the circles round the zenith
    polarisation_sensitivity : of the dorsal rim

    Notes
    -----
    The fan of e-vector axes along circles round the zenith is an assumption: that of the sensor of Gkanias et al. 2019,
    doi 10.1371/journal.pcbi.1007123. The microvilli of ants and bees do form a fan along the rim (Labhart & Meyer 1999,
    Microsc. Res. Tech. 47, 368), two sets at right angles in each ommatidium: the other axis is the cross product of
    this one and the line of sight.
    """
    vectors = check_directions("right", right).astype(np.float64)
    check_shape("right", vectors, ("n", 3))
    n = len(vectors)
    has = np.ones((n, len(bands)), dtype=bool) if has_band is None else np.asarray(has_band)
    rim = np.zeros(n, dtype=bool) if is_rim is None else np.asarray(is_rim)
    axes = np.full((n, 3), np.nan)
    azimuth = azimuth_elevation(vectors[rim])[0]
    axes[rim] = np.stack([np.cos(azimuth), -np.sin(azimuth), np.zeros_like(azimuth)], axis=-1)
    mirror = np.array([-1.0, 1.0, 1.0])
    return CompoundEye(
        name=name,
        directions=np.concatenate([vectors * mirror, vectors]),
        acceptance=np.tile(np.broadcast_to(np.asarray(acceptance), (n,)), 2),
        bands=bands,
        has_band=np.tile(has, (2, 1)),
        side=np.repeat([LEFT, RIGHT], n),
        e_vector=np.concatenate([axes * mirror, axes]),
        polarisation_sensitivity=polarisation_sensitivity,
    )


@dataclass(frozen=True, kw_only=True)
class AntEyeParams:
    """Numbers of the right eye of an ant: ommatidia, spread evenly between two azimuths and two elevations."""

    name: str
    n_ommatidia: int
    azimuth_deg: tuple[float, float]  # from the midline ahead to the back
    elevation_deg: tuple[float, float]
    frontal_acceptance_deg: float
    widest_acceptance_deg: float  # of the dorsal rim, and at the temporal edge of the field
    n_rim: int
    rim_centre_deg: tuple[float, float]  # azimuth, elevation
    polarisation_sensitivity: float | None


CATAGLYPHIS_BICOLOR = AntEyeParams(
    name="Cataglyphis bicolor",
    n_ommatidia=1000,  # about; Menzel & Wehner 1970, as cited by Stone 2017, thesis, section 2.2.1
    azimuth_deg=(0.0, 150.0),  # 300° for both, Zollikofer et al. 1995, as cited there; no overlap ahead: assumption
    elevation_deg=(-45.0, 90.0),  # assumption; gives 4.1° between neighbours
    frontal_acceptance_deg=3.0,  # Labhart 1986, doi 10.1007/BF00614514
    widest_acceptance_deg=5.4,  # Labhart 1986, dorsal rim
    n_rim=65,  # 55 to 75; Wehner 2001, J. Exp. Biol. 204, 2589, Fig. 5
    rim_centre_deg=(45.0, 51.0),  # Duelli 1975, doi 10.1007/BF00657484; that it looks to its own side is an assumption
    polarisation_sensitivity=6.3,  # Labhart 1986, mean of UV receptors of the dorsal rim
)
MELOPHORUS_BAGOTI = AntEyeParams(
    name="Melophorus bagoti",
    n_ommatidia=505,  # middle of 420 to 590; Schwarz et al. 2011, doi 10.1016/j.asd.2010.10.003
    azimuth_deg=(0.0, 150.0),  # width: Schwarz et al. 2011; no overlap ahead: assumption
    elevation_deg=(
        -20.4,
        20.4,
    ),  # what 505 ommatidia 3.7° apart (Schwarz et al. 2011) fill; about the horizon: assumption
    frontal_acceptance_deg=3.7,  # rhabdom 2.9° and lens blur 2.3° (Schwarz et al. 2011), added as squares
    widest_acceptance_deg=3.7,  # the mean, used for all
    n_rim=0,  # no numbers known to us
    rim_centre_deg=(45.0, 51.0),
    polarisation_sensitivity=None,
)


def desert_ant(params: AntEyeParams = CATAGLYPHIS_BICOLOR) -> CompoundEye:
    """Both eyes of a desert ant: ultraviolet and green receptors in all ommatidia.

    Parameters
    ----------
    params : `CATAGLYPHIS_BICOLOR` or `MELOPHORUS_BAGOTI`, whose sources stand beside their numbers, or your own

    Notes
    -----
    UV (350 nm) and green (510 nm) receptors in all parts of the eye: Labhart 1986, doi 10.1007/BF00614514. Acceptance
    3.0° ahead and 5.4° in the dorsal rim: there, too; from straight ahead to the back edge it grows linearly to the
    same 5.4°: assumption.
    Even spacing is an assumption: the real eye is denser in a band along the horizon (Zollikofer, Wehner & Fukushi
    1995, J. Exp. Biol. 198, 1637). The dorsal rim is taken as the ommatidia nearest to its centre.
    """
    right = _even_field(params)
    azimuth, elevation = np.deg2rad(params.rim_centre_deg)
    centre, ahead = directions(azimuth, elevation), directions(0.0, 0.0)
    is_rim = np.zeros(len(right), dtype=bool)
    is_rim[np.argsort(great_circle_angle(right, centre), kind="stable")[: params.n_rim]] = True
    share = np.minimum(great_circle_angle(right, ahead) / np.deg2rad(params.azimuth_deg[1]), 1.0)
    share = np.where(is_rim, 1.0, share)
    degrees = params.frontal_acceptance_deg + share * (params.widest_acceptance_deg - params.frontal_acceptance_deg)
    return both_eyes(
        params.name,
        right,
        np.deg2rad(degrees),
        bands=("uv", "green"),
        is_rim=is_rim,
        polarisation_sensitivity=params.polarisation_sensitivity,
    )


def _even_field(params: AntEyeParams) -> Reals:
    """So many directions of a spiral that lie in the field, (n, 3)."""
    first, last = np.deg2rad(params.azimuth_deg)
    expected = params.n_ommatidia * 2 * np.pi / (last - first)
    for n_points in sorted(range(int(0.9 * expected), int(1.1 * expected) + 3), key=lambda n: abs(n - expected)):
        points = fibonacci(n_points, params.elevation_deg).directions
        azimuth = azimuth_elevation(points)[0]
        inside = np.mod(azimuth - first, 2 * np.pi) <= last - first
        if np.count_nonzero(inside) == params.n_ommatidia:
            return points[inside]
    raise InputError(f"n_ommatidia is {params.n_ommatidia}, expected a number that can be spread evenly over the field")


@dataclass(frozen=True, kw_only=True)
class BeeEyeParams:
    """Numbers of the right eye of a honeybee; angles are between neighbours along a row and between every other row."""

    row_angle_deg: tuple[float, ...] = (4.6, 3.7, 2.4, 3.7, 4.6)  # Giger 1996
    row_azimuth_deg: tuple[float, ...] = (-45.0, 0.0, 45.0, 90.0, 150.0)  # where; constant beyond
    level_elevation_deg: float = 50.0  # above and below it the angle along a row tends to 3.7° at the pole
    polar_angle_deg: float = 3.7
    column_angle_deg: tuple[float, float] = (1.5, 4.5)  # at the horizon, at the poles; linear between; Giger 1996
    nasal_edge_deg: float = -15.0  # about, at the horizon; Seidl & Kaiser 1981
    temporal_edge_deg: float = 157.0  # about, at the horizon; Seidl & Kaiser 1981
    whole_circle_elevation_deg: float = 70.0  # about, from here on all round; Seidl & Kaiser 1981
    acceptance_deg: float = 2.57  # Eheim & Wehner 1972, Kybernetik 10, 168, central ommatidia; for all: assumption
    rim_acceptance_deg: float = 14.0  # approximate: of the bee Megalopta (Greiner et al. 2007); "strongly extended"
    n_rim: int = 150  # approximate: a number often given, whose source we have not seen
    rim_centre_deg: tuple[float, float] = (-90.0, 70.0)  # assumption: the inner dorsal edge looks across the midline
    type_share: tuple[float, float, float] = (0.44, 0.46, 0.10)  # Wakakuwa et al. 2005, doi 10.1007/s00114-005-0018-5


HONEYBEE = BeeEyeParams()


def honeybee(params: BeeEyeParams = HONEYBEE, seed: int = 0) -> CompoundEye:
    """Both eyes of a worker honeybee: 5378 ommatidia each by these rules; 5432 were counted.

    Parameters
    ----------
    params : sources and assumptions stand beside the numbers
    seed : for the type of each ommatidium

    Notes
    -----
    5432 ommatidia: Seidl & Kaiser 1981, J. Comp. Physiol. 143, 17, as cited by Somanathan et al. 2009, J. Exp. Biol.
    212, 2448, Table 1. Rows of ommatidia after Giger 1996 (PhD thesis, Australian National University), an
    interpolation that Stürzl et al. 2010 (Bioinspir. Biomim. 5, 036002) and Polster et al. 2018 (arXiv 1811.07560) use,
    too; its numbers, and the edge of the field, were read from the program of the last. The angle between neighbours
    along a row changes with azimuth, that between rows with elevation, and every other row is shifted by half an angle.
    The edge is a smooth curve of ours through its places at the horizon and at 70°; between them it may be 20° off.
    Every ommatidium has green receptors; type I has UV and blue, type II UV, type III blue, at random (Wakakuwa et al.
    2005). All of the dorsal rim is given UV, as Hymenoptera have it there (Labhart & Meyer 1999).
    """
    right = _giger_rows(params)
    azimuth, elevation = np.deg2rad(params.rim_centre_deg)
    is_rim = np.zeros(len(right), dtype=bool)
    distance = great_circle_angle(right, directions(azimuth, elevation))
    is_rim[np.argsort(distance, kind="stable")[: params.n_rim]] = True
    chance = trial_streams(seed, np.arange(len(right)), "honeybee ommatidia")[:, 0] / 2.0**32
    kind = np.searchsorted(np.cumsum(params.type_share)[:-1], chance, side="right")
    has_band = np.stack([(kind < 2) | is_rim, kind != 1, np.ones(len(right), dtype=bool)], axis=-1)
    degrees = np.where(is_rim, params.rim_acceptance_deg, params.acceptance_deg)
    return both_eyes("Apis mellifera", right, np.deg2rad(degrees), has_band=has_band, is_rim=is_rim)


def _giger_rows(params: BeeEyeParams) -> Reals:
    """Directions of the right eye, (n, 3), row by row from the horizon up and then down."""
    rows: list[Reals] = []
    for sign in (1.0, -1.0):
        elevation, number = 0.0, 0
        while elevation < 90.0:
            if sign > 0.0 or number > 0:
                azimuth = np.deg2rad(_row_azimuths(params, elevation, number % 2 == 1))
                rows.append(directions(np.remainder(azimuth, 2 * np.pi), np.deg2rad(sign * elevation)))
            low, high = params.column_angle_deg
            elevation += (low + (high - low) * elevation / 90.0) / 2
            number += 1
    return np.concatenate(rows)


def _row_azimuths(params: BeeEyeParams, elevation: float, is_shifted: bool) -> Reals:
    """Azimuths [deg] of a row from the inner edge of the field to the outer one."""
    share = min(1.0, elevation / params.whole_circle_elevation_deg) ** 4
    middle = (params.nasal_edge_deg + params.temporal_edge_deg) / 2
    half = params.temporal_edge_deg - middle
    middle, half = middle + (90.0 - middle) * share, half + (180.0 - half) * share
    first = 0.5 * _row_step(params, 0.0, elevation) if is_shifted else 0.0
    outwards, inwards = [first], []
    while (azimuth := outwards[-1] + _row_step(params, outwards[-1], elevation)) <= middle + half:
        outwards.append(azimuth)
    azimuth = first - _row_step(params, first, elevation)
    # Where a row closes to a circle the last gap must not be narrower than half an angle.
    while azimuth >= max(middle - half, outwards[-1] - 360.0 + 0.5 * _row_step(params, azimuth, elevation)):
        inwards.append(azimuth)
        azimuth -= _row_step(params, azimuth, elevation)
    return np.array(inwards[::-1] + outwards)


def _row_step(params: BeeEyeParams, azimuth: float, elevation: float) -> float:
    """Step in azimuth [deg] that makes the angle between neighbours on the sphere right."""
    angle = float(np.interp(azimuth, params.row_azimuth_deg, params.row_angle_deg))
    if not params.row_azimuth_deg[1] < azimuth < params.row_azimuth_deg[3]:
        share = min(1.0, (90.0 - elevation) / (90.0 - params.level_elevation_deg))
        angle = params.polar_angle_deg + (angle - params.polar_angle_deg) * share
    sine = np.sin(np.deg2rad(angle) / 2) / max(np.cos(np.deg2rad(elevation)), 1e-9)
    return float(np.rad2deg(2.0 * np.arcsin(min(sine, 1.0))))


EYES: dict[str, Callable[[], CompoundEye]] = {
    "cataglyphis-bicolor": desert_ant,
    "melophorus-bagoti": lambda: desert_ant(MELOPHORUS_BAGOTI),
    "honeybee": honeybee,
}
