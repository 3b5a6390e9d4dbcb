"""One style for all figures: sized for a journal column, readable by the colour-blind."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from string import ascii_lowercase
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PNG_DPI = 200
SINGLE_COLUMN, DOUBLE_COLUMN = 3.5, 7.2  # [inch]
COLOURS = {  # Okabe & Ito (2008), Color Universal Design
    "black": "#000000",
    "orange": "#E69F00",
    "sky": "#56B4E9",
    "green": "#009E73",
    "yellow": "#F0E442",
    "blue": "#0072B2",
    "red": "#D55E00",
    "purple": "#CC79A7",
    "grey": "#7F7F7F",
}
RATES = "cividis"  # perceptually uniform, the same to the colour-blind (Nuñez et al. 2018)
STYLE: Any = {
    "font.family": "sans-serif",
    "font.size": 7.0,
    "axes.labelsize": 7.0,
    "axes.titlesize": 8.0,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.labelsize": 6.0,
    "ytick.labelsize": 6.0,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "legend.fontsize": 6.0,
    "legend.frameon": False,
    "lines.linewidth": 1.0,
    "axes.unicode_minus": False,  # the typographic minus alone would need a second font in the PDF, which takes long
    "pdf.compression": 2,  # a little larger and much faster
    "pdf.fonttype": 42,  # text stays text
    "svg.fonttype": "none",
}
_FILES: dict[str, dict[str, Any]] = {  # how each kind of file is written
    "png": {"dpi": PNG_DPI, "metadata": {"Software": None}, "pil_kwargs": {"compress_level": 1}},
    "pdf": {"dpi": 300, "metadata": {"CreationDate": None}},
}


def journal_style() -> Any:
    """Context in which figures are drawn and saved."""
    import matplotlib

    return matplotlib.rc_context(STYLE)


def name_panel(axes: Axes, letter: str, title: str = "") -> None:
    """Head a panel with the letter that the caption names it by, in bold, and a title."""
    axes.set_title(f"$\\mathbf{{{letter}}}$  {title}".rstrip(), loc="left")


def letter_panels(panels: Iterable[Axes]) -> None:
    """Head panels with a, b, c and so on, in their order."""
    for letter, axes in zip(ascii_lowercase, panels, strict=False):
        name_panel(axes, letter)


def save_figure(figure: Figure, folder: Path, name: str = "figure", kinds: Sequence[str] = ("png", "pdf")) -> None:
    """Write ``name``.png (200 dpi) and ``name``.pdf, without a date so that equal figures are equal files."""
    with journal_style(), _laid_out(figure):
        for kind in kinds:
            figure.savefig(folder / f"{name}.{kind}", **_FILES[kind])


def png_of(figure: Figure) -> bytes:
    """The PNG that `save_figure` would write, for a figure that goes onto a page and into no file."""
    data = io.BytesIO()
    with journal_style(), _laid_out(figure):
        figure.savefig(data, format="png", **_FILES["png"])
    return data.getvalue()


@contextmanager
def _laid_out(figure: Figure) -> Iterator[None]:
    """Arrange a figure once for all its files: matplotlib would anew for each, which takes as long as drawing it."""
    engine, dpi = figure.get_layout_engine(), figure.dpi
    if engine is None:
        yield
        return
    figure.set_dpi(PNG_DPI)
    engine.execute(figure)
    figure.set_dpi(dpi)
    figure.set_layout_engine(None)  # "none" would have the figure drawn twice
    try:
        yield
    finally:
        figure.set_layout_engine(engine)
