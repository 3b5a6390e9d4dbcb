"""`insectnav map`: two recordings of one route in, and where the frames of the one lie on the other out."""

import gc
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from insectnav.checks import InputError, quoted
from insectnav.cli import map_options
from insectnav.cli.experiment_commands import RunInterruptedError
from insectnav.cli.map_idle_options import (
    refuse_idle,
    with_a_map_to_evaluate,
    with_a_table,
    without_a_page,
    without_what_they_need,
)
from insectnav.cli.map_words import built_in_words, evaluated_in_words, info_in_words, located_in_words
from insectnav.cli.option_tables import TEXTS, with_table
from insectnav.cli.progress import progress_bar

if TYPE_CHECKING:
    from insectnav.experiments.place_maps.locate import LocateParams, Search
    from insectnav.experiments.place_maps.opening import FrameParams
    from insectnav.experiments.place_maps.whereabouts import Whereabouts
    from insectnav.matching.places import PlaceMap

map_app = typer.Typer(
    name="map",
    help="Maps of places: built from the frames of a route, and other frames located in them.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


def build(**given: Any) -> None:
    """Build a map of the places that frames show."""
    from insectnav.experiments.place_maps.build import UNFINISHED, BuildParams, build
    from insectnav.experiments.place_maps.opening import count_frames
    from insectnav.experiments.results import to_json

    gc.enable()  # which `program` turns off; a map may be large
    refuse_idle(given, without_what_they_need(given))
    params = BuildParams(frames=_frame_params(given), adds=given["add"], freezes=given["freeze"])
    frames, folder = given["frames"], given["map_folder"]
    try:
        with progress_bar(count_frames(frames, params.frames), "frames") as advance:
            result = build(frames, folder, params, advance)
    except KeyboardInterrupt:
        if (Path(folder) / UNFINISHED).exists():
            raise RunInterruptedError("places", "--add") from None
        raise
    print(to_json(result) if given["json"] else built_in_words(result))


def locate(**given: Any) -> None:
    """Find the place of each frame in a map: a table of matches, and a page that shows them."""
    from insectnav.experiments.place_maps.report import Destinations, leave
    from insectnav.experiments.results import to_json
    from insectnav.matching.places import PlaceMap

    gc.enable()
    frames = given["frames"]
    usual = f"out/locate-{_word_of(frames[0])}"
    places = Destinations.given(given["out"], given["page"], given["out_dir"], usual)
    has_page = places.page is not None or places.folder is not None
    refuse_idle(given, {**without_what_they_need(given), **without_a_page(has_page)})
    place_map = PlaceMap.open(given["map_folder"])
    params = locate_params(given)
    search = _searched(place_map, frames, params)
    names = [Path(name).resolve().name or name for name in (frames[0], given["map_folder"])]
    title = given["title"] or f"{names[0]} located in {names[1]}"
    result = leave(places, search, params, place_map, title)
    if given["json"]:
        print(to_json(result | {"files": places.written, "matches": search.found.rows()}))
    else:
        print(located_in_words(result, places.written))


def evaluate(**given: Any) -> None:
    """Judge matches by what is known: those of a table, or those of frames in a map."""
    from insectnav.experiments.place_maps.evaluate import evaluate_search, evaluate_table
    from insectnav.experiments.results import to_json
    from insectnav.matching.places import PlaceMap

    gc.enable()
    first, frames = given["matches_or_map"], given["frames"] or []
    if not Path(first).exists():
        raise InputError(f"{quoted(first, 200)} does not exist, expected a table of matches or a map")
    if Path(first).is_dir():
        if not frames:
            raise InputError(
                f"{quoted(first, 200)} is a map, expected frames after it, or a table of matches in its place"
            )
        refuse_idle(given, {**without_what_they_need(given), **with_a_map_to_evaluate(given)})
        params, place_map = locate_params(given), PlaceMap.open(first)
        result = evaluate_search(_searched(place_map, frames, params), params, place_map)
    else:
        if frames:
            raise InputError(f"{quoted(first, 200)} is a table of matches, expected no frames after it")
        refuse_idle(given, {**without_what_they_need(given), **with_a_table(given)})
        result = evaluate_table(first, locate_params(given), given["map"])
    print(to_json(result) if given["json"] else evaluated_in_words(result))


@map_app.command()
def info(
    map_folder: Annotated[str, typer.Argument(metavar="MAP", help="Folder of the map.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """Tell what a map holds and how it was made."""
    from insectnav.experiments.place_maps.build import UNFINISHED, facts
    from insectnav.experiments.results import to_json
    from insectnav.matching.places import PlaceMap

    place_map = PlaceMap.open(map_folder)
    result = {"map": map_folder, **facts(place_map), "is_unfinished": (place_map.path / UNFINISHED).exists()}
    print(to_json(result) if as_json else info_in_words(result))


def locate_params(given: Mapping[str, Any]) -> "LocateParams":
    """Parameters from options by name; what is None has its default.

    Raises
    ------
    InputError
        If options do not go together.
    """
    from insectnav.experiments.place_maps.locate import LocateParams, TruthParams
    from insectnav.matching.seqslam import SeqSlamParams

    names = ("sequence_length", "slowest", "fastest", "contrast_window", "unique_window")
    return LocateParams(
        frames=_frame_params(given),
        seqslam=SeqSlamParams(**_chosen(given, {name: name for name in names})),
        truth=TruthParams(
            pairs=given["truth"],
            key_frames=given["key_frames"],
            same_index=given["same_index"],
            tolerance_frames=given["tolerance_frames"],
            tolerance_m=given["tolerance_m"],
        ),
        **_chosen(given, {"search": "search", "threshold": "threshold"}),
    )


def _frame_params(given: Mapping[str, Any]) -> "FrameParams":
    """Which frames are taken, how they are described, when and where they were."""
    from insectnav.experiments.place_maps.choices import GivenOptions
    from insectnav.experiments.place_maps.frames import Thinning
    from insectnav.experiments.place_maps.opening import FrameParams

    return FrameParams(
        given=GivenOptions(**_chosen(given, {name: name for name in ("descriptor", "camera", "sky", "metric")})),
        thinning=Thinning(step=given["step"], every_m=given["every_m"], every_s=given["every_s"]),
        where=_where(given),
        topic=given["topic"],
        pictures=not given.get("no_pictures", True),
        workers=given["workers"],
    )


def _where(given: Mapping[str, Any]) -> "Whereabouts":
    from insectnav.experiments.place_maps.whereabouts import Whereabouts

    columns = given["position_columns"]
    names = {
        "times": "times", "positions": "positions", "position_topic": "position_topic", "clock": "clock",
        "first_day": "first_day",
        "time_offset_s": "time_offset", "utc_offset_h": "utc_offset", "max_gap_s": "max_gap",
    }  # fmt: skip
    listed = None if columns is None else tuple(name.strip() for name in columns.split(","))
    return Whereabouts(**_chosen(given, names), columns=listed)


def _chosen(given: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """Fields that were given, by the names of their options."""
    return {name: given[option] for name, option in names.items() if given[option] is not None}


def _word_of(frames: str) -> str:
    """A word for the name of a folder, without what stands for several names in a pattern."""
    place = Path(frames).resolve()
    plain = re.sub(r"[-_ ]+$", "", re.sub(r"[*?\[\]]+", "", place.stem))
    return plain or place.parent.name


def _searched(place_map: "PlaceMap", frames: list[str], params: "LocateParams") -> "Search":
    from insectnav.experiments.place_maps.locate import locate
    from insectnav.experiments.place_maps.opening import count_frames

    with progress_bar(count_frames(frames, params.frames), "frames") as advance:
        return locate(place_map, frames, params, advance)


_FIRST = ("matches_or_map", str, "Table of matches as `map locate` writes it, or a map.", "MATCHES|MAP")
_THEN = ("frames", TEXTS, "With a map: frames to be located in it.", "[FRAMES...]")
_OF_MAP = ("--map", str | None, "With a table: the map, whose positions tell which queries can be matched", "", "MAP")
map_app.command("build")(with_table(build, (map_options.FRAMES, map_options.MAP), map_options.OF_BUILD))
map_app.command("locate")(with_table(locate, (map_options.MAP, map_options.FRAMES), map_options.OF_LOCATE))
map_app.command("evaluate")(with_table(evaluate, (_FIRST, _THEN), (*map_options.OF_EVALUATE, _OF_MAP)))
