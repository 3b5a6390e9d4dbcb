"""The worlds that can be built, by name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any

from insectnav.checks import InputError, check_choice
from insectnav.worlds.ant_world import SHRUBLAND, AntWorldParams, ant_world
from insectnav.worlds.built_world import BuiltWorld
from insectnav.worlds.city import CityParams, city
from insectnav.worlds.forest import ForestParams, forest_trail
from insectnav.worlds.street import StreetParams, suburban_street


@dataclass(frozen=True, kw_only=True)
class Builder:
    """A kind of world.

    Parameters
    ----------
    build : function
        From parameters and ``seed=`` to a `BuiltWorld`.
    parameters : frozen dataclass
        The default ones; ``dataclasses.replace`` makes others.
    eye_height : float
        Of the animal or camera that the world is made for, above the ground [m].
    about : str
        What it is, in one line.
    """

    build: Callable[..., BuiltWorld]
    parameters: Any
    eye_height: float  # [m]
    about: str


BUILDERS: Mapping[str, Builder] = {
    "ant-world": Builder(
        build=ant_world,
        parameters=AntWorldParams(),
        eye_height=0.01,
        about="tussocks, shrubs and trees round a clearing of 12 m radius",
    ),
    "shrubland": Builder(
        build=ant_world, parameters=SHRUBLAND, eye_height=0.01, about="low plants everywhere, 14 m across"
    ),
    "city": Builder(
        build=city,
        parameters=CityParams(),
        eye_height=2.0,
        about="streets, squares and parks, with a closed walk of two kilometres",
    ),
    "forest-trail": Builder(
        build=forest_trail, parameters=ForestParams(), eye_height=0.3, about="a trail under a canopy with gaps"
    ),
    "suburban-street": Builder(
        build=suburban_street, parameters=StreetParams(), eye_height=0.3, about="houses, hedges, trees and cars"
    ),
}


def build_world(name: str, seed: int = 0, **changes: Any) -> BuiltWorld:
    """A world of this name, with some of its parameters changed.

    Parameters
    ----------
    name : str
        One of `BUILDERS`.
    seed : int
        Not negative; the same seed gives the same world, bit for bit.
    **changes
        Parameters of the builder that differ from its defaults, by name.

    Raises
    ------
    InputError
        If the world or a parameter is unknown, or a value makes no sense.

    Examples
    --------
    >>> build_world("ant-world", seed=3, tree_density=0.0).mesh.materials
    ('straw', 'leaves', 'bark', 'sand')
    """
    check_choice("world", name, tuple(BUILDERS))
    builder = BUILDERS[name]
    known = {field.name: getattr(builder.parameters, field.name) for field in fields(builder.parameters)}
    for change in changes:
        check_choice(f"parameter of {name}", change, tuple(known))
    try:
        parameters = type(builder.parameters)(**(known | changes))
    except TypeError as error:
        raise InputError(f"a parameter of {name} is of the wrong kind: {error}") from None
    return builder.build(parameters, seed=seed)
