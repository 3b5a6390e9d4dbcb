"""`insectnav render`: a world in, pictures with masks, poses and light out."""

import gc
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from insectnav.checks import InputError, counted, quoted
from insectnav.cli.experiment_commands import RunInterruptedError
from insectnav.cli.progress import progress_bar
from insectnav.cli.render_options import with_options

if TYPE_CHECKING:
    from insectnav.experiments.rendering.plan import Plan, RenderParams

# Fields of the parameters, and the options that give them where the names differ.
_PLACE = {"seed": "seed", "world_time_s": "world_time", "up": "up", "metres_per_unit": "metres_per_unit",
          "material": "material", "light": "light"}  # fmt: skip
_PATH = {
    "positions": "positions", "spacing": "spacing", "frame_rate": "frame_rate", "n_frames": "frames", "speed": "speed",
    "start": "start", "stop": "stop", "is_reversed": "reverse", "offset": "offset", "heading_deg": "heading",
    "pitch_deg": "pitch", "roll_deg": "roll", "eye_height": "eye_height", "yaw_jitter_deg": "yaw_jitter",
    "pitch_jitter_deg": "pitch_jitter", "roll_jitter_deg": "roll_jitter", "lateral_jitter": "lateral_jitter",
    "jitter_length": "jitter_length", "jitter_seed": "jitter_seed",
}  # fmt: skip
_LIGHT = {"date": "date", "time": "time", "latitude_deg": "latitude", "longitude_deg": "longitude",
          "weather": "weather", "turbidity": "turbidity", "cloud_seed": "cloud_seed"}  # fmt: skip
_CAMERA = {"kind": "camera", "resolution_deg": "resolution", "field_of_view_deg": "field_of_view", "lens": "lens",
           "look": "look", "supersampling": "supersampling"}  # fmt: skip
_PICTURES = {
    "format": "format", "bits": "bits", "response": "response", "meter": "meter", "balance": "white_balance",
    "noise": "noise", "noise_seed": "noise_seed", "flare": "flare",
}  # fmt: skip


@with_options
def render(**given: Any) -> None:
    """Render a world: one picture, a traverse of its route, or the positions of a table."""
    _render(given)


def _render(given: Mapping[str, Any]) -> None:
    """Plan, render and tell."""
    from insectnav.experiments.rendering.frame_store import finished_frames
    from insectnav.experiments.rendering.job import run
    from insectnav.experiments.rendering.plan import planned
    from insectnav.experiments.results import check_not_empty, to_json

    gc.enable()  # which `program` turns off; a run may be long
    params = render_params(given)
    out = given["out"]
    if out is not None:
        check_not_empty(out)
    folder = Path(f"out/{Path(params.place.world).stem or 'world'}" if out is None else out)
    plan = planned(params)
    how = {"resume": given["resume"], "replaces": given["replace"], "workers": given["workers"]}
    try:
        with progress_bar(len(plan.poses), "frames") as advance:
            result = run(plan, folder, **how, progress=advance)
    except KeyboardInterrupt:
        if finished_frames(folder):
            raise RunInterruptedError("frames") from None
        raise
    notes = notes_on(plan)
    print(to_json(result | {"notes": notes}) if given["json"] else _in_words(plan, result, notes))


def render_params(given: Mapping[str, Any]) -> "RenderParams":
    """Parameters from options by name; what is None has its default.

    Raises
    ------
    InputError
        If an option cannot be read.
    """
    from insectnav.experiments.rendering.cameras import CameraParams
    from insectnav.experiments.rendering.light import LightParams
    from insectnav.experiments.rendering.paths import PathParams
    from insectnav.experiments.rendering.pictures import PictureParams
    from insectnav.experiments.rendering.places import PlaceParams
    from insectnav.experiments.rendering.plan import RenderParams

    def chosen(names: Mapping[str, str], **more: Any) -> dict[str, Any]:
        found = {name: given[option_name] for name, option_name in names.items()} | more
        return {name: value for name, value in found.items() if value is not None}

    place = PlaceParams(world=given["world"], changes=_changes(given), **chosen(_PLACE))
    size = _numbers("--size", given["size"], 2, "x")
    pictures = given["pictures"]
    return RenderParams(
        place=place,
        path=PathParams(**chosen(_PATH, at=_numbers("--at", given["at"], (2, 3)))),
        light=LightParams(
            **chosen(_LIGHT, sun_deg=_numbers("--sun", given["sun"], 2), wind=_numbers("--wind", given["wind"], 2))
        ),
        camera=CameraParams(
            **chosen(
                _CAMERA,
                elevation_deg=_numbers("--elevation", given["elevation"], 2),
                size=None if size is None else (int(size[1]), int(size[0])),
            )
        ),
        pictures=PictureParams(
            **chosen(
                _PICTURES,
                pictures=None if pictures is None else tuple(name.strip() for name in pictures.split(",")),
                exposure=_number_or_word(given["exposure"]),
            )
        ),
        **chosen({"refresh_s": "refresh"}),
    )


def notes_on(plan: "Plan") -> list[str]:
    """What a user may not have meant, or should know.

    Parameters
    ----------
    plan : Plan
    """
    notes = list(plan.place.mesh.notes)
    light, params = plan.params.light, plan.params
    if plan.place.light != "sky":
        return notes
    month, north = int(light.date[5:7]), light.latitude_deg
    is_winter = abs(north) > 35.0 and month in ((12, 1, 2) if north > 0 else (6, 7, 8))
    if is_winter and plan.place.foliage == 1.0 and light.sun_deg is None:
        notes.append(f"trees have all their leaves on {light.date}: --foliage 0 makes it winter")
    if params.path.is_traverse and params.place.moves and plan.poses.time[-1] > params.refresh_s:
        notes.append(f"cars, people and clouds move on every {params.refresh_s:g} s of the walk: see --refresh")
    return notes


def _changes(given: Mapping[str, Any]) -> dict[str, Any]:
    """Parameters of the builder from --set and --foliage."""
    from insectnav.experiments.rendering.places import is_built, parameter_values

    settings = {}
    for text in given["set"] or []:
        name, sign, value = text.partition("=")
        if not sign:
            raise InputError(f"--set is {quoted(text)}, expected NAME=VALUE")
        settings[name.strip().replace("-", "_")] = value
    if given["foliage"] is not None:
        settings["foliage"] = str(given["foliage"])
    if not settings:
        return {}
    if not is_built(given["world"]):
        raise InputError(
            "--set and --foliage have no meaning for a mesh file, expected them with a world that is built"
        )
    return parameter_values(given["world"], settings)


def _numbers(name: str, text: str | None, count: int | tuple[int, ...], separator: str = ",") -> Any:
    """Numbers of an option such as 3,4; None if it is not given."""
    if text is None:
        return None
    counts = count if isinstance(count, tuple) else (count,)
    try:
        values = tuple(float(part) for part in text.lower().split(separator))
    except ValueError:
        values = ()
    is_whole = separator != "x" or all(value.is_integer() and value > 0 for value in values)
    if len(values) not in counts or not is_whole:
        example = "640x480" if separator == "x" else ",".join("123"[: counts[0]])
        raise InputError(f"{name} is {quoted(text)}, expected {' or '.join(map(str, counts))} numbers as in {example}")
    return values


def _number_or_word(text: str | None) -> str | float | None:
    try:
        return None if text is None else float(text)
    except ValueError:
        return text


def _in_words(plan: "Plan", result: Mapping[str, Any], notes: list[str]) -> str:
    """What a person wants to know of the frames."""
    rows, columns = plan.camera.size
    n, n_kept = len(plan.poses), result["frames_from_earlier_run"]
    kept = f", {n_kept} of them from an earlier run" if n_kept else ""
    lines = [
        f"{plan.place.name}: {counted(n, 'frame')} of {columns} × {rows} pixels in {result['seconds']:.1f} s{kept}",
        f"pictures: {', '.join(plan.names)}",
        f"poses and light: {result['folder']}/frames.csv; to look at: {result['folder']}/contact_sheet.png",
    ]
    return "\n".join([*lines, *(f"note: {note}" for note in notes)])
