"""Logs of satellite receivers: sentences of NMEA 0183, of which those with a position or a date are read."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from datetime import UTC, date, datetime
from itertools import pairwise
from typing import Any, NoReturn

import numpy as np

from insectnav.angles import Floats
from insectnav.checks import InputError
from insectnav.datasets.gps_track import GpsTrack

MAX_SENTENCE = 120  # characters; the standard allows 82, some receivers more digits
READ = ("RMC", "GGA", "ZDA")
FIX_QUALITIES = (1, 2, 3, 4, 5)  # of GGA: measured; 6 is dead reckoning, 7 typed in, 8 simulated
DAY = 86_400.0  # [s]
LOOK_BACK = 3  # epochs
_KIND = re.compile(r"\$[A-Z]{2}([A-Z]{3}),")
SENTENCE = re.compile(rb"\$[A-Z]{2}[A-Z]{3},[^\r\n]*[\r\n]")
_TIME = re.compile(r"(\d\d)(\d\d)(\d\d(?:\.\d*)?)", re.ASCII)
_DEGREES = re.compile(r"(\d{1,3})(\d\d(?:\.\d*)?)", re.ASCII)


@dataclass(kw_only=True)
class _Epoch:
    """What the sentences of one moment say."""

    clock: float  # [s] of the day
    day: date | None = None
    place: tuple[float, float] | None = None
    height: float = float("nan")
    is_void: bool = False  # whether the receiver said that it had no fix


@dataclass(kw_only=True)
class _Log:
    """Epochs in order, and how many sentences were of no use, by reason."""

    epochs: list[_Epoch] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)
    kinds: Counter[str] = field(default_factory=Counter)
    has_checksums: bool = True


def parse_nmea(text: str, first_day: date | None = None) -> GpsTrack:
    """The fixes of a log, date and place from RMC joined with the height from GGA of the same moment.

    Sentences with a wrong checksum are left out and counted in the notes; so are those without one in a log that has
    them, since they may be cut short. A time of day that falls back by half a day or more is of the next day.

    Parameters
    ----------
    text : lines, in the order in which they were received
    first_day : date of the first fix [UTC], for logs without RMC and ZDA

    Raises
    ------
    InputError
        If no sentence holds a fix.
    """
    log = _read(text)
    epochs = [epoch for epoch in log.epochs if epoch.place is not None or not epoch.is_void]
    fixes = [epoch for epoch in epochs if epoch.place is not None]
    if not fixes:
        _refuse(log)
    days = _days(epochs, first_day)
    time = np.array([epoch.clock + day for epoch, day in zip(epochs, days, strict=True)], float)
    time = time[[epoch.place is not None for epoch in epochs]]
    notes = [f"sentences left out, {reason}: {count}" for reason, count in sorted(log.counts.items())]
    if not log.has_checksums:
        notes.append("the sentences have no checksums: damage goes unnoticed")
    if np.isnan(time).any():
        notes.append("the log has times of day but no date (RMC or ZDA): times are not known unless a day is given")
    place = np.array([epoch.place for epoch in fixes])
    return GpsTrack(
        time=time,
        latitude_deg=place[:, 0],
        longitude_deg=place[:, 1],
        height=np.array([epoch.height for epoch in fixes]),
        segment=np.cumsum(np.diff(time, prepend=time[0]) < 0),  # a log appended to another
        notes=tuple(notes),
    )


def _read(text: str) -> _Log:
    import pynmea2

    log = _Log()
    sentences = list(_sentences(text, log))
    has_checksums = any("*" in sentence for sentence in sentences)
    for sentence in sentences:
        try:
            message = pynmea2.parse(sentence, check=has_checksums)
        except pynmea2.ChecksumError:
            log.counts["wrong checksum, or none" if has_checksums else "wrong checksum"] += 1
            continue
        except (pynmea2.ParseError, ValueError):
            log.counts["cannot be parsed"] += 1
            continue
        _add(log, message)
    log.has_checksums = has_checksums
    return log


def _sentences(text: str, log: _Log) -> Iterator[str]:
    """The sentences that are read, without what a program may have put before them."""
    for line in text.splitlines():
        start = line.rfind("$")
        if start < 0:
            continue
        sentence = line[start:].strip()
        kind = _KIND.match(sentence)
        if kind is None or len(sentence) > MAX_SENTENCE:
            log.kinds["others"] += 1
            continue
        log.kinds[kind[1]] += 1
        if kind[1] in READ:
            yield sentence


def _add(log: _Log, message: Any) -> None:
    """Add what a sentence says to the epoch of its time of day.

    Without a fix, date and time may be those that a receiver starts with, such as 6 January 1980.
    """
    clock = _clock(message.data[0] if message.data else "")
    kind = message.sentence_type
    is_fix = kind != "ZDA" and _is_fix(message)
    if clock is not None and (kind == "ZDA" or (kind == "RMC" and is_fix)):
        day = _day(message)
        epoch = _epoch(log, clock, day)
        epoch.day = day or epoch.day
    if kind == "ZDA":
        return
    if clock is not None and not is_fix:
        _epoch(log, clock).is_void = True
    place = _place(message.lat, message.lat_dir, message.lon, message.lon_dir) if is_fix else None
    if clock is None or place is None:
        log.counts["a fix without time or place" if is_fix else "no fix"] += 1
        return
    epoch = _epoch(log, clock)
    epoch.place = epoch.place or place
    if kind == "GGA" and isinstance(message.altitude, float) and np.isfinite(message.altitude):
        epoch.height = message.altitude


def _epoch(log: _Log, clock: float, day: date | None = None) -> _Epoch:
    """The epoch of a time of day among the last few, since some receivers send one sentence later, or a new one."""
    for epoch in reversed(log.epochs[-LOOK_BACK:]):
        if epoch.clock == clock and (day is None or epoch.day in (None, day)):
            return epoch
    log.epochs.append(_Epoch(clock=clock))
    return log.epochs[-1]


def _is_fix(message: Any) -> bool:
    """Whether a receiver measured this: status A of RMC, a quality of GGA.

    Unlike the property is_valid of pynmea2 1.19, a last field V (integrity not stated, as u-blox sends) is accepted.
    """
    if message.sentence_type == "GGA":
        return message.gps_qual in FIX_QUALITIES
    return message.status == "A" and message.mode_indicator not in ("N", "E", "M", "S")


def _clock(text: str) -> float | None:
    """Seconds of the day of hhmmss.ss."""
    found = _TIME.fullmatch(text)
    if found is None:
        return None
    hours, minutes, seconds = int(found[1]), int(found[2]), float(found[3])
    return 3600.0 * hours + 60.0 * minutes + seconds if hours < 24 and minutes < 60 and seconds < 60 else None


def _day(message: Any) -> date | None:
    try:
        day = message.datestamp
    except (TypeError, ValueError):  # a date of ZDA that is missing or is none
        return None
    return day if isinstance(day, date) else None


def _place(latitude: str, north: str, longitude: str, east: str) -> tuple[float, float] | None:
    """Degrees of (d)ddmm.mm and the letters of the directions; None where something is missing."""
    degrees = []
    for text, letter, letters, most in ((latitude, north, "NS", 90.0), (longitude, east, "EW", 180.0)):
        found = _DEGREES.fullmatch(text or "")
        if found is None or not letter or letter not in letters or float(found[2]) >= 60:
            return None
        value = int(found[1]) + float(found[2]) / 60
        if value > most:
            return None
        degrees.append(value if letter == letters[0] else -value)
    return degrees[0], degrees[1]


def _days(epochs: Sequence[_Epoch], first_day: date | None) -> Floats:
    """Seconds since 1970 at the midnight before each epoch; NaN where no date is known."""
    days: list[float] = [_midnight(epoch.day) for epoch in epochs]
    if first_day is not None and np.isnan(days).all():
        days[0] = _midnight(first_day)
    falls = [before.clock - after.clock > DAY / 2 for before, after in pairwise(epochs)]
    for k in range(1, len(days)):
        if np.isnan(days[k]):
            days[k] = days[k - 1] + DAY * falls[k - 1]
    for k in reversed(range(len(days) - 1)):
        if np.isnan(days[k]):
            days[k] = days[k + 1] - DAY * falls[k]
    return np.array(days)


def _midnight(day: date | None) -> float:
    return float("nan") if day is None else datetime(day.year, day.month, day.day, tzinfo=UTC).timestamp()


def _refuse(log: _Log) -> NoReturn:
    if set(log.counts) == {"no fix"}:
        raise InputError(
            f"in all of {log.counts['no fix']} sentences RMC and GGA the receiver says that it has no fix (status V, "
            "quality 0), expected positions: recorded indoors, or before it had found its satellites?"
        )
    reasons = ", ".join(f"{count} {reason}" for reason, count in log.counts.most_common(3) if count)
    if reasons:
        raise InputError(f"none of {sum(log.kinds.values())} sentences holds a usable fix ({reasons}), expected some")
    kinds = ", ".join(kind for kind, _ in log.kinds.most_common(5)) or "no sentence at all"
    raise InputError(f"no sentence RMC or GGA among {kinds}, expected a log of positions in NMEA 0183")
