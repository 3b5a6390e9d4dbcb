"""How fast trials run: one line each, with the ratio to the plain NumPy oracle measured in the same run.

Wall time drifts on shared machines, so each fast measurement stands between two of the oracle's, and the median of
the ratios is what to quote. Run it by ``make bench``.
"""

import resource
import statistics
import time
from collections.abc import Callable

import numpy as np

import oracle
from insectnav.agents import random_routes, run_trials

N_TRIALS, N_STEPS, NOISE, N_RUNS = 1000, 1500, 0.1, 7
ORACLE_STEPS = 1500


def seconds(function: Callable[[], object]) -> float:
    started = time.perf_counter()
    function()
    return time.perf_counter() - started


def oracle_step(noise: float) -> float:
    """Seconds per step of one trial of the oracle."""
    rng = np.random.default_rng(1)
    heading, velocity = oracle.random_route(ORACLE_STEPS, rng)
    run = lambda: oracle.run_trial(heading, velocity, ORACLE_STEPS, oracle.THESIS, noise, rng)  # noqa: E731
    return seconds(run) / (2 * ORACLE_STEPS)


def compare(name: str, run: Callable[[], object], n_steps: int, noise: float = NOISE) -> float:
    """Print the median time per step and its ratio to the oracle's; return the median time."""
    run()  # compiles, or loads what was compiled
    times, ratios = [], []
    before = oracle_step(noise)
    for _ in range(N_RUNS):
        times.append(seconds(run) / n_steps)
        after = oracle_step(noise)
        ratios.append((before + after) / 2.0 / times[-1])
        before = after
    time_per_step = statistics.median(times)
    print(
        f"{name:42s} {1e9 * time_per_step:8.1f} ns a step   1/{statistics.median(ratios):5.0f} of the oracle "
        f"(1/{min(ratios):.0f} … 1/{max(ratios):.0f})",
        flush=True,
    )
    return time_per_step


def main() -> None:
    routes = random_routes(N_TRIALS, N_STEPS)
    pair = (routes["heading"].values.astype("float32"), routes["velocity"].values.astype("float32"))
    n_steps = N_TRIALS * 2 * N_STEPS
    print(f"{N_TRIALS} trials of {N_STEPS} + {N_STEPS} steps, noise {NOISE} on all cells; medians of {N_RUNS} runs")
    print(f"{'plain NumPy oracle':42s} {1e9 * oracle_step(NOISE):8.0f} ns a step")
    one = compare("float32, one core", lambda: run_trials(pair, noise=NOISE, workers=1), n_steps)
    compare("float32, two cores", lambda: run_trials(pair, noise=NOISE, workers=2), n_steps)
    gains = [
        seconds(lambda: run_trials(pair, noise=NOISE, workers=1)) / seconds(lambda: run_trials(pair, workers=2))
        for _ in range(N_RUNS)
    ]
    print(f"{'two cores over one, run by run':42s} {statistics.median(gains):8.2f} times as fast")
    compare("float32, one core, no noise", lambda: run_trials(pair, noise=0.0, workers=1), n_steps, noise=0.0)
    few = (pair[0][:160], pair[1][:160])
    compare("float64, one core, 160 trials", lambda: run_trials(few, noise=NOISE, workers=1, dtype="float64"), 480_000)
    compare("one trial alone", lambda: run_trials((pair[0][:1], pair[1][:1]), workers=1), 2 * N_STEPS)
    route_time = statistics.median(seconds(lambda: random_routes(N_TRIALS, N_STEPS)) for _ in range(N_RUNS))
    share = route_time / (one * n_steps)
    print(f"{'making the routes, one core':42s} {1e3 * route_time:8.1f} ms = {share:.3f} of running them")
    megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    held = sum(array.nbytes for array in pair) / 2**20
    print(f"{'peak memory of all this':42s} {megabytes:8.0f} MiB (the float32 routes alone are {held:.0f})")


if __name__ == "__main__":
    main()
