"""The page on which results stand beside the published numbers: one file, without scripts, that prints well.

All that comes from files goes through `safe_text`, which leaves nothing of HTML in it.
"""

from __future__ import annotations

import base64
import os
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from urllib.parse import quote

from insectnav import __version__
from insectnav.experiments.page_parts import page_row, page_table, safe_text, whole_page
from insectnav.experiments.published import AGREES, DIFFERS, NOT_COMPARABLE, STANDARD_ERRORS, Verdict
from insectnav.experiments.report_style import STYLE
from insectnav.experiments.result_folders import Result, Run
from insectnav.experiments.verdict_words import (
    VERDICTS,
    counts_text,
    duration_text,
    ours_text,
    published_text,
    verdict_counts,
)

MARKS = {AGREES: "✓", DIFFERS: "≠", NOT_COMPARABLE: "○"}
CLASSES = {AGREES: "agrees", DIFFERS: "differs", NOT_COMPARABLE: "apart"}
WIDE = 1000  # [pixel]
DATE = "%Y-%m-%d %H:%M"


@dataclass(frozen=True, kw_only=True)
class Entry:
    """An experiment with the result that is shown of it, if there is one."""

    name: str
    paper: str
    figure: str
    title: str
    result: Result | None
    notes: Sequence[str]  # on folders that are left out


@dataclass(frozen=True, kw_only=True)
class Report:
    """What a page holds.

    Parameters
    ----------
    path : of the page
    out : folder of the results, as the user named it
    made : time
    machine : that wrote the page
    code : version of the code that wrote the page
    entries : every experiment
    """

    path: Path
    out: Path
    made: datetime
    machine: str
    code: str
    entries: Sequence[Entry]

    @property
    def with_results(self) -> list[tuple[Entry, Result]]:
        """Experiments that have been run, with what is shown of them."""
        return [(entry, entry.result) for entry in self.entries if entry.result is not None]

    @property
    def verdicts(self) -> list[Verdict]:
        """Those of all experiments."""
        return [verdict for _, result in self.with_results for verdict in result.verdicts]

    @property
    def notes(self) -> list[str]:
        """What could not be read or is missing, of all experiments."""
        return [
            note for entry in self.entries for note in (*entry.notes, *(entry.result.notes if entry.result else ()))
        ]


def render_page(report: Report) -> str:
    """A report as HTML."""
    sections = "\n".join(_section(report, entry, result) for entry, result in report.with_results)
    main = "\n".join([_summary(report), sections, _not_run(report)])
    return whole_page("published numbers and ours", STYLE, _head(report), main)


def _head(report: Report) -> str:
    n_results, n_entries = len(report.with_results), len(report.entries)
    return f"""<h1>Published numbers and ours</h1>
<p class="lead">{n_results} of {n_entries} experiments have results: of their published numbers and claims,
{safe_text(counts_text(report.verdicts))}.</p>
<p>Written {report.made.strftime(DATE)} by insectnav {safe_text(__version__)} (code {safe_text(report.code)})
on {safe_text(report.machine)}, from the results in <code>{safe_text(report.out)}</code>.</p>
<p>A number of ours <em>agrees</em> where it lies within what the published one stands for – its rounding, or how well
it can be read – give or take {STANDARD_ERRORS:g} standard errors of both.
After ± stands the standard error of ours.</p>"""


def _summary(report: Report) -> str:
    """All experiments with results, a row each."""
    columns = ("Experiment", "Shown in", *(f"{MARKS[kind]} {kind}" for kind in VERDICTS), "Scale", "Time")
    rows = "\n".join(_summary_row(entry, result, report.code) for entry, result in report.with_results)
    return page_table("summary", "All experiments with results", columns, rows)


def _summary_row(entry: Entry, result: Result, code: str) -> str:
    run, counts = result.run, verdict_counts(result.verdicts)
    cells = [
        ("Shown in", f"{safe_text(entry.figure)}"),
        *((f"{MARKS[kind]} {kind}", _count(kind, counts[kind])) for kind in VERDICTS),
        ("Scale", safe_text(run.scale) + (" (other code)" if run.code != code else "")),
        ("Time", duration_text(run.seconds)),
    ]
    return page_row(f'<a href="#{safe_text(entry.name)}">{safe_text(entry.name)}</a>', cells)


def _count(verdict: str, number: int) -> str:
    return f'<span class="verdict {CLASSES[verdict]}">{number}</span>' if number else "–"


def _section(report: Report, entry: Entry, result: Result) -> str:
    """One experiment."""
    notes = [*_warnings(report, result.run), *entry.notes, *result.notes]
    parts = [
        f"<h2>{_heading(entry)}</h2>",
        f'<p class="source">{safe_text(entry.paper)} · <code>{safe_text(entry.name)}</code></p>',
        *(f'<p class="note"><strong>Note:</strong> {safe_text(note)}.</p>' for note in notes),
        _figure(entry, result),
        _comparison(entry, result),
        _origin(report, entry, result.run),
    ]
    return f'<section id="{safe_text(entry.name)}">\n' + "\n".join(part for part in parts if part) + "\n</section>"


def _warnings(report: Report, run: Run) -> list[str]:
    if run.code == report.code:
        return []
    return [f"made by another version of the code ({run.code}) than the present one ({report.code}): run it again"]


def _heading(entry: Entry) -> str:
    return f"{safe_text(entry.figure[:1].upper() + entry.figure[1:])}: {safe_text(entry.title)}"


def _figure(entry: Entry, result: Result) -> str:
    if result.picture is None:
        return f"<p>{safe_text(result.caption)}</p>" if result.caption else ""
    picture = result.picture
    name = f"Plot for {safe_text(entry.figure)}"
    is_wide = ' class="wide"' if picture.width >= WIDE else ""  # a phone scrolls it, to keep its letters legible
    data = base64.b64encode(picture.png).decode("ascii")
    caption = f"<figcaption>{safe_text(result.caption)}</figcaption>\n" if result.caption else ""
    return f"""<figure>
<div class="plot" tabindex="0" role="group" aria-label="{name}">
<img{is_wide} src="data:image/png;base64,{data}" width="{picture.width}" height="{picture.height}"
alt="{name}: {safe_text(entry.title)}; its numbers are in the table below">
</div>
{caption}</figure>"""


def _comparison(entry: Entry, result: Result) -> str:
    if not result.verdicts:
        return ""
    columns = ("Quantity", "Published", "Ours", "Verdict", "Source")
    rows = "\n".join(_verdict_row(verdict) for verdict in result.verdicts)
    return page_table("comparison", f"{entry.figure}: published and ours", columns, rows)


def _verdict_row(verdict: Verdict) -> str:
    mark = f'<span aria-hidden="true">{MARKS[verdict.verdict]}</span> {verdict.verdict}'
    why = f'<p class="why">{safe_text(verdict.why)}</p>' if verdict.why else ""
    cells = [
        ("Published", safe_text(published_text(verdict))),
        ("Ours", safe_text(ours_text(verdict))),
        ("Verdict", f'<span class="verdict {CLASSES[verdict.verdict]}">{mark}</span>{why}'),
        ("Source", f'{safe_text(verdict.source)} <p class="how">{safe_text(verdict.how_read)}</p>'),
    ]
    return page_row(safe_text(verdict.quantity), cells)


def _origin(report: Report, entry: Entry, run: Run) -> str:
    """How the result was made, and how to make it again."""
    earlier = f", {run.n_earlier_cells} of them by an earlier run that was resumed" if run.n_earlier_cells else ""
    address = quote(os.fsencode(run.folder)) + "/"
    again = _commanded(entry.name, "--scale", run.scale, "--seed", str(run.seed), "--out", str(report.out))
    rows = {
        "Scale": f"{run.scale}, seed {run.seed}, {run.n_cells} cells{safe_text(earlier)}",
        "Time taken": f"{duration_text(run.seconds)}, finished {run.finished.strftime(DATE)}",
        "Made with": f"{safe_text(run.made_with)}; code {safe_text(run.code)}, key {safe_text(run.key)}",
        "Files": f'<a href="{safe_text(address)}">{safe_text(run.folder)}/</a> (figure, table, data, provenance)',
        "Run again": again,
    }
    return "<dl>\n" + "\n".join(f"<dt>{name}</dt><dd>{content}</dd>" for name, content in rows.items()) + "\n</dl>"


def _commanded(name: str, *options: str) -> str:
    """What to type in a shell; lines end between its words where they can."""
    words = [shlex.quote(word) for word in ("insectnav", "run", name, *options)]
    return "<code>" + " ".join(f"<span>{safe_text(word)}</span>" for word in words) + "</code>"


def _not_run(report: Report) -> str:
    """What there is no result of yet."""
    entries = [entry for entry in report.entries if entry.result is None]
    if not entries:
        return ""
    items = "\n".join(
        f"<li><p>{_heading(entry)}</p>\n"
        + "".join(f'<p class="note"><strong>Note:</strong> {safe_text(note)}.</p>\n' for note in entry.notes)
        + f"<p>{_commanded(entry.name, '--out', str(report.out))}</p></li>"
        for entry in entries
    )
    return f'<section id="not-run-yet">\n<h2>Not run yet</h2>\n<ul>\n{items}\n</ul>\n</section>'
