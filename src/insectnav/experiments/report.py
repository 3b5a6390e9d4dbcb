"""All results of a folder beside the published numbers, as one HTML page."""

from __future__ import annotations

import os
import platform
import secrets
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

from insectnav.checks import InputError, quoted
from insectnav.experiments import load, names
from insectnav.experiments.experiment import SCALES, code_version, paper_of
from insectnav.experiments.report_page import Entry, Report, render_page
from insectnav.experiments.result_folders import Run, finished_runs, read_result

PAGE = "report.html"


def write_report(out: Path) -> Report:
    """All results of a folder, with the page ``out/report.html`` that shows them.

    Of each experiment the newest result is shown, or one of full scale by the same version of the code.

    Parameters
    ----------
    out : Path
        Folder that `insectnav.sweep.run_experiment` wrote to.

    Raises
    ------
    InputError
        If it holds no results, or the page cannot be written.
    """
    shown = quoted(out, limit=200)
    if not out.is_dir():
        raise InputError(f"--out {shown} is no folder, expected one that insectnav run wrote to")
    report = Report(
        path=out / PAGE,
        out=out,
        made=datetime.now().astimezone(),
        machine=_machine(),
        code=code_version(),
        entries=[_entry(out, name) for name in names()],
    )
    if not report.with_results:
        reason = f" ({report.notes[0]})" if report.notes else ""
        raise InputError(f"--out {shown} holds no results{reason}, expected some: insectnav run NAME makes them")
    _write(report.path, render_page(report))
    return report


def _entry(out: Path, name: str) -> Entry:
    """An experiment with the result that is to be shown."""
    experiment = load(name)
    runs, notes = finished_runs(out, name)
    return Entry(
        name=name,
        paper=paper_of(experiment),
        figure=experiment.FIGURE,
        title=experiment.TITLE,
        result=read_result(out, _best(runs)) if runs else None,
        notes=notes,
    )


def _best(runs: Sequence[Run]) -> Run:
    """The newest run; of those by the same version of the code, one of full scale before a quick one."""
    newest = max(runs, key=lambda run: run.finished)
    of_this_code = [run for run in runs if run.code == newest.code]
    return max(of_this_code, key=lambda run: (SCALES.index(run.scale), run.finished))


def _machine() -> str:
    return f"{platform.system()}, {platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}"


def _write(path: Path, text: str) -> None:
    """Leave a text whole or not at all."""
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
    try:
        temporary.write_text(text, encoding="utf-8")
        os.replace(temporary, path)
    except OSError as error:
        raise InputError(f"{quoted(path, 200)} cannot be written ({error.strerror})") from None
    finally:
        temporary.unlink(missing_ok=True)
