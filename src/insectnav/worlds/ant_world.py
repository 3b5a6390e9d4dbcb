"""The ant world: tussocks, shrubs and trees round a clearing, as in the simulated worlds of ant research."""

from dataclasses import dataclass

import numpy as np

from insectnav.checks import check_choice, check_count, check_range
from insectnav.worlds.built_world import BuiltWorld
from insectnav.worlds.ground import Relief, ground_height, ground_patch
from insectnav.worlds.plants import BROADLEAF, check_heights, on_ground, scattered, shrubs, trees, tussocks
from insectnav.worlds.shapes import Part, generator, mesh_from

WAY_STEP = 0.1  # [m]
MAX_DENSITY = 5.0  # plants on a square metre
GROUNDS = ("sand", "soil", "litter", "grass")
_SHRUB_REACH = 0.6  # of its height


@dataclass(frozen=True, kw_only=True)
class AntWorldParams:
    """What an ant world is made of.

    Parameters
    ----------
    radius : float
        Of the world about its centre [m].
    clearing : float
        Radius about the centre in which nothing grows or hangs over [m].
    tussock_density, shrub_density, tree_density : float
        Plants on a square metre, outside a radius at which they cannot reach into the clearing.
    tussock_height, shrub_height, tree_height : pairs of float
        Least and greatest [m]; all between are as likely.
    n_blades : int
        Of a tussock.
    foliage : float
        Season: 0 for bare twigs and half of the blades, 1 for summer.
    hills : float
        Height of gentle hills outside the clearing [m].
    ground : str
        "sand", "soil", "litter" or "grass".

    Raises
    ------
    InputError
        If a number makes no sense.

    Notes
    -----
    The defaults are like the clearing world of Stone et al. 2018 (doi 10.1098/rsfs.2018.0010), measured in its
    published mesh: 80 m across, nothing within 12.1 m of the centre, highest tree 14 m. `SHRUBLAND` is like the site
    near Seville of Baddeley et al. 2012 (doi 10.1371/journal.pcbi.1002336): some 10 m across and grown over everywhere,
    half of it below 0.2 m and nothing above 1.7 m. Both are alike in size and density only; where the plants stand is
    random.
    """

    radius: float = 40.0  # [m]
    clearing: float = 12.0  # [m]
    tussock_density: float = 0.045  # [1/m²]
    shrub_density: float = 0.015  # [1/m²]
    tree_density: float = 0.007  # [1/m²]
    tussock_height: tuple[float, float] = (0.4, 1.3)  # [m]
    shrub_height: tuple[float, float] = (0.8, 2.5)  # [m]
    tree_height: tuple[float, float] = (5.0, 14.0)  # [m]
    n_blades: int = 9
    foliage: float = 1.0
    hills: float = 0.0  # [m]
    ground: str = "sand"

    def __post_init__(self) -> None:
        check_range("radius of the world", self.radius, 0.5, 1000.0, "m")
        check_range("clearing", self.clearing, 0.0, 0.9 * self.radius, "m")
        for kind in ("tussock", "shrub", "tree"):
            check_range(
                f"{kind}_density", getattr(self, f"{kind}_density"), 0.0, MAX_DENSITY, "plants on a square metre"
            )
            check_heights(f"{kind}_height", getattr(self, f"{kind}_height"))
        check_count("n_blades", self.n_blades)
        check_range("foliage", self.foliage, 0.0, 1.0, slip="in percent?")
        check_range("hills", self.hills, 0.0, 50.0, "m")
        check_choice("ground", self.ground, GROUNDS)


SHRUBLAND = AntWorldParams(
    radius=7.0,
    clearing=0.3,
    tussock_density=2.5,
    shrub_density=0.25,
    tree_density=0.0,
    tussock_height=(0.1, 0.5),
    shrub_height=(0.4, 1.6),
)


def ant_world(params: AntWorldParams | None = None, *, seed: int = 0) -> BuiltWorld:
    """An ant world; the route runs straight from a feeder in the south of the clearing to the nest at the centre.

    Parameters
    ----------
    params : AntWorldParams
    seed : int
        Not negative. The same seed gives the same world, bit for bit; plants of one kind do not move when the
        parameters of another kind change, nor with the season.

    Raises
    ------
    InputError
        If the seed is negative, or no plant came about.
    """
    params = AntWorldParams() if params is None else params
    check_count("seed", seed, minimum=0)
    relief = Relief(height=params.hills, wavelength=params.radius / 2, level_within=params.clearing,
                    rise=params.radius / 4, seed=seed)  # fmt: skip
    reaches = {"tussock": 1.0, "shrub": _SHRUB_REACH, "tree": BROADLEAF.reach}
    parts: list[Part] = []
    for kind, reach in reaches.items():
        rng = generator(seed, f"ant world {kind}")
        least, greatest = getattr(params, f"{kind}_height")
        inner = min(params.clearing + reach * greatest, params.radius)
        place = scattered(rng, getattr(params, f"{kind}_density"), inner, params.radius)
        feet = on_ground(place, ground_height(place, relief))
        heights = least + (greatest - least) * rng.random(len(place))
        if kind == "tussock":
            parts.append(("straw", tussocks(rng, feet, heights, n_blades=params.n_blades, foliage=params.foliage)))
        else:
            parts += (shrubs if kind == "shrub" else trees)(rng, feet, heights, foliage=params.foliage)
    side = 1.25 * params.radius
    parts.append((params.ground, ground_patch((-side, -side), (side, side), relief, tile=params.radius / 40)))
    start = -0.9 * params.clearing
    way = np.linspace(start, 0.0, max(2, round(-start / WAY_STEP) + 1))
    return BuiltWorld(
        mesh=mesh_from(parts, "ant-world"),
        route=np.stack([np.zeros_like(way), way], axis=-1),
        name="ant-world",
        parameters=params,
        seed=seed,
        relief=relief,
    )
