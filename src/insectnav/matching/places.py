"""Maps of places that stay on disk: made, added to, merged, and searched for where a sequence of frames was taken."""

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_choice
from insectnav.matching.place_about import MapAbout
from insectnav.matching.place_arrays import PlaceArrays, joined, new_places, no_places, read_places
from insectnav.matching.place_cluster_search import cluster_matches
from insectnav.matching.place_exact_search import Landscape, check_routes, checked_queries, exact_matches, landscape_of
from insectnav.matching.place_freeze import frozen
from insectnav.matching.place_index import METRICS_WITH_INDEX, PlaceIndex, read_index
from insectnav.matching.place_index_search import indexed_matches
from insectnav.matching.place_record import MapRecord, read_record, write_record
from insectnav.matching.place_segments import SEGMENTS, Segments, add_segment, read_segments
from insectnav.matching.place_store import DamagedError, only_writer, shown, whole_folder, written
from insectnav.matching.place_stream import MapStream, begin_map_stream
from insectnav.matching.seqslam import Matches, SeqSlamParams

Reals = NDArray[np.floating[Any]]
Integers = NDArray[np.int64]
SEARCHES = ("auto", "exact", "index")
EXACT_UP_TO = 60_000  # [place] to which "auto" compares with all, which then takes about as long; benchmarks/places.py


class PlaceMap:
    """Places along routes, in a folder on disk; a query changes nothing there.

    Made by `create`, `build` or `open`, or by `merge_maps`.
    """

    path: Path
    about: MapAbout

    def __init__(self, path: Path) -> None:
        self.path = path
        self._segments: Segments = {}
        self._whole: PlaceArrays | None = None
        self._compared: Landscape | None = None
        self._searched: PlaceIndex | None = None
        self._read()

    def __repr__(self) -> str:
        return f"<PlaceMap of {self.n_places} places in {shown(self.path)}>"

    @classmethod
    def create(cls, folder: str | os.PathLike[str], about: MapAbout) -> Self:
        """An empty map in a new folder.

        Raises
        ------
        InputError
            If there is something in the folder, or it cannot be written.
        """
        return cls(_made(Path(folder), about, []))

    @classmethod
    def build(
        cls,
        folder: str | os.PathLike[str],
        descriptors: ArrayLike,
        about: MapAbout,
        *,
        times: ArrayLike | None = None,
        positions: ArrayLike | None = None,
        names: Sequence[str] | None = None,
    ) -> Self:
        """A map of one route in a new folder, as of `create` and `add`.

        Raises
        ------
        InputError
            As of `create` and `add`.
        """
        return cls(_made(Path(folder), about, [new_places(about, descriptors, times, positions, names)]))

    @classmethod
    def open(cls, folder: str | os.PathLike[str]) -> Self:
        """The map in a folder.

        Raises
        ------
        InputError
            If there is none, it is damaged, or it was made by a newer version of insectnav.
        """
        return cls(Path(folder))

    def _read(self) -> None:
        record = read_record(self.path)
        while True:
            try:
                self._segments = self._read_segments(record)
                break
            except DamagedError:
                before, record = record, read_record(self.path)
                if record == before:  # else another process has frozen the map in the meantime
                    raise
        self._record, self.about = record, record.about
        self._whole, self._compared, self._searched = None, None, None

    def _read_segments(self, record: MapRecord) -> Segments:
        if record.places is None:
            return read_segments(self.path, record.about, self._segments)
        return {record.places: read_places(self.path / record.places, record.about)}

    @property
    def places(self) -> PlaceArrays:
        """All places, in the form in which they are stored."""
        if self._whole is None:
            parts = list(self._segments.values())
            self._whole = joined(parts) if parts else no_places(self.about)
        return self._whole

    @property
    def is_frozen(self) -> bool:
        """Whether nothing can be added any more."""
        return self._record.places is not None

    @property
    def n_places(self) -> int:
        """Number of places."""
        return sum(len(part.times) for part in self._segments.values())

    @property
    def descriptors(self) -> NDArray[Any]:
        """Descriptors, (place, feature) array of the type that was given; NaN for missing frames."""
        return self.places.descriptors()

    @property
    def times(self) -> Reals:
        """When the frames were taken, (place,) array [s]; NaN unknown."""
        return self.places.times

    @property
    def positions(self) -> Reals:
        """Where, (place, 3) array [m], x east, y north, z up; NaN unknown."""
        return self.places.positions

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the frames; empty words where they have none."""
        return self.places.names()

    @property
    def routes(self) -> Integers:
        """Number of the traverse of each place, (place,) array from 0; no line runs from one into the next."""
        return self.places.routes

    def add(
        self,
        descriptors: ArrayLike,
        *,
        times: ArrayLike | None = None,
        positions: ArrayLike | None = None,
        names: Sequence[str] | None = None,
        new_route: bool = False,
    ) -> None:
        """Put more places at the end; they are on disk, and stay whatever happens then, once this returns.

        Parameters
        ----------
        descriptors : (place, feature) array
            In the order in which they were taken; a row of NaN for a frame that is missing.
        times : (place,) array [s]
            NaN where unknown.
        positions : (place, 3) array [m]
            x east, y north, z up; NaN where unknown.
        names : of the frames
        new_route : whether another traverse begins: lines do not run into it from the places before

        Raises
        ------
        InputError
            If the map is frozen or written by another, the descriptors are not of its kind, or the disk is full.
        """
        places = new_places(self.about, descriptors, times, positions, names)
        with only_writer(self.path):
            self._read()
            if self.is_frozen:
                raise InputError(f"the map {shown(self.path)} is frozen, expected one that can be added to")
            last = next(reversed(self._segments.values()), None)
            self._segments = add_segment(self.path, self.about, self._segments, _following(places, last, new_route))
            self._whole, self._compared = None, None

    def freeze(self, *, index: bool = True) -> None:
        """Put all places side by side for good, with an index for large maps; nothing can be added afterwards.

        Parameters
        ----------
        index : whether to make one; of a frozen map it is made anew. There is none for bits

        Raises
        ------
        InputError
            If the map is empty, frozen or written by another, the disk is full, or FAISS is not installed.
        """
        with only_writer(self.path):
            self._read()
            if not self.n_places or (self.is_frozen and not index):
                state = "frozen" if self.is_frozen else "empty"
                raise InputError(f"the map {shown(self.path)} is {state}, expected one with places, not yet frozen")
            frozen(self.path, self._record, self.places, index)
            self._read()

    def locate(
        self,
        descriptors: ArrayLike,
        params: SeqSlamParams | None = None,
        *,
        about: MapAbout | None = None,
        search: str = "auto",
        workers: int | None = None,
        cluster: Any = None,
    ) -> Matches:
        """The place that each query matches best, with the frames before and after it.

        Parameters
        ----------
        descriptors : (query, feature) array
            In the order in which they were taken; a row of NaN for a frame that is missing.
        params : SeqSlamParams
        about : of the queries; refused if they were described in another way than the map
        search : "exact" compares with all places, "index" with those that an index proposes, which frozen maps have;
            "auto" takes the index where there is one and the map has more than 60 000 places
        workers : threads; they change nothing in the results
        cluster : address or client of a Dask cluster, whose workers compare with all places and see the folder

        Returns
        -------
        Matches
            The reference is the number of the place.

        Raises
        ------
        InputError
            If the queries are not of the map's kind, or the map has no index to search with.
        """
        check_choice("search", search, SEARCHES)
        params = params or SeqSlamParams()
        if about is not None:
            self.about.check_same(about, "the queries")
        landscape = self._landscape()
        queries = checked_queries(landscape, descriptors)
        params.check_length(len(queries), "query", "queries")
        check_routes(np.asarray(landscape.places.routes), params)
        if cluster is not None:
            if search == "index" or workers is not None:
                raise InputError("a cluster searches a map without its index, with workers of its own: give it alone")
            return cluster_matches(self.path, self._record, landscape, queries, params, cluster)
        if (found := self._index(search)) is not None:
            return indexed_matches(landscape, found, queries, params, workers)
        return exact_matches(landscape, queries, params, workers)

    def stream(self, params: SeqSlamParams | None = None, *, search: str = "auto") -> MapStream:
        """A search on the move before its first frame; carried on by its `locate_next`.

        Parameters
        ----------
        params : SeqSlamParams
        search : as of `locate`

        Raises
        ------
        InputError
            If the map is empty, or has no index to search with.
        """
        check_choice("search", search, SEARCHES)
        return begin_map_stream(self._landscape(), params or SeqSlamParams(), self._index(search))

    def _index(self, search: str) -> PlaceIndex | None:
        """The index, if it is to be used."""
        record = self._record.index
        if search == "exact" or (search == "auto" and (record is None or self.n_places <= EXACT_UP_TO)):
            return None
        if record is None:
            why = "freeze() makes it" if self.about.metric in METRICS_WITH_INDEX else "there is none for bits"
            raise InputError(f"the map {shown(self.path)} has no index, {why}: search='exact' needs none")
        if self._searched is None:
            folder, places = self.path / record.folder, self.places
            try:
                arrays = read_index(folder, record.digest, record.sizes, self.n_places, places.n_features)
            except (DamagedError, OSError) as error:
                raise DamagedError(
                    f"the index of the map {shown(self.path)} is damaged ({error}): search='exact' needs none, and "
                    "freeze() makes it anew"
                ) from None
            self._searched = PlaceIndex(arrays, self.about.metric, record.sizes)
        return self._searched

    def _landscape(self) -> Landscape:
        if self._compared is None:
            if not self.n_places:
                raise InputError(f"the map {shown(self.path)} is empty, expected one with places to compare with")
            self._compared = landscape_of(self.places, self.about.metric)
        return self._compared


def merge_maps(folder: str | os.PathLike[str], maps: Sequence[PlaceMap]) -> PlaceMap:
    """A map in a new folder with the places of all of these, in order; each keeps its routes, numbered anew.

    Raises
    ------
    InputError
        If they are not about the same, their origins differ, or the folder cannot be written.
    """
    if not maps:
        raise InputError("there are no maps to merge, expected at least one")
    about = maps[0].about
    parts: list[PlaceArrays] = []
    for other in maps:
        about.check_same(other.about, f"the map {shown(other.path)}")
        if other.about.origin_deg != about.origin_deg:
            raise InputError(
                f"origin_deg of the map {shown(other.path)} is {other.about.origin_deg}, expected {about.origin_deg} "
                f"as of {shown(maps[0].path)}: positions from one origin?"
            )
        if other.n_places:
            parts.append(_following(other.places, parts[-1] if parts else None, True))
    return PlaceMap(_made(Path(folder), about, parts))


def _following(places: PlaceArrays, last: PlaceArrays | None, new_route: bool) -> PlaceArrays:
    """Places with the numbers of their routes after those before; refused if the kinds of descriptors differ."""
    if last is None:
        return places
    if places.kind != last.kind:
        raise InputError(
            f"descriptors are {places.kind}, expected {last.kind} as those in the map: "
            f"descriptors.astype(numpy.{last.kind})?"
        )
    return replace(places, routes=places.routes - places.routes[0] + last.routes[-1] + int(new_route))


def _made(folder: Path, about: MapAbout, parts: Sequence[PlaceArrays]) -> Path:
    """A new folder with these places, whole or not at all."""
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(f"{shown(folder)} exists, expected a new or empty folder for the map")
    with written(folder), whole_folder(folder) as temporary:
        segments: Segments = {}
        (temporary / SEGMENTS).mkdir()
        for part in parts:
            segments = add_segment(temporary, about, segments, part)
        write_record(temporary, MapRecord(about=about))
    return folder
