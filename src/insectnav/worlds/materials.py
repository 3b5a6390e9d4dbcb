"""How much light materials reflect in four bands, and which of them mirror the sky.

Sources, by the short names that the table uses:

SLUM
    Kotthaus, Smith, Wooster & Grimmond 2014, ISPRS J. Photogramm. Remote Sens. 94, doi 10.1016/j.isprsjprs.2014.05.005;
    data doi 10.5281/zenodo.4263842 (CC BY 4.0). Measured reflectance of London samples at the rows of 349.7, 449.7,
    519.6 and 620.5 nm; the numbers of the samples are given, several are averaged.
Feister
    Feister & Grewe 1995, Photochem. Photobiol. 62, 736–744: albedo in 315–400 nm of 0.02 over vegetation and 0.05–0.08
    over bare soil; dry bright sand 0.14 at 300 nm to 0.24 at 400 nm.
McKenzie
    McKenzie, Kotkamp & Ireland 1996, Geophys. Res. Lett. 23: albedo of long grass 0.02 at 400 nm and 0.045 at 450 nm.
JHU
    Needle piles of conifers, Johns Hopkins University spectra in the ASTER and ECOSTRESS libraries (Baldridge et al.
    2009, doi 10.1016/j.rse.2008.11.007): 0.042, 0.049, 0.088, 0.057.
Yang
    Yang, Heisler, Montgomery, Sullivan, Whereat & Miller 1995, Int. J. Biometeorol. 38, 60–66: leaves let hardly any
    ultraviolet through. The share that they let through in the other bands is assumed to be what they scatter back.
Fresnel
    Refractive indices: soda-lime glass 1.52 (Rubin 1985, doi 10.1016/0165-1633(85)90052-8), water 1.34 (Hale & Querry
    1973, doi 10.1364/AO.12.000555; 1.343 to 1.332 from 350 to 620 nm).

What the table calls assumed is ours, set between its neighbours where no measurement was at hand.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats
from insectnav.checks import as_numbers, check_choice, check_range
from insectnav.worlds.skylight import BANDS

GREY_PLANTS, GREY_GROUND, GREY_SKY = 64 / 255, 0.1, 1.0  # flat figures: Stone et al. 2018, doi 10.1098/rsfs.2018.0010


@dataclass(frozen=True, kw_only=True)
class Material:
    """Optical properties of one material.

    Parameters
    ----------
    diffuse : four numbers in 0…1
        Share of the light that is scattered to all sides, at 350, 450, 520 and 620 nm (uv, blue, green, red).
    through : four numbers in 0…1
        Share that is scattered to the other side of a thin thing, in the same bands.
    source : str
        Where the numbers come from, short names as at the top of the module.
    assumed : str
        Which of them are assumed and why; empty if none.
    is_ground : bool
        Whether the flat figures draw it as ground.
    refractive_index : float
        Of the clear surface that mirrors the sky; 1 is none.
    n_surfaces : int
        How many such surfaces lie behind each other: a pane has two.
    metal_mirror : float
        Share that bare metal mirrors at any angle.
    """

    diffuse: tuple[float, float, float, float]
    source: str
    assumed: str = ""
    through: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    is_ground: bool = False
    refractive_index: float = 1.0
    n_surfaces: int = 1
    metal_mirror: float = 0.0


_GREENER = "520 and 620 nm: 450 nm times the ratios of JHU"
_VISIBLE = "450, 520 and 620 nm"
_THROUGH = "what goes through in the visible: as much as is scattered back"
_PAINT = "diffuse: paint under a clear coat that takes up the ultraviolet"

MATERIALS = {
    # Plants. Leaves, grass and needles are the tussocks, shrubs and crowns; straw is dry grass.
    "leaves": Material(
        diffuse=(0.020, 0.045, 0.082, 0.053), through=(0.0, 0.045, 0.082, 0.053), source="Feister, McKenzie, Yang",
        assumed=f"{_GREENER}; {_THROUGH}",
    ),
    "grass": Material(
        diffuse=(0.020, 0.045, 0.082, 0.053), source="Feister, McKenzie", assumed=_GREENER, is_ground=True
    ),
    "needles": Material(diffuse=(0.042, 0.049, 0.088, 0.057), source="JHU"),
    "straw": Material(
        diffuse=(0.050, 0.10, 0.16, 0.24), through=(0.0, 0.10, 0.16, 0.24),
        source="Feister (the upper end of plants), Yang", assumed=f"{_VISIBLE}; {_THROUGH}",
    ),
    "bark": Material(diffuse=(0.050, 0.08, 0.11, 0.15), source="Feister (as soil)", assumed="all bands"),
    "timber": Material(diffuse=(0.050, 0.15, 0.22, 0.32), source="Feister (as soil)", assumed="all bands"),
    # Ground.
    "soil": Material(diffuse=(0.065, 0.10, 0.14, 0.20), source="Feister", assumed=_VISIBLE, is_ground=True),
    "litter": Material(diffuse=(0.040, 0.06, 0.09, 0.14), source="Feister", assumed="all bands", is_ground=True),
    "sand": Material(diffuse=(0.190, 0.28, 0.34, 0.40), source="Feister", assumed=_VISIBLE, is_ground=True),
    "asphalt": Material(diffuse=(0.083, 0.113, 0.132, 0.155), source="SLUM A001–A006, A008–A010", is_ground=True),
    "paving": Material(diffuse=(0.219, 0.284, 0.322, 0.358), source="SLUM G002, weathered granite", is_ground=True),
    # Buildings.
    "concrete": Material(diffuse=(0.176, 0.227, 0.266, 0.314), source="SLUM C002, C004, C006, C008"),
    "brick": Material(diffuse=(0.112, 0.117, 0.134, 0.274), source="SLUM B004, B013, weathered red ceramic"),
    "render": Material(diffuse=(0.203, 0.373, 0.459, 0.589), source="SLUM B012, white paint on brick"),
    "white paint": Material(
        diffuse=(0.203, 0.70, 0.76, 0.78), source="SLUM B012, white paint on brick, at 350 nm",
        assumed=f"{_VISIBLE}: a fresh coat, B012 being soiled; its rutile may take up more of the ultraviolet",
    ),
    "limestone": Material(diffuse=(0.293, 0.439, 0.542, 0.673), source="SLUM S004"),
    "sandstone": Material(diffuse=(0.181, 0.255, 0.320, 0.418), source="SLUM S001"),
    "tiles": Material(diffuse=(0.059, 0.069, 0.080, 0.122), source="SLUM R010, R012, R013, weathered red ceramic"),
    "slate": Material(diffuse=(0.067, 0.082, 0.094, 0.107), source="SLUM L001u, weathered"),
    "window": Material(
        diffuse=(0.02, 0.02, 0.02, 0.02), source="Fresnel", assumed="diffuse: a dark room; double glazing",
        refractive_index=1.52, n_surfaces=4,
    ),
    "metal": Material(
        diffuse=(0.291, 0.357, 0.380, 0.367), source="SLUM Z001, aluminium-zinc sheet", assumed="mirrored share",
        metal_mirror=0.3,
    ),
    "weathered metal": Material(diffuse=(0.144, 0.271, 0.282, 0.287), source="SLUM Z006, weathered aluminium"),
    # What moves, and water.
    "dark paint": Material(
        diffuse=(0.03, 0.04, 0.04, 0.05), source="Fresnel", assumed=_PAINT, refractive_index=1.5
    ),
    "light paint": Material(
        diffuse=(0.06, 0.45, 0.50, 0.50), source="Fresnel", assumed=_PAINT, refractive_index=1.5
    ),
    "red paint": Material(diffuse=(0.04, 0.04, 0.05, 0.35), source="Fresnel", assumed=_PAINT, refractive_index=1.5),
    "cloth": Material(diffuse=(0.08, 0.12, 0.13, 0.18), source="none", assumed="all bands"),
    "water": Material(
        diffuse=(0.02, 0.03, 0.03, 0.02), source="Fresnel", assumed="diffuse", is_ground=True, refractive_index=1.34
    ),
}  # fmt: skip


def reflectance(materials: Sequence[str], band: str, known: Mapping[str, Material] = MATERIALS) -> Floats:
    """Diffuse reflectance of each material in one band, (material,) array in 0…1.

    Parameters
    ----------
    materials : sequence of str
        Names in `MATERIALS`, as in ``mesh.materials``.
    band : str
        "uv", "blue", "green", "red", or "grey" for the two flat greys of the published figures.
    known : name → Material

    Raises
    ------
    InputError
        If a material or the band is unknown.
    """
    check_choice("band", band, (*BANDS, "grey"))
    chosen = [_material(name, known) for name in materials]
    if band == "grey":
        return np.array([GREY_GROUND if material.is_ground else GREY_PLANTS for material in chosen])
    return np.array([material.diffuse[list(BANDS).index(band)] for material in chosen])


def transmittance(materials: Sequence[str], band: str, known: Mapping[str, Material] = MATERIALS) -> Floats:
    """Share of the light that each material scatters to its other side in one band, (material,) array in 0…1.

    Parameters
    ----------
    materials, band, known
        As of `reflectance`; not "grey".

    Raises
    ------
    InputError
        If a material or the band is unknown.
    """
    check_choice("band", band, tuple(BANDS))
    return np.array([_material(name, known).through[list(BANDS).index(band)] for name in materials])


def mirror_optics(materials: Sequence[str], known: Mapping[str, Material] = MATERIALS) -> Floats:
    """What `mirror_fraction` needs of each material, (material, 3): refractive index, number of surfaces, metal share.

    Raises
    ------
    InputError
        If a material is unknown.
    """
    chosen = [_material(name, known) for name in materials]
    return np.array([(one.refractive_index, float(one.n_surfaces), one.metal_mirror) for one in chosen])


def mirror_fraction(material: str, cos_incidence: npt.ArrayLike) -> Floats:
    """Share of the light from the mirror direction that a surface reflects as a mirror does.

    Parameters
    ----------
    material : str
        Name in `MATERIALS`.
    cos_incidence : array in 0…1
        Cosine of the angle between the ray and the normal: 1 is straight on, 0 is grazing.

    Returns
    -------
    array
        Of the same shape, in 0…1; 0 for all that does not mirror.

    Raises
    ------
    InputError
        If the material is unknown or a cosine is not within 0…1.

    Notes
    -----
    Fresnel's equations for a clear surface, unpolarised: the mean over the two polarisations. In each, n surfaces of
    reflectance R without absorption between them reflect n R / (1 + (n − 1) R) (Stokes' pile of plates). The same in
    all bands; a bare metal is taken as equal at all angles.
    """
    cosine = np.asarray(as_numbers("cos_incidence", cos_incidence), dtype=np.float64)
    check_range("cos_incidence", cosine, 0.0, 1.0)
    properties = _material(material)
    if properties.metal_mirror:
        return np.full(cosine.shape, properties.metal_mirror)
    index, n = properties.refractive_index, properties.n_surfaces
    if index == 1.0:
        return np.zeros(cosine.shape)
    inside = np.sqrt(1 - (1 - cosine**2) / index**2)  # cosine of the refracted ray
    across = ((cosine - index * inside) / (cosine + index * inside)) ** 2
    along = ((index * cosine - inside) / (index * cosine + inside)) ** 2
    piles = [n * single / (1 + (n - 1) * single) for single in (across, along)]
    return np.asarray((piles[0] + piles[1]) / 2)


def _material(name: str, known: Mapping[str, Material] = MATERIALS) -> Material:
    check_choice("material", name, tuple(known))
    return known[name]
