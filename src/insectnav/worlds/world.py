"""A world: a mesh, and how bright its surfaces, the sky and the ground are in each band."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import PurePath
from typing import Any

import numpy as np
import numpy.typing as npt

from insectnav.checks import InputError, as_numbers, check_choice, check_finite, check_range, check_shape
from insectnav.records import Mesh
from insectnav.worlds.mesh_files import read_mesh

EYE_HEIGHT = 0.01  # [m] thesis section 4.3, where a position has no z
SKY, GROUND, PLANT = 1.0, 0.1, 64 / 255  # brightness in the published views of section 4.3
Float32s = npt.NDArray[np.float32]


@dataclass(frozen=True, kw_only=True, eq=False)
class World:
    """A mesh with the brightness of everything in one or more bands; arrays are read-only copies.

    Parameters
    ----------
    mesh : Mesh
    brightness : band → (triangle,) array in 0…1; one number stands for all triangles
    sky : band → brightness of whatever is above the horizon and not covered
    ground : band → brightness of whatever is below the horizon and not covered
    extent : least and greatest x, y (2, 2) [m] of positions within the world; None for the bounds of the mesh

    Raises
    ------
    InputError
        If a brightness is missing for a band, is outside 0…1, or is not one for each triangle.

    Notes
    -----
    The ground is the plane z = 0 seen from above. It hides nothing: a surface below it is seen, too.
    """

    mesh: Mesh
    brightness: Mapping[str, Float32s]
    sky: Mapping[str, float]
    ground: Mapping[str, float]
    extent: npt.NDArray[np.float64] | None = None
    corners: Float32s = field(init=False, repr=False)  # (3, 3 * triangle) as kernels read them

    def __post_init__(self) -> None:
        if not self.brightness:
            raise InputError("the world has no bands, expected the brightness in at least one")
        held = {}
        for band, values in self.brightness.items():
            for name, table in (("sky", self.sky), ("ground", self.ground)):
                check_choice(f"band of the {name}", band, tuple(table))
                check_range(f"brightness of the {name}", table[band], 0, 1)
            array = as_numbers(f"brightness in {band}", values).astype(np.float32)
            if array.ndim:
                check_shape(f"brightness in {band}", array, (self.mesh.n_triangles,))
            check_range(f"brightness in {band}", array, 0, 1, slip="in 0 to 255?")
            held[band] = _read_only(np.broadcast_to(array, self.mesh.n_triangles))
        extent = self.mesh.bounds[:, :2] if self.extent is None else as_numbers("extent", self.extent).astype(float)
        check_shape("extent", extent, (2, 2))
        check_finite("extent", extent)
        object.__setattr__(self, "brightness", held)
        object.__setattr__(self, "extent", _read_only(extent))
        object.__setattr__(self, "corners", _read_only(self.mesh.vertices.reshape(-1, 3).T))

    @property
    def bands(self) -> tuple[str, ...]:
        """Names of the bands."""
        return tuple(self.brightness)


def flat_world(
    mesh: Mesh,
    *,
    plants: npt.ArrayLike | None = None,
    sky: float = SKY,
    ground: float = GROUND,
    extent: npt.ArrayLike | None = None,
) -> World:
    """World in flat grey, as the published views are drawn: one band, "grey".

    Parameters
    ----------
    mesh : Mesh
    plants : number or (triangle,) array in 0…1; None for the mesh's own grey, and 64/255 where it has none
    sky, ground : brightness above and below the horizon where nothing is
    extent : see `World`

    Raises
    ------
    InputError
        If a brightness is outside 0…1.

    Notes
    -----
    Thesis section 4.3 and the code of Stone et al. (2018), Interface Focus, for sky, ground and plants.
    """
    if plants is None:
        plants = PLANT if mesh.grey is None else mesh.grey
    return World(
        mesh=mesh,
        brightness={"grey": np.asarray(plants)},
        sky={"grey": sky},
        ground={"grey": ground},
        extent=None if extent is None else np.asarray(extent),
    )


def load_world(
    source: str | PathLike[str] | Mesh,
    *,
    plants: npt.ArrayLike | None = None,
    sky: float = SKY,
    ground: float = GROUND,
    extent: npt.ArrayLike | None = None,
    **parameters: Any,
) -> World:
    """World in flat grey, from a file (npz, OBJ, PLY, GLB), from a built-in builder, or of a mesh.

    Parameters
    ----------
    source : path of a file, name of a builder in `insectnav.worlds.builders`, or Mesh
    plants, sky, ground, extent : as of `flat_world`; plants of a built world have the grey of their materials
    **parameters : of the builder, and ``seed``; for a file, those of `insectnav.worlds.read_mesh`

    Raises
    ------
    InputError
        If the file holds no mesh, or a parameter is unknown; one sentence that names it.
    """
    if isinstance(source, Mesh):
        mesh = source
    elif (built := _build(str(source), parameters)) is not None:
        mesh, greys = built
        plants = greys if plants is None else plants
    else:
        for name in parameters:
            check_choice("option", name, ("up", "metres_per_unit"))
        mesh = read_mesh(source, **parameters)
    return flat_world(mesh, plants=plants, sky=sky, ground=ground, extent=extent)


def _build(name: str, parameters: dict[str, Any]) -> tuple[Mesh, npt.NDArray[Any]] | None:
    """Mesh of a built world and the grey of its triangles; None for the name of a file."""
    from insectnav.worlds.builders import BUILDERS, build_world
    from insectnav.worlds.materials import reflectance

    if PurePath(name).suffix:
        return None
    check_choice("world without the ending of a file", name, tuple(BUILDERS))
    mesh = build_world(name, **parameters).mesh
    return mesh, np.asarray(reflectance(mesh.materials, "grey"))[mesh.material]


def check_positions(world: World, positions: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Positions x, y, z (n, 3) [m] of an eye in the world; where no z is given, it is 0.01 m.

    Parameters
    ----------
    world : World
    positions : (n, 2 or 3) array [m]

    Raises
    ------
    InputError
        If a position is not finite, outside the world or not above the ground.
    """
    array = as_numbers("positions", positions).astype(np.float64)
    if array.ndim != 2 or array.shape[1] not in (2, 3):
        raise InputError(f"positions has shape {array.shape}, expected (n, 2) or (n, 3): one row for each view")
    check_finite("positions", array)
    extent: Any = world.extent
    outside = ((array[:, :2] < extent[0]) | (array[:, :2] > extent[1])).any(axis=1)
    if outside.any():
        index, (low, high) = int(np.argmax(outside)), extent
        x, y = array[index, :2]
        raise InputError(
            f"position {index} at ({x:g}, {y:g}) m lies outside the world, which reaches from ({low[0]:g}, {low[1]:g}) "
            f"to ({high[0]:g}, {high[1]:g}) m"
        )
    if array.shape[1] == 2:
        return np.column_stack([array, np.full(len(array), EYE_HEIGHT)])
    below = array[:, 2] <= 0
    if below.any():
        index = int(np.argmax(below))
        raise InputError(f"position {index} has the eye {array[index, 2]:g} m high, expected above the ground, z > 0")
    return array


def _read_only(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    array = np.array(values, order="C")
    array.setflags(write=False)
    return array
