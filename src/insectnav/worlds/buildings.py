"""Buildings as triangles: walls, roofs, windows, and the scaffolding before some of them.

In its own frame a building stands on z = 0 about the origin, and its front looks along +y.
"""

from dataclasses import dataclass

import numpy as np

from insectnav.angles import Floats
from insectnav.checks import check_choice, check_range
from insectnav.worlds.shapes import Part, box, frustum, joined, quads, upright_quads

STOREY = 3.2  # [m]
ROOFS = ("flat", "gable", "hip")
_PANE_GAP = 0.03  # [m] that a window stands out, so that it is before the wall for any eye
_EAVES = 0.35  # [m]


@dataclass(frozen=True, kw_only=True)
class Building:
    """One building.

    Parameters
    ----------
    width, depth, height : float
        Along x, along y, and of the walls [m].
    roof : str
        "flat", "gable" (ridge along x) or "hip".
    pitch : float
        Slope of the roof [rad]; a flat roof has none.
    walls, roofing : str
        Materials.
    bay : float
        From window to window along the front [m]; 0 is no windows.
    has_back_windows, has_chimney, has_scaffold : bool
    """

    width: float
    depth: float
    height: float
    roof: str = "gable"
    pitch: float = 0.7  # [rad]
    walls: str = "brick"
    roofing: str = "tiles"
    bay: float = 2.8  # [m]
    has_back_windows: bool = False
    has_chimney: bool = False
    has_scaffold: bool = False

    def __post_init__(self) -> None:
        for side in ("width", "depth", "height"):
            check_range(f"{side} of a building", getattr(self, side), 1.0, 300.0, "m")
        check_choice("roof", self.roof, ROOFS)
        check_range("pitch of a roof", self.pitch, 0.05, 1.3, "rad", slip="in degrees?")

    @property
    def top(self) -> float:
        """Height of the ridge, or of a flat roof [m]."""
        return self.height + (0.0 if self.roof == "flat" else 0.5 * self.depth * float(np.tan(self.pitch)))


def building(plan: Building) -> list[Part]:
    """Parts of a building in its own frame, each of one material."""
    walls = box(plan.width, plan.depth, plan.height)
    parts: list[Part] = [(plan.walls, walls if plan.roof == "flat" else walls[:8])]
    if plan.roof != "flat":
        roof, gables = _pitched_roof(plan)
        parts += [(plan.roofing, roof), (plan.walls, gables)]
    if plan.bay > 0:
        parts.append(("window", joined(_windows(plan))))
    if plan.has_chimney:
        chimney = box(0.9, 0.6, plan.top + 1.0 - plan.height, base=plan.height)
        parts.append(("brick", chimney + np.array([0.3 * plan.width, 0.15 * plan.depth, 0.0])))
    if plan.has_scaffold:
        parts += scaffolding(plan.width, plan.height, 0.5 * plan.depth)
    return parts


def scaffolding(width: float, height: float, front: float) -> list[Part]:
    """Two rows of metal poles and a floor of boards at each storey, before a front at y = `front` [m]."""
    n = max(2, round(width / 2.5) + 1)
    pole = frustum(4, 0.05, 0.05, height + 1.0)
    rows = [
        pole + np.array([x, front + y, 0.0]) for x in (np.arange(n) / (n - 1) - 0.5) * 0.98 * width for y in (0.3, 1.3)
    ]
    levels = np.arange(2.0, height + 0.5, 2.0)
    boards = [box(0.98 * width, 0.9, 0.06, base=level) + np.array([0.0, front + 0.8, 0.0]) for level in levels]
    rails = [box(0.98 * width, 0.05, 0.05, base=level + 1.0) + np.array([0.0, front + 1.3, 0.0]) for level in levels]
    return [("weathered metal", joined([*rows, *rails])), ("timber", joined(boards))]


def tower(side: float, height: float, walls: str, roofing: str) -> list[Part]:
    """A church tower with a spire on a square shaft: the landmark of a town. The spire is two fifths of the height."""
    check_range("side of a tower", side, 1.0, 50.0, "m")
    check_range("height of a tower", height, 2.0, 300.0, "m")
    spire = frustum(8, 0.52 * side, 0.0, 0.4 * height, base=0.6 * height)
    return [(walls, box(side, side, 0.6 * height)), (roofing, spire)]


def _windows(plan: Building) -> list[Floats]:
    """Windows of the front, and of the back if it has some; one row for each storey."""
    n_storeys = max(1, int(plan.height / STOREY))
    n_bays = max(1, int((plan.width - 1.0) / plan.bay))
    x = (np.arange(n_bays) - (n_bays - 1) / 2) * plan.bay
    z = (np.arange(n_storeys) + 0.55) * plan.height / n_storeys
    grid = np.stack(np.meshgrid(x, [0.5 * plan.depth + _PANE_GAP], z, indexing="ij"), axis=-1).reshape(-1, 3)
    front = upright_quads(grid, min(1.3, 0.6 * plan.bay), 1.5)
    return [front, front * [-1.0, -1.0, 1.0]] if plan.has_back_windows else [front]


def _pitched_roof(plan: Building) -> tuple[Floats, Floats]:
    """Slopes, which stand out over the walls all round, and the gables below them (none under a hip roof)."""
    x, y, slope = plan.width / 2, plan.depth / 2, float(np.tan(plan.pitch))
    far, wide = y + _EAVES, x + _EAVES
    eaves, ridge = plan.height - _EAVES * slope, plan.top
    end = max(wide - far, 0.0) if plan.roof == "hip" else wide
    front = [(wide, far, eaves), (-wide, far, eaves), (-end, 0.0, ridge), (end, 0.0, ridge)]
    back = [(-wide, -far, eaves), (wide, -far, eaves), (end, 0.0, ridge), (-end, 0.0, ridge)]
    slopes = quads([front, back])
    right = np.array([[(wide, -far, eaves), (wide, far, eaves), (end, 0.0, ridge)]])
    if plan.roof == "hip":
        return joined([slopes, right, right * [-1.0, -1.0, 1.0]]), np.zeros((0, 3, 3))
    gable = np.array([[(x, -y, plan.height), (x, y, plan.height), (x, 0.0, ridge)]])
    return slopes, joined([gable, gable * [-1.0, -1.0, 1.0]])
