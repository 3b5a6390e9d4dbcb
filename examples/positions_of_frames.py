# %% [markdown]
# # Where and when frames were taken
#
# A walker carries a camera and a satellite receiver, twice around the same loop. The receiver of the first walk writes
# NMEA sentences and loses the satellites under trees; that of the second writes GPX. The frames have their times in
# their names, by a clock that is two hours ahead. Which frame was taken where, and which of the second walk belongs to
# which of the first? Both walks are made up here, in a temporary folder.
#
#     python examples/positions_of_frames.py [FOLDER]

# %%
import sys
import tempfile
from datetime import UTC, datetime, timedelta
from functools import reduce
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from insectnav.datasets.frame_times import times_of_frames
from insectnav.datasets.key_frames import read_key_frames
from insectnav.datasets.positions import positions_of_frames, read_positions
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, journal_style, name_panel, save_figure
from insectnav.metrics.place_truth import true_matches_by_frames, true_matches_by_position

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
folder.mkdir(parents=True, exist_ok=True)
ORIGIN = 50.0, 10.0  # [deg] latitude and longitude
METRES = 111_229.0, 71_696.0  # in a degree of latitude and longitude there (WGS84)


# %% A loop of half a kilometre at a walk, and a receiver that wanders by a metre or two
def loop(seconds, pace):
    """East and north (n, 2) [m] of a walker on the loop."""
    angle = pace * seconds / 80.0
    reach = 80.0 + 18.0 * np.sin(3 * angle) + 8.0 * np.cos(5 * angle)
    return np.stack([1.4 * reach * np.sin(angle), reach * np.cos(angle) - 88.0], axis=-1)


def received(seconds, pace, seed):
    """Latitude and longitude (n, 2) [deg] of fixes, whose errors change slowly, as those of receivers do."""
    rng = np.random.default_rng(seed)
    error = np.zeros((len(seconds), 2))
    for k in range(1, len(seconds)):
        error[k] = 0.98 * error[k - 1] + 0.3 * rng.normal(size=2)
    return (loop(seconds, pace) + error)[:, ::-1] / METRES + ORIGIN


def sentence(words):
    """A line of NMEA 0183: the words and their checksum."""
    return f"${words}*{reduce(lambda total, letter: total ^ ord(letter), words, 0):02X}\n"


def coordinate(degrees, letters, width):
    whole, minutes = divmod(round(60 * abs(degrees), 4), 60)
    return f"{int(whole):0{width}d}{minutes:07.4f},{letters[int(degrees < 0)]}"


def nmea(start, seconds, fixes):
    lines = ""
    for second, (latitude, longitude) in zip(seconds, fixes, strict=True):
        moment = start + timedelta(seconds=float(second))
        place = f"{coordinate(latitude, 'NS', 2)},{coordinate(longitude, 'EW', 3)}"
        lines += sentence(f"GPGGA,{moment:%H%M%S},{place},1,08,1.0,212.0,M,47.0,M,,")
        lines += sentence(f"GPRMC,{moment:%H%M%S},A,{place},2.0,,{moment:%d%m%y},,,A")
    return lines


def gpx(start, seconds, fixes):
    points = ""
    for second, (latitude, longitude) in zip(seconds, fixes, strict=True):
        time = f"{start + timedelta(seconds=float(second)):%Y-%m-%dT%H:%M:%SZ}"
        points += f'<trkpt lat="{latitude:.7f}" lon="{longitude:.7f}"><time>{time}</time></trkpt>\n'
    return f'<gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg>\n{points}</trkseg></trk></gpx>'


def named_by_clock(start, seconds):
    """Names of frames, by a camera whose clock is two hours ahead of UTC."""
    return [f"IMG_{start + timedelta(hours=2, seconds=float(s)):%Y%m%d_%H%M%S%f}"[:-3] + ".jpg" for s in seconds]


# %% What the two walks leave behind
first_start, second_start = datetime(2014, 5, 6, 23, 56, tzinfo=UTC), datetime(2014, 11, 3, 12, 0, tzinfo=UTC)
first_seconds, second_seconds = np.arange(0.0, 360.0), np.arange(0.0, 300.0)
is_shaded = (first_seconds > 130) & (first_seconds < 158)  # under trees
first_names = named_by_clock(first_start, np.arange(0.5, 360.0, 4.0))
second_names = named_by_clock(second_start, np.arange(1.25, 300.0, 5.0))
with tempfile.TemporaryDirectory() as place:
    first_file, second_file, key_file = (Path(place) / name for name in ("may.nmea", "november.gpx", "keys.csv"))
    log = nmea(first_start, first_seconds[~is_shaded], received(first_seconds, 1.4, 1)[~is_shaded])
    first_file.write_text(log.replace(",1,08,", ",1,09,", 1))  # a letter that was received wrongly: the checksum tells
    second_file.write_text(gpx(second_start, second_seconds, received(second_seconds, 1.7, 2)))
    key_file.write_text("query,reference\n0,0\n10,15\n25,38\n40,61\n58,88\n")  # as a person would match them
    first = read_positions(first_file)
    second = read_positions(second_file, origin_deg=first.origin_deg)
    keys = read_key_frames(key_file)
print(f"first walk: {len(first.time)} fixes, notes: {'; '.join(first.notes)}")

# %% Where the frames were taken
first_times = times_of_frames("names", names=first_names, utc_offset_h=2.0)
second_times = times_of_frames("names", names=second_names, utc_offset_h=2.0)
first_place = positions_of_frames(first, times=first_times, max_gap_s=3.0)
second_place = positions_of_frames(second, times=second_times, max_gap_s=3.0)
is_known = np.isfinite(first_place[:, 0])
walked = loop(first_times - first_start.timestamp(), 1.4) - loop(np.zeros(1), 1.4)
off = np.linalg.norm(first_place[is_known, :2] - walked[is_known], axis=-1)
print(f"{is_known.sum()} of {len(is_known)} frames have a place, off by {np.median(off):.1f} m in the median")

# %% Which frame of the first walk each of the second belongs to
TOLERANCE = 8.0  # [m], a frame and a half
by_place = true_matches_by_position(first_place[:, :2], second_place[:, :2], TOLERANCE)
by_hand = true_matches_by_frames(keys, np.arange(len(second_names)))
both = by_place.can_be_matched & by_hand.can_be_matched
apart = np.abs(by_place.reference - by_hand.reference)[both]
print(
    f"{by_place.can_be_matched.sum()} of {len(both)} frames can be matched by place and {by_hand.can_be_matched.sum()} "
    f"by hand; the two differ by {np.median(apart):.1f} frames in the median"
)

# %% Draw
with journal_style():
    figure = Figure(figsize=(DOUBLE_COLUMN, 2.6), layout="constrained")
    axes = figure.subplot_mosaic("abc", width_ratios=[1.35, 1.0, 1.0])
    gap = np.flatnonzero(np.diff(first.time) > 3.0)[0] + 1
    for number, piece in enumerate(np.split(first.position, [gap])):
        axes["a"].plot(*piece[:, :2].T, color=COLOURS["grey"], linewidth=0.8, label=None if number else "fixes in May")
    axes["a"].plot(*second.position[:, :2].T, color=COLOURS["sky"], linewidth=0.8, label="fixes in November")
    axes["a"].plot(*first_place[:, :2].T, ".", color=COLOURS["black"], markersize=3, label="frames in May")
    axes["a"].plot(*walked[~is_known].T, "o", color=COLOURS["red"], markersize=2.5, markerfacecolor="none",
                   label="no place known")  # fmt: skip
    axes["a"].set(xlabel="east (m)", ylabel="north (m)", aspect="equal")
    axes["a"].legend(loc="center")
    name_panel(axes["a"], "a", "local plane")
    start = first_start.timestamp()
    shown = (first.time - start > 100) & (first.time - start < 190)
    axes["b"].plot(
        first.time[shown] - start, first.position[shown, 0], ".", color=COLOURS["grey"], markersize=2, label="fixes"
    )
    frames = (first_times - start > 100) & (first_times - start < 190)
    axes["b"].plot(
        first_times[frames] - start, first_place[frames, 0], ".", color=COLOURS["black"], markersize=4, label="frames"
    )
    lost = frames & ~is_known
    axes["b"].plot(first_times[lost] - start, walked[lost, 0], "o", color=COLOURS["red"], markersize=2.5,
                   markerfacecolor="none", label="no place known")  # fmt: skip
    axes["b"].set(xlabel="time of the walk (s)", ylabel="east (m)")
    axes["b"].legend(loc="best")
    name_panel(axes["b"], "b", "gap of 28 s")
    query = np.arange(len(second_names))
    axes["c"].plot(query, by_hand.reference, color=COLOURS["orange"], label="between key frames")
    axes["c"].plot(*keys.T, "s", color=COLOURS["orange"], markersize=3, label="key frames")
    axes["c"].plot(query, by_place.reference, ".", color=COLOURS["blue"], markersize=3, label=f"within {TOLERANCE:g} m")
    axes["c"].set(xlabel="frame in November", ylabel="true match in May (frame)")
    axes["c"].legend(loc="upper left")
    name_panel(axes["c"], "c", "true matches")
    save_figure(figure, folder, "positions-of-frames")
print(f"figure: {folder / 'positions-of-frames.png'}")
