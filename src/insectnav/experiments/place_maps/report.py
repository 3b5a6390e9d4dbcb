"""What is left of queries located in a map: a table, figures, a page, numbers."""

from __future__ import annotations

import io
import secrets
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.checks import InputError, quoted
from insectnav.datasets.image_folder import as_text
from insectnav.experiments.figures import png_of, save_figure
from insectnav.experiments.place_maps import figures
from insectnav.experiments.place_maps.describe import ROTATED, TURNED
from insectnav.experiments.place_maps.locate import LocateParams, Search
from insectnav.experiments.place_maps.located import Located, numbers, write_rows
from insectnav.experiments.place_maps.page import PlacePage, Plot, lead_sentence, render_page
from insectnav.experiments.place_maps.pairs import chosen_pairs, shown_pairs
from insectnav.experiments.place_maps.thumbnails import find_thumbnails, picture_of
from insectnav.experiments.place_maps.words import numbers_in_words, settings_in_words, tiles
from insectnav.experiments.results import (
    PROVENANCE,
    check_destination,
    check_room,
    provenance,
    results_folder,
    to_json,
    written_to,
)
from insectnav.matching.places import PlaceMap

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Caption = list[tuple[str, str]]  # letter of a panel, and what it shows
PRECISION_CAPTION = [
    ("a", "Precision over recall as ever worse scores are kept; the dot keeps all."),
    ("b", "Scores of right and wrong matches: a robot keeps those below a threshold that parts them."),
]
AFTER_THE_BEST = {TURNED: "after the best turn", ROTATED: "after the best rotation, over what both saw"}
TABLE, PAGE, SUMMARY, FIGURES = "matches.csv", "page.html", "summary.json", "figures"


def summary(search: Search, params: LocateParams, place_map: PlaceMap) -> dict[str, Any]:
    """Everything that a program may want to know, but for the rows of the table.

    Parameters
    ----------
    search : Search
    params : LocateParams
    place_map : PlaceMap
    """
    truth, about = search.found.truth, place_map.about
    values = numbers(search.found)
    return {
        "map": str(place_map.path),
        "lead": lead_sentence(values),
        "numbers": values,
        "truth": None if truth is None else truth.source,
        "settings": {
            "descriptor": about.descriptor,
            "metric": about.metric,
            "camera": about.camera,
            **dict(about.settings),
            **asdict(search.seqslam),
            "search": params.search,
            "threshold": params.threshold,
            "taken": params.frames.thinning.in_words,
        },
        "seconds": dict(search.seconds),
        "notes": list(search.notes),
    }


def table_text(found: Located) -> str:
    """The table of matches as CSV."""
    text = io.StringIO(newline="")
    write_rows(text, found.rows())
    return text.getvalue()


@dataclass(frozen=True, kw_only=True)
class Destinations:
    """Where results go; made by `given`.

    Parameters
    ----------
    table, page, folder : files and folder, None where there is none
    """

    table: str | None
    page: str | None
    folder: str | None

    @classmethod
    def given(cls, table: str | None, page: str | None, folder: str | None, usual: str) -> Destinations:
        """What the user said, else the usual folder; refused before any work is done.

        Raises
        ------
        InputError
            If a file is there, or a place cannot be written.
        """
        for option, path in (("--out", table), ("--page", page)):
            if path is not None:
                _check_new_file(option, Path(path))
        if table is not None and page is not None and Path(table).resolve() == Path(page).resolve():
            raise InputError(f"--out and --page are both {quoted(table, 200)}, expected two names")
        if folder is None and table is None and page is None:
            folder = usual
        if folder is not None:
            check_destination(folder, "--out-dir")
        return cls(table=table, page=page, folder=folder)

    @property
    def written(self) -> dict[str, str]:
        """What is written where, for a person."""
        found = {}
        if self.folder is not None:
            found["page to look at"] = str(Path(self.folder) / PAGE)
            found["table, figures and numbers"] = self.folder
        if self.page is not None:
            found["page"] = self.page
        if self.table is not None:
            found["matches"] = self.table
        return found


def leave(
    places: Destinations, search: Search, params: LocateParams, place_map: PlaceMap, title: str
) -> dict[str, Any]:
    """Table, page, figures and numbers where they are wanted: the summary.

    Parameters
    ----------
    places : Destinations
    search : Search
    params : LocateParams
    place_map : PlaceMap
    title : of the page
    """
    result = summary(search, params, place_map)
    table, page = table_text(search.found), None
    if places.folder is not None:
        with results_folder(places.folder, "--out-dir") as folder, written_to(places.folder, "--out-dir"):
            (folder / TABLE).write_text(table, encoding="utf-8", newline="")
            (folder / FIGURES).mkdir()
            page = page_text(search, params, place_map, title, folder / FIGURES)
            (folder / PAGE).write_text(page, encoding="utf-8")
            (folder / SUMMARY).write_text(to_json(result) + "\n", encoding="utf-8")
            made = provenance(sum(search.seconds.values()))
            (folder / PROVENANCE).write_text(to_json(made) + "\n", encoding="utf-8")
    if places.page is not None:
        _write_whole("--page", Path(places.page), page or page_text(search, params, place_map, title))
    if places.table is not None:
        _write_whole("--out", Path(places.table), table)
    return result


def _check_new_file(option: str, path: Path) -> None:
    """Refuse a file that is there, unless it was made by the same option, and a place that cannot be written."""
    shown = f"{option} {quoted(path, 200)}"
    with written_to(path, option):
        if path.is_dir():
            raise InputError(f"{shown} is a folder, expected the name of a file")
        if path.exists():
            raise InputError(f"{shown} exists, expected a new name: remove it first")
        if not path.absolute().parent.exists():
            raise InputError(f"{shown} is in a folder that does not exist, expected one that does")
        check_room(path.absolute(), shown)


def _write_whole(option: str, path: Path, text: str) -> None:
    """A file that appears whole or not at all."""
    temporary = path.with_name(f".{secrets.token_hex(8)}.part")
    try:
        with written_to(path, option):
            temporary.write_text(text, encoding="utf-8", newline="")
            temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def page_text(search: Search, params: LocateParams, place_map: PlaceMap, title: str, folder: Path | None = None) -> str:
    """The page as HTML; figures go into the folder, too, as PNG and PDF.

    Parameters
    ----------
    search : Search
    params : LocateParams
    place_map : PlaceMap
    title : heading
    folder : for the figures; None to have them on the page alone
    """
    found = search.found
    wanted = [query for _, query in chosen_pairs(found)]
    pictures = find_thumbnails(place_map.path, sorted({int(found.reference[query]) for query in wanted}))
    pairs = shown_pairs(found, search.pictures, pictures)
    plots = [_plot(folder, *drawing) for drawing in _drawn(search, place_map)]
    if folder is not None:
        shown = [(p.title, picture_of(p.query[0]), picture_of(p.match[0])) for p in pairs]
        both = [(pair_title, one, two) for pair_title, one, two in shown if one is not None and two is not None]
        if both:
            save_figure(figures.draw_pairs(both), folder, "pairs")
    values = numbers(found)
    page = render_page(
        PlacePage(
            title=title,
            lead=lead_sentence(values),
            tiles=tiles(values),
            plots=plots,
            pairs=pairs,
            numbers=numbers_in_words(values),
            settings=settings_in_words(search, params, place_map),
            notes=search.notes,
            command=["insectnav", *sys.argv[1:]] if Path(sys.argv[0]).name.startswith("insectnav") else (),
            made=datetime.now().astimezone(),
        )
    )
    return as_text(page)


def _drawn(search: Search, place_map: PlaceMap) -> list[tuple[str, Figure, str, list[tuple[str, str]]]]:
    """Name, figure, heading and caption of all that can be drawn."""
    found = search.found
    places, queries = (figures.drawn_numbers(n) for n in (len(found.place_names), len(found.names)))
    difference = search.differences(place_map, places, queries)
    drawings = [
        ("matches", figures.draw_matches(found, difference, places, queries), "Matches", _match_caption(search)),
        ("precision", figures.draw_precision(found), "Precision and recall", PRECISION_CAPTION),
        ("route", figures.draw_route(found), "Along the route", _route_caption(found)),
    ]
    return [(name, figure, heading, text) for name, figure, heading, text in drawings if figure is not None]


def _match_caption(search: Search) -> Caption:
    truth, describe = search.found.truth, search.describe
    kinds = "right ones green, wrong ones red crosses" if truth is not None else "in blue"
    line = f"; the line is the truth: {truth.source}" if truth is not None else ""
    limit = "; grey dots, above the dashed line, are not kept" if search.found.threshold is not None else ""
    how = describe.used_metric
    if not describe.is_vectors:
        how = AFTER_THE_BEST.get(describe.descriptor, how)
    return [
        ("a", f"The match of each query in the map, {kinds}{line}."),
        ("b", f"How different each query is from each place ({how}), dark where alike, with the matches in it."),
        ("c", f"Scores: 0 where a match is unique, 1 where another place fits as well{limit}."),
    ]


def _has_wrong(found: Located) -> bool:
    """Whether a match that is kept is known to be wrong."""
    return found.truth is not None and bool((found.is_kept & found.truth.is_known & ~found.truth.is_right).any())


def _route_caption(found: Located) -> Caption:
    """What the figure of the route shows, panel by panel."""
    said = []
    if np.isfinite(found.place_positions[:, :2]).all(axis=1).any():
        own = "where the queries were" if found.query_positions is not None else "where their matches are"
        text = f"Grey: the places of the map; marks: {own}"
        if found.truth is not None and found.query_positions is not None and _has_wrong(found):
            text += "; red lines lead from a query to its wrong match"
        said.append(text)
    if found.truth is not None and np.isfinite(found.truth.error).any():
        said.append("Distance of each match from the truth")
    if found.angles_deg is not None and np.isfinite(found.angles_deg).any():
        said.append("How each query was turned against its match: headings clockwise, nose up, right side down")
    return [(letter, f"{text}.") for letter, text in zip("abc", said, strict=False)]


def _plot(folder: Path | None, name: str, figure: Figure, heading: str, caption: Sequence[tuple[str, str]]) -> Plot:
    """A figure as it stands on the page; drawn once, also where it goes into a folder."""
    if folder is None:
        png = png_of(figure)
    else:
        save_figure(figure, folder, name)
        png = (folder / f"{name}.png").read_bytes()
    size = (int.from_bytes(png[16:20], "big"), int.from_bytes(png[20:24], "big"))
    return Plot(name=name, heading=heading, caption=caption, png=png, size=size)
