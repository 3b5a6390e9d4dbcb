"""Frames as the user named them: opened, placed, thinned, and with what is known of how they are described."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

from insectnav.checks import InputError, counted
from insectnav.experiments.place_maps.choices import GivenOptions, chosen_params
from insectnav.experiments.place_maps.describe import DescribeParams
from insectnav.experiments.place_maps.frames import Frame, FrameSource, Thinning, open_frames, thinned
from insectnav.experiments.place_maps.whereabouts import Origin, Whereabouts, placed
from insectnav.matching.places import MapAbout


@dataclass(frozen=True, kw_only=True)
class FrameParams:
    """Which frames are taken, and what is done with each.

    Parameters
    ----------
    given : what the user said of descriptor, camera, sky and metric
    thinning : which frames are taken
    where : when and where they were taken
    topic : of the pictures in the recording of a robot
    pictures : whether small pictures are kept
    workers : threads; they change nothing in the results
    """

    given: GivenOptions = field(default_factory=GivenOptions)
    thinning: Thinning = field(default_factory=Thinning)
    where: Whereabouts = field(default_factory=Whereabouts)
    topic: str | None = None
    pictures: bool = True
    workers: int | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Opened:
    """Frames to be described.

    Parameters
    ----------
    frames : those that are taken, in order
    describe : how they are described, not yet settled
    source : all frames there are
    origin_deg : latitude and longitude of position (0, 0); None if unknown
    left_out : names of frames that cannot be thinned, filled as the frames are read
    thinning : which frames are taken
    file_notes : on times and positions
    """

    frames: Iterator[Frame]
    describe: DescribeParams
    source: FrameSource
    origin_deg: Origin
    left_out: list[str]
    thinning: Thinning
    file_notes: Sequence[str]

    @property
    def notes(self) -> list[str]:
        """What a person must know once the frames have been read, but for what is said of each."""
        said = [*self.file_notes, *self.source.remarks]
        if self.left_out:
            lack = "position" if self.thinning.every_m is not None else "time"
            some = counted(len(self.left_out), f"frame without a known {lack} is", f"frames without a known {lack} are")
            said.append(f"{some} left out, such as {self.left_out[0]}")
        return said


def opened(places: Sequence[str], params: FrameParams, about: MapAbout | None) -> Opened:
    """Frames of what the user named, to be described as those of a map.

    Parameters
    ----------
    places : folders, patterns, films, an array, a recording
    params : FrameParams
    about : of the map; None for a new one

    Raises
    ------
    InputError
        If they cannot be read, or options differ from those of the map.
    """
    step = params.thinning.step or 1
    source = open_frames(places, step=step, topic=params.topic, clock=params.where.clock)
    describe = chosen_params(params.given, about, source.is_vectors)
    source, origin, notes = placed(source, params.where, about.origin_deg if about else None)
    if about is not None and params.where.positions is not None:
        check_one_frame(origin, about.origin_deg)
    if params.thinning.every_m is not None and params.where.positions is None:
        raise InputError("--every-m is given without --positions, expected a file of where the frames were taken")
    if params.thinning.every_s is not None and params.where.times is None and not source.has_times:
        raise InputError("--every-s is given without --times, expected to know when the frames were taken")
    left_out: list[str] = []
    thinning = replace(params.thinning, step=step // source.step) if source.step > 1 else params.thinning
    return Opened(
        frames=thinned(source.frames, thinning, left_out),
        describe=describe,
        source=source,
        origin_deg=origin,
        left_out=left_out,
        thinning=params.thinning,
        file_notes=notes,
    )


def check_one_frame(own: Origin, of_map: Origin) -> None:
    """Refuse to put together positions of which some are on Earth and others metres from somewhere.

    Parameters
    ----------
    own : origin of the positions of frames, None for x and y
    of_map : origin of the positions of the map

    Raises
    ------
    InputError
        If just one of them is known.
    """
    if (own is None) == (of_map is None):
        return
    kinds = ("latitudes and longitudes", "x and y from an origin that is not known")
    mine, maps = kinds if of_map is None else kinds[::-1]
    maps += ", if it has any" if of_map is None else ""
    raise InputError(f"--positions are {mine}, but those of the map are {maps}, expected both in one frame")


def count_frames(places: Sequence[str], params: FrameParams) -> int:
    """How many frames are to be described, as far as the files say; 0 if nobody knows."""
    step = params.thinning.step or 1
    source = open_frames(places, step=step, topic=params.topic)
    return -(-source.total // (step // source.step))
