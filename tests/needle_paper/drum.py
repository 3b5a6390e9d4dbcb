"""An experiment that breaks down."""

from needle_paper.needle import Cell, caption, compare, draw, grid, summarise  # noqa: F401

FIGURE = "Fig. 2"
TITLE = "a drum that bursts"


def simulate(cell, seed):
    raise RuntimeError("the drum has burst")
