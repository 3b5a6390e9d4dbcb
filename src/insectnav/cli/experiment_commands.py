"""`insectnav list`, `run` and `report`: the published experiments, run again and held against the paper."""

import gc
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from insectnav.checks import InputError, check_choice
from insectnav.cli.progress import progress_bar

if TYPE_CHECKING:
    from insectnav.sweep import Outcome


class RunInterruptedError(Exception):
    """The user stopped a run; what was finished is kept.

    Parameters
    ----------
    parts : str
        What is kept, such as cells.
    option : str
        That goes on with them.
    """

    def __init__(self, parts: str = "cells", option: str = "--resume") -> None:
        super().__init__(parts)
        self.parts, self.option = parts, option


def list_experiments(
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """Name every experiment, its paper, its figure and what it shows."""
    from insectnav.experiments import load, names
    from insectnav.experiments.experiment import paper_of
    from insectnav.experiments.results import to_json

    rows = []
    for name in names():
        experiment = load(name)
        rows.append((name, paper_of(experiment), experiment.FIGURE, experiment.TITLE))
    if as_json:
        keys = ("name", "paper", "figure", "title")
        print(to_json({"experiments": [dict(zip(keys, row, strict=True)) for row in rows]}))
        return
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)][:-1]
    for *columns, title in rows:
        print(*(text.ljust(width) for text, width in zip(columns, widths, strict=True)), title, sep="  ")


def run(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="NAME...", help="Experiments, by the names of `insectnav list`.")
    ] = None,
    every: Annotated[bool, typer.Option("--all", help="Run every experiment, then write the report.")] = False,
    scale: Annotated[str, typer.Option(help="quick: seconds each; full: as many trials as published.")] = "quick",
    seed: Annotated[int, typer.Option(help="Of all random numbers.")] = 0,
    out: Annotated[str, typer.Option(help="Folder for the results.")] = "out",
    workers: Annotated[int | None, typer.Option(help="Number of processes [default: one for each core].")] = None,
    cluster: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Dask scheduler to work on, as in tcp://host:8786.")
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with what an unfinished run left; leave finished ones as they are.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """Run published experiments again and compare with the paper."""
    from insectnav.experiments import load
    from insectnav.experiments.experiment import SCALES
    from insectnav.experiments.report import write_report
    from insectnav.experiments.results import check_not_empty, to_json
    from insectnav.sweep import executor, run_experiment

    gc.enable()  # which `program` turns off; a run may be long
    check_not_empty(out)
    chosen = _chosen(names or [], every)
    check_choice("scale", scale, SCALES)
    experiments = {name: load(name) for name in chosen}
    finished: list[dict[str, Any]] = []
    try:
        with executor(workers, cluster) as on:
            for name, experiment in experiments.items():
                progress_name = f"{name} ({len(finished) + 1} of {len(chosen)})"
                with progress_bar(len(experiment.grid(scale)), progress_name) as advance:
                    outcome = run_experiment(
                        experiment, name, Path(out), scale=scale, seed=seed, on=on, resume=resume, progress=advance
                    )
                finished.append({"experiment": name, "scale": scale, "seed": seed} | _as_object(outcome))
                if not as_json:
                    print(_in_words(name, outcome), flush=True)
    except KeyboardInterrupt:
        raise RunInterruptedError from None
    page = str(write_report(Path(out)).path) if every else None
    if as_json:
        print(to_json({"runs": finished, "report": page}))
    elif page:
        print(f"report: {page}")


def _chosen(names: list[str], every: bool) -> list[str]:
    """Names of the experiments to run, each once."""
    from insectnav.experiments import names as all_names

    if every and names:
        raise InputError("both names of experiments and --all are given, expected one of the two")
    if not every and not names:
        raise InputError("no experiment is named, expected a name that insectnav list shows, or --all")
    for name in names:
        check_choice("experiment", name, all_names())
    return list(all_names()) if every else list(dict.fromkeys(names))


def _as_object(outcome: "Outcome") -> dict[str, Any]:
    """What a program wants to know of a run."""
    from dataclasses import asdict

    from insectnav.experiments.verdict_words import verdict_counts

    return {
        "folder": str(outcome.folder),
        "seconds": round(outcome.seconds, 3),
        "cells": outcome.n_cells,
        "verdicts": verdict_counts(outcome.verdicts),
        "comparison": [asdict(verdict) for verdict in outcome.verdicts],
    }


def _in_words(name: str, outcome: "Outcome") -> str:
    """What a person wants to know of a run: a line, and one for each number that differs."""
    from insectnav.experiments.published import DIFFERS
    from insectnav.experiments.verdict_words import counts_text, duration_text, ours_text, published_text

    time = duration_text(outcome.seconds) if outcome.seconds else "was there already"
    lines = [f"{name}  {time}  {counts_text(outcome.verdicts)}  {outcome.folder}"]
    lines += [
        f"  differs: {verdict.quantity}: published {published_text(verdict)}, ours {ours_text(verdict)}: {verdict.why}"
        for verdict in outcome.verdicts
        if verdict.verdict == DIFFERS
    ]
    return "\n".join(lines)


def report(
    out: Annotated[str, typer.Option(help="Folder that holds the results.")] = "out",
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """Put all results beside the published numbers, on one HTML page."""
    from insectnav.experiments.report import write_report
    from insectnav.experiments.results import check_not_empty, to_json
    from insectnav.experiments.verdict_words import counts_text, verdict_counts

    check_not_empty(out)
    written = write_report(Path(out))
    names = [entry.name for entry, _ in written.with_results]
    if as_json:
        not_run = [entry.name for entry in written.entries if entry.result is None]
        told = {"report": str(written.path), "experiments": names, "not_run_yet": not_run}
        print(to_json(told | {"verdicts": verdict_counts(written.verdicts), "notes": written.notes}))
        return
    print(f"{written.path}: {len(names)} of {len(written.entries)} experiments, {counts_text(written.verdicts)}")
    for note in written.notes:
        print(f"note: {note}")
