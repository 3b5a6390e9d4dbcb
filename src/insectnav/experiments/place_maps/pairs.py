"""Which queries are shown beside their matches: the best, the middle, the worst, and those that are wrong."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from insectnav.experiments.place_maps.located import Located
from insectnav.experiments.place_maps.thumbnails import picture_of
from insectnav.experiments.place_maps.truth import quantity

N_WRONG = 3  # shown at most
NOTHING: tuple[bytes, tuple[int, int]] = (b"", (0, 0))


@dataclass(frozen=True, kw_only=True)
class Pair:
    """A query and its match: JPEGs with (columns, rows), what they are and how they fit."""

    kind: str  # "right", "wrong" or ""
    title: str
    caption: str
    query: tuple[bytes, tuple[int, int]]
    match: tuple[bytes, tuple[int, int]]


def chosen_pairs(found: Located) -> list[tuple[str, int]]:
    """Titles and numbers of queries worth looking at, each but once.

    Parameters
    ----------
    found : Located
    """
    truth, kept = found.truth, found.is_kept
    right = kept if truth is None else kept & truth.is_right
    word = "match" if truth is None else "right match"
    by_score = np.flatnonzero(right)[np.argsort(found.score[right], kind="stable")]
    chosen: dict[int, str] = {}
    if by_score.size:
        for title, place in ((f"Best {word}", 0), (f"Median {word}", len(by_score) // 2), (f"Worst {word}", -1)):
            chosen.setdefault(int(by_score[place]), title)
    if truth is not None:
        wrong = kept & truth.is_known & ~truth.is_right
        by_score = np.flatnonzero(wrong)[np.argsort(found.score[wrong], kind="stable")]
        for query in by_score[:N_WRONG].tolist():
            chosen[query] = "Wrong match, of the best scores"
    return [(title, query) for query, title in chosen.items()]


def shown_pairs(found: Located, queries: Mapping[int, bytes], places: Mapping[int, bytes]) -> list[Pair]:
    """Pairs of which there are pictures.

    Parameters
    ----------
    found : Located
    queries, places : small JPEGs by number
    """
    pairs = []
    for title, query in chosen_pairs(found):
        place = int(found.reference[query])
        pictures = [_checked(queries.get(query, b"")), _checked(places.get(place, b""))]
        if not any(data for data, _ in pictures):
            continue
        kind = "" if found.truth is None else "right" if found.truth.is_right[query] else "wrong"
        pairs.append(
            Pair(kind=kind, title=title, caption=_caption(found, query, place), query=pictures[0], match=pictures[1])
        )
    return pairs


def _checked(data: bytes) -> tuple[bytes, tuple[int, int]]:
    """A JPEG and its columns and rows; nothing if it is none."""
    picture = picture_of(data)
    return NOTHING if picture is None else (data, (picture.shape[1], picture.shape[0]))


def _caption(found: Located, query: int, place: int) -> str:
    own, other = (names[k] for names, k in ((found.names, query), (found.place_names, place)))
    text = f"Query {query}{_named(own)}, place {place}{_named(other)}; score {found.score[query]:.2f}"
    if found.truth is not None and np.isfinite(found.truth.error[query]):
        text += f", {quantity(found.truth.error[query], found.truth.unit)} off"
    return text


def _named(name: str) -> str:
    return f" ({name})" if name else ""
