"""`insectnav home`: a track in, the way home out."""

import math
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from insectnav.checks import InputError
from insectnav.cli.progress import progress_bar


def home(
    context: typer.Context,
    track: Annotated[
        str | None, typer.Argument(help="CSV or TSV with time, x, y and perhaps heading; none: a random foraging trip.")
    ] = None,
    preset: Annotated[str, typer.Option(help="Constants: thesis or code-2017.")] = "thesis",
    variant: Annotated[
        str, typer.Option(help="Circuit: partially-holonomic, non-holonomic, fully-holonomic, no-pontine, idealised.")
    ] = "partially-holonomic",
    noise: Annotated[float, typer.Option(help="SD of the noise on each firing rate.")] = 0.1,
    trials: Annotated[int, typer.Option(help="Number of ways home.")] = 100,
    homing_steps: Annotated[
        int | None,
        typer.Option(help="Steps of each way home [default: as many as out, or twice the straight way if longer]."),
    ] = None,
    seed: Annotated[int, typer.Option(help="Of all random numbers.")] = 0,
    reverse: Annotated[bool, typer.Option("--reverse", help="Fly the track backwards.")] = False,
    steps_per_unit: Annotated[
        float | None,
        typer.Option(
            help="Steps of the model in a length unit of the track "
            "[default: such that the 95th percentile of speed is 0.85 of what the speed cells can signal]."
        ),
    ] = None,
    heading_convention: Annotated[
        str, typer.Option(help="compass: clockwise from +y; math: anticlockwise from +x.")
    ] = "compass",
    max_gap: Annotated[float, typer.Option(help="Longest gap that is filled [s].")] = 1.0,
    max_gap_samples: Annotated[int, typer.Option(help="Longest gap that is filled [samples].")] = 20,
    out: Annotated[str | None, typer.Option(help="Folder for the results [default: out/NAME OF THE TRACK].")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """Fly the bee's path integrator along a track and let it steer home."""
    from insectnav.experiments.figure_process import HOME_FIGURE, FigureProcess

    with context.obj or FigureProcess(HOME_FIGURE) as figure:  # first, since it takes longest to get ready
        from insectnav.datasets.tracks import ReadingParams, read_track
        from insectnav.experiments.home import HomeParams, random_trip, recorded_trip, run
        from insectnav.experiments.results import check_destination, to_json

        params = HomeParams(
            preset=preset, variant=variant, noise=noise, n_trials=trials, n_inbound=homing_steps, seed=seed
        )
        reading = ReadingParams(
            heading_convention=heading_convention, max_gap_s=max_gap, max_gap_samples=max_gap_samples
        )
        if track is not None:
            recorded = read_track(track, **vars(reading))
            trip = recorded_trip(recorded.reversed() if reverse else recorded, steps_per_unit)
        elif reverse or steps_per_unit is not None:
            raise InputError("--reverse and --steps-per-unit need a track, but none was given")
        name = (Path(track).stem + "-reversed" * reverse) if track else "random-trip"
        folder = Path(out if out is not None else f"out/{name}")
        check_destination(folder if out is None else out)
        if context.obj is not None:  # in a process of our own
            _load_numba_alone()
        with progress_bar(trials, "ways home") as advance:
            result = run(trip if track else random_trip(seed), params, folder, figure, advance)
    print(to_json(result | {"folder": str(folder)}) if as_json else _in_words(result, folder))


def _load_numba_alone() -> None:
    """Load numba without SciPy's linear algebra, which it looks for, and which takes a third of its time.

    Compiled code can then not call BLAS. No kernel here does; it is left alone where others share the process.
    """
    hidden = "scipy.linalg"
    if hidden not in sys.modules:
        sys.modules[hidden] = None  # type: ignore[assignment]  # so that its import fails
        try:
            import numba.np.arraymath  # noqa: F401
        finally:
            del sys.modules[hidden]


def _in_words(result: dict[str, Any], folder: Path) -> str:
    """What a person wants to know of a way home."""
    from insectnav.records import plural_unit

    scale, measures = result["scale"], result["results"]
    unit = plural_unit(scale["length_unit"])

    def show(quantity: str, statistic: str = "mean", digits: int = 3, times: float = 1.0) -> str:
        value = measures[quantity][statistic] * times
        return f"{value:.{digits}g}" if math.isfinite(value) else "–"

    closest = {name: show("closest_distance", name) for name in ("mean", "median", "sd", "p90")}
    lines = [
        f"{result['name']}: {scale['outbound_steps']} steps out, {scale['homing_steps']} home; "
        f"{scale['steps_per_length_unit']:.4g} steps per {scale['length_unit']}; heading: {result['heading']}",
        f"turning point         {show('distance_of_turning_point', digits=4)} {unit} from the nest",
        f"closest distance      mean {closest['mean']}, median {closest['median']}, SD {closest['sd']}, "
        f"90th percentile {closest['p90']} {unit} (n = {measures['closest_distance']['n']})",
        f"found the nest        {show('came_within_search_radius', times=100)} % of the trials "
        f"(came within {scale['search_radius']:.3g} {unit})",
        f"decoded home vector   {show('decoded_bearing_error_absolute')}° off, "
        f"{show('decoded_over_true_length')} × as long",
        f"straightness          {show('straightness')}, tortuosity {show('tortuosity', digits=4)}",
    ]
    lines += [f"note: {note}" for note in result["notes"]]
    return "\n".join([*lines, f"figure, table and data: {folder}"])
