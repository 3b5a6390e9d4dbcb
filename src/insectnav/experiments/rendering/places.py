"""The surfaces that are rendered: a built world at a time, or a mesh from a file."""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path, PurePath
from typing import Any

import numpy as np

from insectnav.angles import Floats
from insectnav.checks import InputError, as_numbers, check_choice, check_range, quoted
from insectnav.records import Mesh
from insectnav.worlds.builders import BUILDERS, build_world
from insectnav.worlds.built_world import BuiltWorld
from insectnav.worlds.materials import MATERIALS, reflectance
from insectnav.worlds.mesh_files import read_mesh
from insectnav.worlds.world import EYE_HEIGHT, World, flat_world

LIGHTS = ("sky", "flat")


@dataclass(frozen=True, kw_only=True)
class PlaceParams:
    """Which world.

    Parameters
    ----------
    world : str
        A name in `insectnav.worlds.builders.BUILDERS`, or a mesh file.
    seed : int
        Of a built world.
    changes : name → value
        Parameters of the builder that differ from its defaults.
    world_time_s : float
        At which cars and people are shown at first [s].
    up, metres_per_unit
        Of a mesh file, as of `insectnav.worlds.read_mesh`.
    material : str or None
        Of all surfaces of a mesh file, a name in `insectnav.worlds.materials.MATERIALS`.
    light : "sky", "flat" or None
        Lit by the sky, or in the flat greys of the published figures; None is "sky" if all materials are known.

    Raises
    ------
    InputError
        If an option has no meaning for that kind of world.
    """

    world: str
    seed: int = 0
    changes: Mapping[str, Any]
    world_time_s: float = 0.0
    up: str | None = None
    metres_per_unit: float | None = None
    material: str | None = None
    light: str | None = None

    def __post_init__(self) -> None:
        if self.light is not None:
            check_choice("light", self.light, LIGHTS)
        if self.material is not None:
            check_choice("material", self.material, tuple(MATERIALS))
            if self.light == "flat":
                raise InputError("a material has no meaning in flat light, expected one of the two")
        check_range("world time", self.world_time_s, -1e9, 1e9, "s")
        if not self.is_built:
            given = ["--set"] * bool(self.changes) + ["--world-time"] * bool(self.world_time_s)
            given += ["--seed"] * bool(self.seed)
            expected = "one of " + ", ".join(BUILDERS)
        else:
            check_choice("world without the ending of a file", self.world, tuple(BUILDERS))
            named = {"--up": self.up, "--metres-per-unit": self.metres_per_unit, "--material": self.material}
            given = [name for name, value in named.items() if value is not None]
            expected = "a mesh file (npz, OBJ, PLY, GLB)"
            if "time_s" in self.changes:
                raise InputError("--set time_s is given, expected --world-time, from which time runs on")
            if self.world_time_s and not self.moves:
                raise InputError(f"nothing moves in {self.world}, expected no --world-time")
        if given:
            raise InputError(f"{given[0]} has no meaning for the world {quoted(self.world)}, expected {expected}")

    @property
    def is_built(self) -> bool:
        """Whether the world is made by a builder."""
        return is_built(self.world)

    @property
    def moves(self) -> bool:
        """Whether cars and people move in it."""
        return self.is_built and hasattr(BUILDERS[self.world].parameters, "time_s")


@dataclass(frozen=True, kw_only=True, eq=False)
class Place:
    """A world as far as light and time leave it alone.

    Parameters
    ----------
    surfaces : BuiltWorld or Mesh
        What `insectnav.worlds.lit_world.light_world` takes.
    route : (n, 2) array of x, y [m]
        Way points; of a mesh file the middle of its extent, once.
    ground_height : from positions (n, 2) to heights (n,) [m]
    eye_height : [m]
    light : "sky" or "flat"
    origin : name → value
        What identifies it in a table of results.
    """

    surfaces: BuiltWorld | Mesh
    route: Floats
    ground_height: Callable[[Floats], Floats]
    eye_height: float
    light: str
    origin: Mapping[str, Any]

    @property
    def mesh(self) -> Mesh:
        """Its triangles."""
        return self.surfaces.mesh if isinstance(self.surfaces, BuiltWorld) else self.surfaces

    @property
    def name(self) -> str:
        """What to call it."""
        return self.surfaces.name

    @property
    def foliage(self) -> float | None:
        """Season of a built world, 0 to 1."""
        return getattr(self.surfaces.parameters, "foliage", None) if isinstance(self.surfaces, BuiltWorld) else None

    def flat(self) -> World:
        """The world in the flat greys of the published figures."""
        mesh = self.mesh
        known = isinstance(self.surfaces, BuiltWorld)
        return flat_world(mesh, plants=reflectance(mesh.materials, "grey")[mesh.material] if known else None)


def is_built(world: str) -> bool:
    """Whether a world is the name of a builder rather than that of a file."""
    return not PurePath(world).suffix


def open_place(params: PlaceParams, seconds: float = 0.0) -> Place:
    """The world so many seconds after the first moment.

    Raises
    ------
    InputError
        If a parameter is unknown, or the file holds no mesh.
    """
    return _built(params, seconds) if params.is_built else _from_file(params)


def parameter_values(world: str, settings: Mapping[str, str]) -> dict[str, Any]:
    """Values of parameters of a builder from how they are written: ``"0.3"``, ``"12,20"``, ``"sand"``.

    Parameters
    ----------
    world : name in `BUILDERS`
    settings : name → text

    Raises
    ------
    InputError
        If a name is unknown, or a text is not of the kind of the default.
    """
    check_choice("world", world, tuple(BUILDERS))
    defaults = BUILDERS[world].parameters
    known = [field.name for field in fields(defaults)]
    values = {}
    for name, text in settings.items():
        check_choice(f"parameter of {world}", name, known)
        default = getattr(defaults, name)
        try:
            values[name] = _like(default, text.strip())
        except ValueError:
            shown = ",".join(map(str, default)) if isinstance(default, tuple) else default
            raise InputError(f"--set {name} is {quoted(text)}, expected something like {shown}") from None
    return values


def _like(default: Any, text: str) -> Any:
    """A text as a value of the same kind as the default."""
    if isinstance(default, tuple):
        parts = text.split(",")
        if len(parts) != len(default):
            raise ValueError
        return tuple(_like(one, part.strip()) for one, part in zip(default, parts, strict=True))
    return type(default)(text)


def _built(params: PlaceParams, seconds: float) -> Place:
    changes = dict(params.changes)
    if params.moves:
        changes["time_s"] = params.world_time_s + seconds
    built = build_world(params.world, params.seed, **changes)
    return Place(
        surfaces=built,
        route=built.route,
        ground_height=built.ground_height,
        eye_height=BUILDERS[params.world].eye_height,
        light=params.light or "sky",
        origin={"world": built.name, "seed": built.seed},
    )


def _from_file(params: PlaceParams) -> Place:
    mesh = read_mesh(params.world, up=params.up, metres_per_unit=params.metres_per_unit or 1.0)
    if params.material is not None:
        mesh = replace(mesh, material=None, materials=(params.material,))
    unknown = [name for name in mesh.materials if name not in MATERIALS]
    light = params.light or ("flat" if unknown else "sky")
    if unknown and light == "sky":
        raise InputError(
            f"{quoted(params.world, 200)} has the material {quoted(unknown[0])}, whose reflectance is not known: "
            "expected --material NAME for all surfaces, or --light flat"
        )
    digest = hashlib.sha256(Path(params.world).read_bytes()).hexdigest()
    return Place(
        surfaces=mesh,
        route=as_numbers("middle", mesh.bounds[:, :2].mean(axis=0, keepdims=True)),
        ground_height=lambda positions: np.zeros(len(positions)),
        eye_height=EYE_HEIGHT,
        light=light,
        origin={"world": mesh.name, "sha256": digest},
    )
