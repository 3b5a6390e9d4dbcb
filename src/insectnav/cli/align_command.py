"""`insectnav align`: pictures through other filters, laid over a fixed one."""

from pathlib import Path
from typing import Annotated

import typer


def align(
    fixed: Annotated[str, typer.Argument(metavar="FIXED", help="Image that stays as it is.")],
    moving: Annotated[list[str], typer.Argument(metavar="MOVING...", help="Images to be laid over it.")],
    out: Annotated[str, typer.Option(help="Folder for the aligned images.")] = "out/aligned",
    transform: Annotated[str, typer.Option(help="translation, rigid, similarity or affine.")] = "rigid",
    fixed_band: Annotated[str, typer.Option(help="Of a colour image: mean, red, green or blue.")] = "mean",
    moving_band: Annotated[
        str, typer.Option(help="The same of the moving ones; red for UV by a full-spectrum camera.")
    ] = "mean",
    largest_shift: Annotated[float, typer.Option(help="Share of width and height that is searched.")] = 0.1,
    seed: Annotated[int, typer.Option(help="Of the choice of pixels.")] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """Lay images of one scene through different filters over each other, by mutual information."""
    from insectnav.experiments.filter_series import align_files
    from insectnav.experiments.results import check_not_empty, to_json
    from insectnav.vision.registration import RegistrationParams

    check_not_empty(out)
    params = RegistrationParams(transform=transform, largest_shift=largest_shift, seed=seed)
    rows = align_files(Path(fixed), [Path(path) for path in moving], Path(out), params, fixed_band, moving_band)
    if as_json:
        print(to_json({"fixed": fixed, "transform": transform, "folder": out, "images": rows}))
        return
    for row in rows:
        print(
            f"{row['aligned']}: {row['columns_px']:+.2f} columns, {row['rows_px']:+.2f} rows, "
            f"{row['rotation_deg']:+.3f}°, scale {row['scale']:.5f}; mutual information "
            f"{row['mutual_information_before_nat']:.3f} → {row['mutual_information_nat']:.3f} nat"
        )
