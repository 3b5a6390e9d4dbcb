"""Runs of the experiment in processes of their own, and what they leave."""

import subprocess
import sys
from pathlib import Path

import numpy as np

from command_line import heed_interrupts
from dask_cluster import environment
from insectnav.experiments.results import PROVENANCE
from insectnav.experiments.store import FINISHED
from insectnav.sweep import executor, run_experiment
from slow_paper import fig_1

FILES = ["caption.txt", "comparison.csv", "data.zarr", "figure.pdf", "figure.png", PROVENANCE, "table.csv"]
N_CELLS = 16


def start(out: Path, *options: str, hold: float = np.inf) -> subprocess.Popen:
    """A process that runs the experiment; cells of level ``hold`` and above do not end."""
    command = [sys.executable, "-W", "error", "-m", "slow_paper", str(out), *options]
    settings = {fig_1.HOLD: str(hold), fig_1.PACE: "0.3"}
    return subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True, env=environment() | settings, preexec_fn=heed_interrupts
    )


def run_here(out: Path, scale: str = "quick") -> Path:
    """Folder of a run in this process that nothing interrupts."""
    with executor(workers=1) as on:
        return run_experiment(fig_1, "slow", out, scale=scale, on=on).folder


def n_finished(out: Path) -> int:
    """Number of cells that an unfinished run has on disk."""
    return len(list(out.glob(f"slow/.*.unfinished/{FINISHED}/*")))


def contents(folder: Path) -> dict[str, bytes]:
    """All files below a folder, hidden ones too, but the one that says when and how it was made."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != PROVENANCE
    }
