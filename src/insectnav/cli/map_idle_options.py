"""Options of `insectnav map` that would do nothing where they stand: refused by name, with the reason."""

from collections.abc import Iterable, Mapping
from typing import Any

from insectnav.checks import InputError
from insectnav.cli.map_options import DESCRIBE, MATCH, THIN
from insectnav.cli.option_tables import Option, field_of

Given = Mapping[str, Any]
Reasons = Mapping[str, str]  # option, and the rest of the sentence that begins with its name
CLOCK_OPTIONS = ("--times", "--time-offset", "--utc-offset")
OF_LINES = ("--slowest", "--fastest")


def refuse_idle(given: Given, reasons: Reasons) -> None:
    """Refuse the first option that was given and would do nothing.

    Parameters
    ----------
    given : values of options by the names of their keywords
    reasons : why an option does nothing here

    Raises
    ------
    InputError
        One sentence that names the option and says why.
    """
    for option, why in reasons.items():
        if is_given(given, option):
            raise InputError(f"{option} is given {why}")


def is_given(given: Given, option: str) -> bool:
    """Whether an option of this command was given."""
    value = given.get(field_of(option))
    return value is not None and value is not False


def without_what_they_need(given: Given) -> Reasons:
    """Options that do nothing without another, or with one that leaves them nothing to do.

    Parameters
    ----------
    given : options of any command of maps
    """
    reasons: dict[str, str] = {}
    if not is_given(given, "--positions"):
        alone = ("--position-columns", "--position-topic", "--max-gap", "--first-day")
        reasons |= dict.fromkeys(alone, "without --positions, expected both")
    if given.get("times") not in ("names", "exif"):
        reasons["--utc-offset"] = "without --times names or exif, expected it with clocks that name no time zone"
    if given.get("sequence_length") == 1:
        one_by_one = "with --sequence-length 1, expected none where frames are matched one by one, not along a line"
        reasons |= dict.fromkeys(OF_LINES, one_by_one)
        if given.get("search") != "index":
            reasons["--contrast-window"] = one_by_one
    return reasons


def without_a_page(has_page: bool) -> Reasons:
    """Options that are of the page alone, where there is none."""
    return {} if has_page else {"--title": "without a page, expected --page or --out-dir, too"}


def with_a_table(given: Given) -> Reasons:
    """Options that mean nothing to a table of matches, whose frames were described and matched when it was made.

    Parameters
    ----------
    given : options of `map evaluate`
    """

    def done(what: str) -> str:
        return f"with a table of matches, whose frames {what} when it was made, expected it with a map and frames alone"

    reasons = dict.fromkeys(_names(DESCRIBE), done("were described"))
    reasons |= dict.fromkeys([name for name in _names(MATCH) if name != "--threshold"], done("were matched"))
    reasons |= dict.fromkeys([*_names(THIN), "--topic", "--workers"], done("were read"))
    reasons |= dict.fromkeys(CLOCK_OPTIONS, done("were given their times"))
    if not is_given(given, "--positions"):
        reasons["--clock"] = "with a table of matches and no --positions, expected both"
    if truth := _truth_in_frames(given):
        reasons["--positions"] = f"with a table of matches and {truth}, expected one kind of truth"
    return reasons


def with_a_map_to_evaluate(given: Given) -> Reasons:
    """Options of `map evaluate` that are of tables alone, and those of which nothing comes but what is judged.

    Parameters
    ----------
    given : options of `map evaluate`
    """
    reasons = {"--map": "with a map and frames, expected it with a table of matches alone"}
    if (truth := _truth_in_frames(given)) and not is_given(given, "--every-m"):
        reasons["--positions"] = f"with {truth}, expected one kind of truth, or --every-m that takes frames by position"
    return reasons


def _truth_in_frames(given: Given) -> str:
    """The option that tells the truth in frames; nothing if none does."""
    return next((option for option in ("--same-index", "--truth", "--key-frames") if is_given(given, option)), "")


def _names(options: Iterable[Option]) -> list[str]:
    return [name for name, *_ in options]
