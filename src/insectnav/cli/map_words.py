"""What the commands of maps tell a person."""

from collections.abc import Mapping, Sequence
from typing import Any

from insectnav.checks import counted

MOST_NOTES = 10  # told one by one


def built_in_words(result: Mapping[str, Any]) -> str:
    """What a person wants to know of a map just built."""
    earlier = result["frames_from_earlier_run"]
    lines = [
        f"{counted(result['frames'], 'frame')} in {result['seconds']:.1f} s "
        f"({result['frames_per_second']:.0f} a second)"
        + (f", {earlier} more from an earlier run" if earlier else "")
        + (f", {result['missing']} of them missing" if result["missing"] else ""),
        *_facts(result),
        *_notes(result["notes"]),
        *_skipped(result["skipped"]),
    ]
    return "\n".join(lines)


def info_in_words(result: Mapping[str, Any]) -> str:
    """What a person wants to know of a map."""
    state = ["note: frames are being added, or a build was interrupted: `insectnav map build ... --add` goes on"]
    return "\n".join([*_facts(result), *(state if result["is_unfinished"] else [])])


def located_in_words(result: Mapping[str, Any], files: Mapping[str, str]) -> str:
    """What a person wants to know of frames just located."""
    seconds = result["seconds"]
    lines = [
        result["lead"],
        *_scores(result["numbers"]),
        f"{seconds['describing']:.1f} s to read and describe, {seconds['matching']:.2f} s to match",
        *_notes(result["notes"]),
        *(f"{what}: {path}" for what, path in files.items()),
    ]
    return "\n".join(lines)


def evaluated_in_words(result: Mapping[str, Any]) -> str:
    """What a person wants to know of matches that were judged."""
    truth = f"truth: {result['truth']}, right within {result['numbers']['tolerance']:g} {result['numbers']['unit']}"
    return "\n".join([result["lead"], truth, *_scores(result["numbers"]), *_notes(result["notes"])])


def _facts(result: Mapping[str, Any]) -> list[str]:
    settings = ", ".join(f"{name} {value}" for name, value in result["settings"].items())
    camera = f", camera {result['camera']}" if result["camera"] else ""
    lines = [
        f"{result['map']}: {counted(result['places'], 'place')} on {counted(result['routes'], 'route')}, "
        f"{result['bytes'] / 1e6:.1f} MB" + (", frozen" if result["is_frozen"] else ""),
        f"described by {result['descriptor']} ({counted(result['features'], 'feature')}, {result['metric']}){camera}"
        + (f"; {settings}" if settings else ""),
    ]
    if result["with_position"]:
        length = ""
        if result["length_m"] is not None:
            length = f", {result['length_m']:.0f} m in steps of {result['spacing_m']:.2g} m"
        origin = ""
        if result["origin_deg"] is not None:
            origin = ", from latitude {:.5f}°, longitude {:.5f}°".format(*result["origin_deg"])
        lines.append(f"positions of {counted(result['with_position'], 'place')}{length}{origin}")
    if result["with_time"]:
        lines.append(f"times of {counted(result['with_time'], 'place')}")
    return lines


def _scores(numbers: Mapping[str, Any]) -> list[str]:
    lines = []
    if "precision_of_all" in numbers:
        share = "unknown, as none can be judged" if not numbers["judged"] else f"{numbers['precision_of_all']:.1%}"
        lines.append(
            f"precision of all matches {share}, recall at 100 % precision "
            f"{numbers['recall_at_full_precision']:.1%}, area {numbers['area']:.3f}"
        )
    if numbers.get("precision_kept") is not None:
        recall = numbers["recall_kept"]
        lines.append(
            f"up to the score {numbers['threshold']}: precision {numbers['precision_kept']:.1%}"
            + ("" if recall is None else f", recall {recall:.1%}")
        )
    if "error_median" in numbers:
        from insectnav.experiments.place_maps.truth import quantity

        errors = {
            name: quantity(numbers[f"error_{name}"], numbers["unit"]) for name in ("median", "90_percent", "largest")
        }
        some, unknown = numbers["errors_known"], numbers["kept_judged"] - numbers["errors_known"]
        lines.append(
            "off by {median} in the median, {90_percent} in nine of ten, {largest} at most".format(**errors)
            + (f": of {some}, as {unknown} more have no true place on their route" if unknown else "")
        )
    return lines


def _notes(notes: Sequence[str]) -> list[str]:
    lines = [f"note: {note}" for note in notes[:MOST_NOTES]]
    return lines + ([f"note: {len(notes) - MOST_NOTES} more, see --json"] if len(notes) > MOST_NOTES else [])


def _skipped(skipped: Sequence[Mapping[str, str]]) -> list[str]:
    if not skipped:
        return []
    files = counted(len(skipped), "file that is no frame", "files that are no frames")
    return [f"skipped {files}, such as {skipped[0]['name']} ({skipped[0]['reason']})"]
