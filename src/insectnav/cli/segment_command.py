"""`insectnav segment`: photographs in, masks of the sky out."""

from pathlib import Path
from typing import Annotated, Any

import typer

from insectnav.cli.progress import progress_bar

MAX_NAMED = 5  # skipped files that are told one by one


def segment(
    images: Annotated[list[str], typer.Argument(help="Photographs, folders of them, videos.")],
    method: Annotated[
        list[str] | None,
        typer.Option(
            help="NAME or NAME:CHANNELS, where NAME is otsu, watershed, watershed-islands, kmeans, gmm, skylight, "
            "fixed (with --threshold) or trained (with --truth); may be given several times [default: skylight for "
            "pictures in colour, watershed for others]."
        ),
    ] = None,
    channels: Annotated[
        str | None,
        typer.Option(
            help="mean, grey, red (UV behind a UV filter), green, blue; rgb or lab-ab for kmeans and gmm [default: the "
            "mean where a method needs one channel, rgb where not]."
        ),
    ] = None,
    view: Annotated[str, typer.Option(help="ahead: the top of the picture is up; up: its middle is.")] = "ahead",
    radius: Annotated[
        float | None, typer.Option(help="Of the round picture in a view up [px; default: to the nearer edges].")
    ] = None,
    mask: Annotated[str | None, typer.Option(help="PNG that is black where pixels are to be left out.")] = None,
    threshold: Annotated[float | None, typer.Option(help="Of --method fixed, in the unit of the pictures.")] = None,
    leave_out_flare: Annotated[
        bool, typer.Option("--leave-out-flare", help="Leave out what is as bright as the brightest.")
    ] = False,
    smooth: Annotated[int, typer.Option(help="Recent frames that vote on each mask; 1: none but its own.")] = 1,
    step: Annotated[int, typer.Option(help="Take every so many frames of a video.")] = 1,
    seed: Annotated[int, typer.Option(help="Of kmeans and gmm.")] = 0,
    truth: Annotated[
        str | None, typer.Option(help="Folder of masks NAME.png or NAME_sky.png: 255 sky, 0 not, 128 unknown.")
    ] = None,
    out: Annotated[str | None, typer.Option(help="Folder for the results [default: out/segment-NAME].")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """Cut the sky out of photographs."""
    from insectnav.datasets.image_folder import PICTURES, RAW, VIDEOS, find_images
    from insectnav.experiments.picture_sources import count_pictures
    from insectnav.experiments.results import check_destination, to_json
    from insectnav.experiments.segment_images import SegmentParams, run

    params = SegmentParams(
        methods=tuple(method or ()),
        channels=channels,
        view=view,
        radius=radius,
        mask=mask,
        threshold=threshold,
        leave_out_flare=leave_out_flare,
        smooth=smooth,
        step=step,
        seed=seed,
    )
    folder = Path(out if out is not None else f"out/segment-{Path(images[0]).resolve().stem}")
    check_destination(folder if out is None else out)
    total = count_pictures(find_images(images, (*PICTURES, *RAW, *VIDEOS)), step)
    with progress_bar(total, "pictures") as advance:
        result = run(images, params, folder, truth, advance)
    print(to_json(result | {"folder": str(folder)}) if as_json else _in_words(result, folder))


def _in_words(result: dict[str, Any], folder: Path) -> str:
    """What a person wants to know of masks."""
    lines = [f"{result['images']} pictures"]
    for name, entry in result["methods"].items():
        line = f"{name:18s} {entry['images']} masks, sky {100 * entry['sky_fraction_mean']:.1f} %, confidence "
        line += f"{entry['confidence_mean']:.2f} in the mean"
        if entry["doubtful"]:
            line += f", {entry['doubtful']} to look at below 0.5 (least: {entry['least_confident_image']})"
        if entry.get("images_with_truth"):
            line += (
                f"; accuracy {100 * entry['accuracy_mean']:.2f} % (worst {100 * entry['accuracy_worst']:.1f} %, "
                f"{entry['worst_image']}), IoU {entry['iou_mean']:.3f}, skyline "
                f"{entry['skyline_error_px_mean']:.2f} px off"
            )
        lines.append(line)
    for test in result["tests"]:
        if test["quantity"] == "accuracy":
            lines.append(
                f"{test['method']} against {test['other']}: accuracy {100 * test['mean_difference']:+.2f} points, "
                f"Wilcoxon p = {test['wilcoxon_p']:.2g}; variance ratio {test['variance_ratio']:.2f}, "
                f"F test p = {test['variance_p']:.2g} (n = {test['images']})"
            )
    skipped = [one for one in result["skipped"] if not one["reason"].startswith("the mask of")]
    lines += [f"skipped {one['name']}: {one['reason']}" for one in skipped[:MAX_NAMED]]
    if len(skipped) > MAX_NAMED:
        lines.append(f"skipped {len(skipped) - MAX_NAMED} more: see summary.json")
    if n_masks := len(result["skipped"]) - len(skipped):
        lines.append(f"skipped {n_masks} files that are masks of photographs by their names")
    lines += [f"note: {note}" for note in result["notes"]]
    return "\n".join([*lines, f"masks, overlays and tables: {folder}"])
