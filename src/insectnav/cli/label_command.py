"""`insectnav label`: ground truth by hand, on a local page or from strokes painted elsewhere."""

import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from insectnav.checks import InputError

if TYPE_CHECKING:
    from insectnav.labelling.desk import Desk
    from insectnav.labelling.masks import Shares

FOLDER = "out/labels"


def label(
    images: Annotated[list[str], typer.Argument(metavar="IMAGE...", help="Images, or folders of images.")],
    strokes: Annotated[
        str | None,
        typer.Option(metavar="PNG", help="Take these strokes (255 sky, 0 ground, 128 elsewhere) and open no page."),
    ] = None,
    out: Annotated[
        str | None,
        typer.Option(help=f"Folder for masks and strokes [default: {FOLDER}]; with --strokes, the mask as a PNG."),
    ] = None,
    browser: Annotated[bool, typer.Option(help="Open the page in the browser; its address is shown anyway.")] = True,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """Paint sky and ground on pictures and save the masks that the strokes grow to."""
    from insectnav.experiments.results import check_not_empty
    from insectnav.labelling.pictures import MASK, list_pictures

    if out is not None:
        check_not_empty(out)
    pictures = list_pictures(images)
    if strokes is None:
        told = _on_a_page(pictures, Path(out or FOLDER), browser)
    elif len(pictures) != 1:
        raise InputError(f"--strokes is one picture of strokes, expected one image, but {len(pictures)} were named")
    else:
        from insectnav.labelling.masks import mask_from_strokes

        mask = Path(out or Path(FOLDER, pictures[0].stem + MASK))
        if mask.suffix.lower() != ".png":
            raise InputError(f"--out {str(mask)!r} is no name of a PNG, expected one, as in --out MASK.png")
        told = {"masks": [_as_object(pictures[0], mask, mask_from_strokes(pictures[0], Path(strokes), mask))]}
    if as_json:
        from insectnav.experiments.results import to_json

        print(to_json(told))
    else:
        print(_in_words(told["masks"]))


def _on_a_page(pictures: list[Path], folder: Path, opens_browser: bool) -> dict[str, Any]:
    """What was saved by the time the page is finished or closed, or the program is interrupted."""
    from insectnav.labelling.desk import Desk
    from insectnav.labelling.server import LabelServer

    desk = Desk(pictures, folder)
    server = LabelServer(desk)
    print(f"paint at {server.url} ; Finish on the page, or Ctrl-C here, ends it", file=sys.stderr, flush=True)
    if opens_browser:
        import webbrowser

        webbrowser.open(server.url)
    with suppress(KeyboardInterrupt):  # one of the ways to end
        server.serve()
    desk.close()
    return {"folder": str(folder), "masks": _saved(desk)}


def _saved(desk: "Desk") -> list[dict[str, Any]]:
    return [
        _as_object(saved.picture, saved.mask, saved.shares) | {"strokes": str(saved.strokes)}
        for _, saved in sorted(desk.saved.items())
    ]


def _as_object(picture: Path, mask: Path, shares: "Shares") -> dict[str, Any]:
    return {
        "image": str(picture),
        "mask": str(mask),
        "sky_share": shares.sky,
        "ground_share": shares.ground,
        "unreached_pixels": shares.unreached,
    }


def _in_words(masks: list[dict[str, Any]]) -> str:
    """What a person wants to know: a line for each mask."""
    lines = []
    for mask in masks:
        note = f", {mask['unreached_pixels']} pixels that no stroke reaches (128)" if mask["unreached_pixels"] else ""
        lines.append(f"{mask['mask']}: {100 * mask['sky_share']:.1f} % sky{note}")
    return "\n".join(lines) or "no mask was saved"
