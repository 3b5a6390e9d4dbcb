"""Fig. 9, Disposal Site: places recognised between two passages of a remote-controlled car."""

from collections.abc import Sequence

from insectnav.experiments.experiment import Results
from insectnav.experiments.stone2016_places import car_runs
from insectnav.experiments.stone2016_places.frames import Section
from insectnav.experiments.stone2016_places.sites import YARD

FIGURE = "Fig. 9"
TITLE = "Disposal Site, rendered: FAB-MAP, SeqSLAM on grey pictures and on the sky, all rotations"
MADE_OF = "a built forest road with a junction, a yard and a hut, zig-zag over the last 30 % of the second passage"
# Both sites of the car are recognised alike.
Cell = Section
simulate, summarise, draw, compare = car_runs.simulate, car_runs.summarise, car_runs.draw, car_runs.compare


def grid(scale: str) -> Sequence[Section]:
    """Two passages over the whole way and training passages elsewhere; or the beginnings, in small pictures."""
    return car_runs.cells_of(YARD.name, scale)


def caption(results: Results) -> str:
    """What the figure shows."""
    return car_runs.caption(results, MADE_OF)
