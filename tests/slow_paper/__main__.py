"""Runs the experiment in a process that can be killed: python -m slow_paper OUT [--cluster ADDRESS] [--resume] …"""

import argparse
from pathlib import Path

from insectnav.sweep import executor, run_experiment
from slow_paper import fig_1

if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("out", type=Path)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--cluster")
    parser.add_argument("--scale", default="quick")
    parser.add_argument("--resume", action="store_true")
    given = parser.parse_args()
    with executor(given.workers, given.cluster) as on:
        run_experiment(fig_1, "slow", given.out, scale=given.scale, on=on, resume=given.resume)
