"""Experiments: simulate, summarise, draw, compare with what was published, and leave everything in a folder."""

from importlib import import_module
from typing import TYPE_CHECKING, cast

from insectnav.checks import check_choice

if TYPE_CHECKING:
    from insectnav.experiments.experiment import Experiment

_STONE_2014 = "insectnav.experiments.stone2014_sky_segmentation"
_STONE_2014_PLACES = "insectnav.experiments.stone2014_places"
_STONE_2017 = "insectnav.experiments.stone2017_path_integration"
_STONE_2016 = "insectnav.experiments.stone2016_homing"
_STONE_2016_PLACES = "insectnav.experiments.stone2016_places"
_RECORDINGS = "insectnav.experiments.recordings"
_MODULES = {
    "stone2014-table-1": f"{_STONE_2014}.table_1",
    "stone2014-fig-2": f"{_STONE_2014}.fig_2",
    "stone2014-fig-3": f"{_STONE_2014}.fig_3",
    "stone2014-real-photographs": f"{_STONE_2014}.real_photographs",
    "stone2014-sensitivity": f"{_STONE_2014}.sensitivity",
    "stone2014-fig-4ab": f"{_STONE_2014_PLACES}.fig_4ab",
    "stone2014-fig-4cd": f"{_STONE_2014_PLACES}.fig_4cd",
    "stone2014-descriptors-walk": f"{_STONE_2014_PLACES}.descriptors_walk",
    "stone2014-walk-sensitivity": f"{_STONE_2014_PLACES}.walk_sensitivity",
    "stone2017-fig-4h": f"{_STONE_2017}.fig_4h",
    "stone2017-fig-5a": f"{_STONE_2017}.fig_5a",
    "stone2017-fig-5b": f"{_STONE_2017}.fig_5b",
    "stone2017-fig-5c": f"{_STONE_2017}.fig_5c",
    "stone2017-fig-5d": f"{_STONE_2017}.fig_5d",
    "stone2017-fig-5e": f"{_STONE_2017}.fig_5e",
    "stone2017-ed-6": f"{_STONE_2017}.ed_6",
    "stone2017-ed-7": f"{_STONE_2017}.ed_7",
    "stone2017-ed-8": f"{_STONE_2017}.ed_8",
    "stone2017-ed-9a": f"{_STONE_2017}.ed_9a",
    "stone2017-ed-9bcd": f"{_STONE_2017}.ed_9bcd",
    "stone2017-ed-10abc": f"{_STONE_2017}.ed_10abc",
    "stone2017-ed-10def": f"{_STONE_2017}.ed_10def",
    "stone2017-detours": f"{_STONE_2017}.detours",
    "stone2017-search": f"{_STONE_2017}.search",
    "stone2017-waggle-dance": f"{_STONE_2017}.waggle_dance",
    "stone2017-migration": f"{_STONE_2017}.migration",
    "stone2017-vector-navigation": f"{_STONE_2017}.vector_navigation",
    "stone2017-physiology": f"{_STONE_2017}.physiology",
    "stone2016-fig-4-3": f"{_STONE_2016}.fig_4_3",
    "stone2016-fig-4-4": f"{_STONE_2016}.fig_4_4",
    "stone2016-fig-4-5": f"{_STONE_2016}.fig_4_5",
    "stone2016-fig-4-6": f"{_STONE_2016}.fig_4_6",
    "stone2016-sampling": f"{_STONE_2016}.sampling",
    "stone2016-coding": f"{_STONE_2016}.coding",
    "stone2016-clutter": f"{_STONE_2016}.clutter",
    "stone2016-fig-4-1": f"{_STONE_2016_PLACES}.fig_4_1",
    "stone2016-fig-4-2": f"{_STONE_2016_PLACES}.fig_4_2",
    "stone2016-fig-5": f"{_STONE_2016_PLACES}.fig_5",
    "stone2016-fig-8": f"{_STONE_2016_PLACES}.fig_8",
    "stone2016-fig-9": f"{_STONE_2016_PLACES}.fig_9",
    "stone2016-cost": f"{_STONE_2016_PLACES}.cost",
    "recordings-nordland": f"{_RECORDINGS}.nordland",
    "recordings-sussex": f"{_RECORDINGS}.sussex",
    "recordings-tilted-skies": f"{_RECORDINGS}.tilted_skies",
    "recordings-constellations": f"{_RECORDINGS}.constellations",
}


def names() -> tuple[str, ...]:
    """Names of all experiments, by paper and in the order of its figures."""
    return tuple(_MODULES)


def load(name: str) -> "Experiment":
    """The experiment of that name: a module with the functions of `insectnav.experiments.experiment.Experiment`.

    Raises
    ------
    InputError
        If there is none.
    """
    check_choice("experiment", name, names())
    return cast("Experiment", import_module(_MODULES[name]))
