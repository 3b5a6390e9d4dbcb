"""The page of places found again: one file that loads nothing, with figures, pairs of frames and numbers."""

from __future__ import annotations

import base64
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from insectnav import __version__
from insectnav.checks import counted
from insectnav.experiments.page_parts import page_row, page_table, safe_text, whole_page
from insectnav.experiments.place_maps.page_style import STYLE
from insectnav.experiments.place_maps.pairs import Pair
from insectnav.experiments.place_maps.truth import quantity

DATE = "%Y-%m-%d %H:%M"
WIDE = 1000  # [pixel] from which on a phone scrolls a figure, to keep its letters legible
SMALL = 160  # [pixel] up to which pixels of a picture are shown as squares
MOST_NOTES = 40


@dataclass(frozen=True, kw_only=True)
class Plot:
    """A figure for the page: heading, what each panel shows (letter, text), and PNG with its size [pixel]."""

    name: str
    heading: str
    caption: Sequence[tuple[str, str]]
    png: bytes
    size: tuple[int, int]  # columns, rows


@dataclass(frozen=True, kw_only=True)
class PlacePage:
    """What a page holds.

    Parameters
    ----------
    title : heading
    lead : what came out, in a sentence or two
    tiles : the few numbers that matter most: value, what it is
    plots : figures in order
    pairs : queries beside their matches
    numbers : all of them: name, value, what it is
    settings : everything that was set or assumed: name, value
    notes : what a person must know
    command : words of the command that makes it again
    made : when
    """

    title: str
    lead: str
    tiles: Sequence[tuple[str, str]]
    plots: Sequence[Plot]
    pairs: Sequence[Pair]
    numbers: Sequence[tuple[str, str, str]]
    settings: Sequence[tuple[str, str]]
    notes: Sequence[str]
    command: Sequence[str]
    made: datetime


def render_page(page: PlacePage) -> str:
    """A page as HTML."""
    parts = [
        *(_plot(plot) for plot in page.plots),
        _pairs(page.pairs),
        _numbers(page.numbers),
        _settings(page),
    ]
    return whole_page(page.title, STYLE, _head(page), "\n".join(part for part in parts if part))


def _head(page: PlacePage) -> str:
    tiles = "".join(
        f"<li><strong>{safe_text(value)}</strong><span>{safe_text(what)}</span></li>\n" for value, what in page.tiles
    )
    shown = [f'<p class="note"><strong>Note:</strong> {safe_text(note)}.</p>' for note in page.notes[:MOST_NOTES]]
    if len(page.notes) > MOST_NOTES:
        more = counted(len(page.notes) - MOST_NOTES, "more note")
        shown.append(f'<p class="note">And {more}: see summary.json.</p>')
    return f"""<h1>{safe_text(page.title)}</h1>
<p class="lead">{safe_text(page.lead)}</p>
<ul class="tiles">
{tiles}</ul>
{chr(10).join(shown)}"""


def _plot(plot: Plot) -> str:
    columns, rows = plot.size
    is_wide = ' class="wide"' if columns >= WIDE else ""
    data = base64.b64encode(plot.png).decode("ascii")
    caption = " ".join(f"<strong>{safe_text(letter)}</strong> {safe_text(text)}" for letter, text in plot.caption)
    return f"""<section id="{safe_text(plot.name)}">
<h2>{safe_text(plot.heading)}</h2>
<figure>
<div class="plot" tabindex="0" role="group" aria-label="{safe_text(plot.heading)}">
<img{is_wide} src="data:image/png;base64,{data}" width="{columns}" height="{rows}" alt="{safe_text(plot.heading)}">
</div>
<figcaption>{caption}</figcaption>
</figure>
</section>"""


def _pairs(pairs: Sequence[Pair]) -> str:
    if not pairs:
        return ""
    cards = "\n".join(_pair(pair) for pair in pairs)
    return f"""<section id="pairs">
<h2>Queries and their matches</h2>
<div class="pairs">
{cards}
</div>
</section>"""


def _pair(pair: Pair) -> str:
    pictures = "\n".join(
        _picture(data, size, word)
        for data, size, word in ((*pair.query, "query"), (*pair.match, "its match in the map"))
    )
    return f"""<figure class="pair">
{pictures}
<figcaption><strong class="{safe_text(pair.kind)}">{safe_text(pair.title)}</strong>
{safe_text(pair.caption)}</figcaption>
</figure>"""


def _picture(data: bytes, size: tuple[int, int], word: str) -> str:
    if not data:
        return f"<p>(no picture of {word})</p>"
    is_small = ' class="small"' if size[0] <= SMALL else ""
    shown = base64.b64encode(data).decode("ascii")
    return f'<img{is_small} src="data:image/jpeg;base64,{shown}" width="{size[0]}" height="{size[1]}" alt="{word}">'


def _numbers(numbers: Sequence[tuple[str, str, str]]) -> str:
    rows = "\n".join(
        page_row(safe_text(name), [("Value", safe_text(value)), ("What it is", safe_text(what))])
        for name, value, what in numbers
    )
    table = page_table("numbers", "All numbers", ("Quantity", "Value", "What it is"), rows)
    return f'<section id="numbers">\n<h2>Numbers</h2>\n{table}\n</section>'


def _settings(page: PlacePage) -> str:
    rows = "\n".join(f"<dt>{safe_text(name)}</dt><dd>{safe_text(value)}</dd>" for name, value in page.settings)
    words = " ".join(f"<span>{safe_text(shlex.quote(word))}</span>" for word in page.command)
    again = f"<dt>Made by</dt><dd><code>{words}</code></dd>" if page.command else ""
    written = f"{page.made.strftime(DATE)}, insectnav {__version__}"
    return f"""<section id="settings">
<h2>Settings and assumptions</h2>
<dl>
{rows}
{again}
<dt>Written</dt><dd>{safe_text(written)}</dd>
</dl>
</section>"""


def lead_sentence(numbers: Mapping[str, Any]) -> str:
    """What came out, for the head of a page and the end of a command."""
    queries, kept = numbers["queries"], numbers["kept"]
    where = "" if numbers["places"] is None else f" in a map of {counted(numbers['places'], 'place')}"
    sentence = f"{kept} of {counted(queries, 'frame')} {'was' if kept == 1 else 'were'} found{where}"
    if "right" not in numbers:
        return sentence + "."
    judged, right = numbers["kept_judged"], numbers["kept_right"]
    if judged == 0:
        return sentence + "; none of these can be judged."
    within = f"within {quantity(numbers['tolerance'], numbers['unit'])}"
    of_these = "of these" if judged == kept else f"of the {judged} that can be judged"
    return sentence + f"; {of_these} {right} {'is' if right == 1 else 'are'} right, {within}."
