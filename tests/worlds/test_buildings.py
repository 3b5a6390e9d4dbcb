"""Buildings: tight, as large as said, windows before the walls."""

from dataclasses import replace

import numpy as np
import pytest

from insectnav.checks import InputError
from insectnav.worlds.building_rows import PLOT, row_of_buildings
from insectnav.worlds.buildings import ROOFS, Building, building, scaffolding, tower
from insectnav.worlds.shapes import joined, triangle_areas

HOUSE = Building(width=10.0, depth=8.0, height=6.0, pitch=np.pi / 4)


def bodies(plan: Building) -> dict[str, np.ndarray]:
    parts = building(plan)
    return {name: joined([body for other, body in parts if other == name]) for name, _ in parts}


@pytest.mark.parametrize("roof", ROOFS)
def test_top_is_where_the_roof_ends(roof: str):
    plan = replace(HOUSE, roof=roof)
    highest = joined(list(bodies(plan).values()))[..., 2].max()
    assert highest == pytest.approx(plan.top)
    assert plan.top == pytest.approx(6.0 if roof == "flat" else 10.0)  # 45° over half of 8 m


def test_walls_of_a_gabled_house_have_their_area():
    """Four walls and two gables: 2 · (10 + 8) · 6 + 8 · 4."""
    assert triangle_areas(bodies(HOUSE)["brick"]).sum() == pytest.approx(216.0 + 32.0)


def test_roofs_look_up_and_walls_outwards():
    for roof in ROOFS[1:]:
        slopes = bodies(replace(HOUSE, roof=roof))["tiles"]
        normals = np.cross(slopes[:, 1] - slopes[:, 0], slopes[:, 2] - slopes[:, 0])
        assert (normals[:, 2] > 0).all()
    walls = bodies(HOUSE)["brick"]
    normals = np.cross(walls[:, 1] - walls[:, 0], walls[:, 2] - walls[:, 0])
    assert ((normals * (walls.mean(axis=1) - [0.0, 0.0, 4.0]))[:, :2].sum(axis=1) > 0).all()


def test_windows_are_before_the_wall_within_its_edges_and_by_storeys():
    windows = bodies(replace(HOUSE, height=6.5, bay=2.5))["window"]
    assert len(windows) == 2 * 3 * 2  # two storeys, three bays, two triangles
    assert (windows[..., 1] > 4.0).all()
    assert np.abs(windows[..., 0]).max() < 5.0
    assert windows[..., 2].min() > 0.3
    assert windows[..., 2].max() < 6.5
    both = bodies(replace(HOUSE, height=6.5, bay=2.5, has_back_windows=True))["window"]
    assert (both[..., 1] < -4.0).sum() == windows[..., 1].size
    assert "window" not in bodies(replace(HOUSE, bay=0.0))


def test_scaffold_stands_before_the_front():
    body = joined([part for _, part in scaffolding(12.0, 9.0, 4.0)])
    assert body[..., 1].min() > 4.0
    assert body[..., 2].min() == 0.0
    assert body[..., 2].max() == pytest.approx(10.0)
    plain, scaffolded = building(HOUSE), building(replace(HOUSE, has_scaffold=True))
    assert {name for name, _ in scaffolded} - {name for name, _ in plain} == {"weathered metal", "timber"}


def test_tower_is_as_high_as_said():
    assert joined([part for _, part in tower(6.0, 50.0, "sandstone", "slate")])[..., 2].max() == pytest.approx(50.0)


@pytest.mark.parametrize("heading", [0.0, np.pi / 2, np.pi, -np.pi / 2])
def test_row_fills_its_plot_wall_to_wall(heading: float):
    parts = row_of_buildings(
        np.random.default_rng(3), np.array([100.0, 50.0]), 80.0, heading, depth=10.0, storeys=3, is_flat=True, base=0.1,
        route=np.zeros((2, 2)), window_range=0.0, scaffold_share=0.0, gap_share=0.0,
    )  # fmt: skip
    walls = joined([body for name, body in parts if name not in ("tiles", "slate")])
    sides = np.ptp(walls[..., :2], axis=(0, 1))
    along, across = sides if heading in (0.0, np.pi) else sides[::-1]
    assert along == pytest.approx(80.0)
    assert 9.0 <= across <= 10.0
    assert walls[..., 2].min() == pytest.approx(0.1)


def test_row_that_is_too_short_is_empty():
    assert not row_of_buildings(
        np.random.default_rng(0), np.zeros(2), PLOT[0] - 1.0, 0.0, depth=9.0, storeys=2, is_flat=False, base=0.0,
        route=np.zeros((2, 2)), window_range=0.0, scaffold_share=0.0, gap_share=0.0,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"roof": "thatch"}, "roof"),
        ({"pitch": 45.0}, "degrees"),
        ({"width": 0.0}, "width"),
        ({"height": 1e4}, "height"),
    ],
)
def test_bad_input(change: dict, words: str):
    with pytest.raises(InputError, match=words):
        replace(HOUSE, **change)
