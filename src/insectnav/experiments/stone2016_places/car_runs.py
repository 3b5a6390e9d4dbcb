"""What Figs 8 and 9 share: two passages of a remote-controlled car, and the methods that recognise its places."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge, with_error
from insectnav.experiments.stone2016_places.claims import (
    NONE,
    OTHER_SITE,
    PRECISION,
    WHOLE,
    claimed,
    of_answer,
    of_frames,
    sections_of_track,
)
from insectnav.experiments.stone2016_places.frames import FULL_SIZE, Section, keep, sections
from insectnav.experiments.stone2016_places.panels import draw_correspondence, draw_curve, draw_frame
from insectnav.experiments.stone2016_places.passages import (
    SECONDS_APART,
    SITE_SEEDS,
    drawn_as,
    ground_of,
    whole_or_why_not,
)
from insectnav.experiments.stone2016_places.recognition import (
    FABMAP,
    NEUTRAL,
    PLAIN,
    POINTS,
    ROTATION,
    ROTATION_LOCAL,
    SINGLE,
    SKY,
    SKY_WHOLE,
    TRUE,
    VANILLA,
    WATERSHED,
    Recognised,
    by_rotation,
    differences,
    in_sequences,
    passage_pair,
    truth_between,
    turned_apart,
    varied,
)
from insectnav.experiments.stone2016_places.sites import BMX, SITES, YARD, Ground
from insectnav.matching.chow_liu import chow_liu_tree
from insectnav.matching.fabmap import fabmap
from insectnav.matching.visual_words import build_vocabulary

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BOTH = 0, 1  # passages
VARIATIONS = {"as driven": BOTH, "1 m aside": (0, 2)}  # that are compared over the first part of the way
VARIED_FRAMES = 200  # of each
LENGTHS = (1, 10, 20)  # [frame] of sequences
TRAINING_SEED = 100  # added to that of a site: another place of the same kind
N_TRAINING = 150  # frames of a training passage, evenly along the way
N_WORDS = {"full": 1000, "quick": 60}  # of FAB-MAP's vocabulary, assumed
BLUR = "share right with motion blur less without, sky"
UNTESTED = {BLUR: "frames are rendered at an instant: no passage with motion blur is there to compare with"}


def cells_of(site: str, scale: str) -> list[Section]:
    """Both passages of a site, and training passages of both kinds of site; at quick scale the beginning of each.

    On the disposal site "all algorithms performed worse": at full scale both passages of the BMX track are there, too.
    """
    full = scale == "full"
    how: dict[str, Any] = {"size": FULL_SIZE, "supersampling": 2} if full else {"size": 96, "supersampling": 1}
    each, stretch = (50, 1.0) if full else (40, 0.05)
    found = []
    for number, share in ((0, stretch), (1, stretch), (2, min(stretch, VARIED_FRAMES / SITES[site].n_frames))):
        time_s = SECONDS_APART * drawn_as(site, number)
        found += sections(site, number, seed=SITE_SEEDS[site], stretch=share, each=each, time_s=time_s, **how)
    for number in BOTH if full and site == YARD.name else ():
        time_s = SECONDS_APART * drawn_as(BMX.name, number)
        found += sections(BMX.name, number, seed=SITE_SEEDS[BMX.name], stretch=1.0, each=each, time_s=time_s, **how)
    for other in (BMX.name, YARD.name) if full else (site,):
        seed, n = SITE_SEEDS[other] + TRAINING_SEED, N_TRAINING if full else each
        found += [
            Section(site=other, site_seed=seed, time_s=0.0, passage=0, first=first, n_frames=each, of_frames=n, **how)
            for first in range(0, n, each)
        ]
    return found


def simulate(cell: Section, seed: int) -> Arrays:
    """What the methods compare, of each frame, and the grey pictures for FAB-MAP."""
    return keep(cell, seed, with_pictures=True)


@lru_cache(maxsize=1)
def recognised(results: Results) -> dict[tuple[str, int], Recognised]:
    """Answers of each method and length of sequence."""
    cell = results.cells[0]
    reference, query = passage_pair(results, BOTH)
    truth = truth_between(reference, query)
    answers = {(FABMAP, 1): _by_words(results, reference["pictures"], query["pictures"], truth)}
    compared = (VANILLA, NEUTRAL, SKY, POINTS, TRUE, PLAIN, WATERSHED)
    matrices = {method: differences(reference, query, method) for method in compared}
    for method, matrix in matrices.items():
        answers |= {(method, length): in_sequences(matrix, truth, length) for length in LENGTHS}
    found = by_rotation(reference, query, truth, cell.size)
    answers[SINGLE, 1] = found.single
    for length in LENGTHS:
        answers[ROTATION, length] = in_sequences(found.matrix, truth, length, whole_contrast=True)
        answers[ROTATION_LOCAL, length] = in_sequences(found.matrix, truth, length)
        answers[SKY_WHOLE, length] = in_sequences(matrices[SKY], truth, length, whole_contrast=True)
    return answers


def _on_other_site(results: Results) -> dict[tuple[str, int], Recognised]:
    """Answers on the BMX track, where its passages are there besides those of the site."""
    if BMX.name == results.cells[0].site or not len(results.where(site_seed=SITE_SEEDS[BMX.name])):
        return {}
    reference, query = passage_pair(results, BOTH, site=BMX.name)
    truth = truth_between(reference, query)
    return {(FABMAP, 1): _by_words(results, reference["pictures"], query["pictures"], truth)} | {
        (method, 10): in_sequences(differences(reference, query, method), truth) for method in (VANILLA, SKY)
    }


def _by_words(results: Results, reference: NDArray[Any], query: NDArray[Any], truth: NDArray[Any]) -> Recognised:
    """FAB-MAP 2.0, with a vocabulary of the training passages."""
    trained = [k for k, cell in enumerate(results.cells) if cell.site_seed != SITE_SEEDS[cell.site]]
    pictures = np.concatenate(list(results["pictures"][trained]))
    scale = "full" if results.cells[0].size == FULL_SIZE else "quick"
    vocabulary = build_vocabulary(pictures, N_WORDS[scale])
    tree = chow_liu_tree(vocabulary.bags(pictures))
    found = fabmap(vocabulary.bags(reference), vocabulary.bags(query), tree)
    return Recognised(reference=found.reference, score=found.score, truth=truth)


def summarise(results: Results) -> Table:
    """A row for each method and length of sequence, for each second passage over the first part of the way, and more.

    The last are those of the BMX track, where its passages are there besides those of the site.
    """
    cell, answers = results.cells[0], recognised(results)
    reference, query = passage_pair(results, BOTH)
    turned = turned_apart(reference, query, truth_between(reference, query))
    ground, is_track = ground_of(*cell.place), cell.site == BMX.name
    accuracy = float(np.concatenate([reference["accuracy"], query["accuracy"]]).mean())
    seen = of_frames(query, ground, is_track=is_track)
    rows = [
        _row(cell.site, method, length, WHOLE, answer, accuracy)
        | {
            "median_precision": median_precision(answer),
            "in_right_section": in_right_section(answer, reference["distance"], ground) if is_track else NONE,
        }
        | of_answer(answer, answers[SKY, 10], query, ground, turned, is_track=is_track)
        | seen
        for (method, length), answer in answers.items()
    ]
    others = [
        _row(cell.site, method, 1 if method == SINGLE else 10, name, answer, accuracy)
        for (name, method), answer in varied(results, VARIATIONS, VARIED_FRAMES).items()
    ] + [
        _row(BMX.name, method, length, OTHER_SITE, answer, NONE)
        for (method, length), answer in _on_other_site(results).items()
    ]
    return rows + [dict.fromkeys(rows[0], NONE) | row for row in others]


def _row(site: str, method: str, length: int, part: str, answer: Recognised, accuracy: float) -> dict[str, Any]:
    return {
        "site": site,
        "method": method,
        "sequence_length": length,
        "passages": part,
        "kind": "rendered",
        "n_frames": len(answer.score),
        "n": int(np.isfinite(answer.score).sum()),
        **answer.findings(),
        "sky_labelled_right": accuracy,
    }


def in_right_section(answer: Recognised, reference_distance: NDArray[Any], ground: Ground) -> float:
    """Share of the matches [%] that lie in the same of the three sections of the BMX track as the truth."""
    section = sections_of_track(reference_distance, ground)
    known = answer.reference >= 0
    true = section[np.rint(answer.truth[known]).astype(int)]
    return 100.0 * float((section[answer.reference[known]] == true).mean())


def median_precision(answer: Recognised) -> float:
    """Median precision over the recall that a method reaches [%], weighed by recall; 0 if no match is right."""
    curve = answer.curve
    steps = np.diff(curve.recall, prepend=0.0)
    if not steps.sum() > 0.0:
        return 0.0
    order = np.argsort(curve.precision, kind="stable")
    share = np.cumsum(steps[order]) / steps.sum()
    return 100.0 * float(curve.precision[order][np.searchsorted(share, 0.5)])


def draw(results: Results) -> Figure:
    """Pictures of both passages, correspondences of four methods, precision over recall."""
    from matplotlib.figure import Figure

    answers = recognised(results)
    figure = Figure(figsize=(DOUBLE_COLUMN, 5.6), layout="constrained")
    parts: Any = figure.subfigures(2, 1, height_ratios=(1.25, 4.2))
    _draw_examples(parts[0], results)
    panels = parts[1].subplot_mosaic([["b", "c", "f"], ["d", "e", "f"]], width_ratios=(1.0, 1.0, 1.15))
    shown = {"b": (FABMAP, 1), "c": (VANILLA, 10), "d": (SKY, 10), "e": (SINGLE, 1)}
    for letter, key in shown.items():
        draw_correspondence(panels[letter], answers[key])
        name_panel(panels[letter], letter, key[0].removesuffix(", single frames"))
        if letter in "bd":
            panels[letter].set_ylabel("reference frame")
        if letter in "de":
            panels[letter].set_xlabel("query frame")
    curves = (
        ((FABMAP, 1), "purple", "-", FABMAP),
        ((VANILLA, 10), "red", "-", VANILLA),
        ((SKY_WHOLE, 1), "blue", "--", "sky, single frames"),
        ((SKY, 10), "blue", "-", "SeqSLAM (sky), w = 10"),
        ((SKY, 20), "blue", ":", "SeqSLAM (sky), w = 20"),
        ((SINGLE, 1), "green", "--", SINGLE),
        ((ROTATION, 10), "green", "-", f"{ROTATION}, w = 10"),
    )
    closer = panels["f"].inset_axes((0.4, 0.42, 0.58, 0.34))
    for key, colour, style, label in curves:
        draw_curve(panels["f"], answers[key], COLOURS[colour], label, style)
        draw_curve(closer, answers[key], COLOURS[colour], "", style)
    closer.set(xlim=(40.0, 100.5), ylim=(95.0, 100.3))
    panels["f"].indicate_inset_zoom(closer, edgecolor=COLOURS["grey"], linewidth=0.5)
    name_panel(panels["f"], "f", "precision and recall")
    panels["f"].set_xlabel("recall (%)")
    panels["f"].set_ylabel("precision (%)")
    parts[1].legend(loc="outside lower center", ncols=4)
    return figure


def _draw_examples(part: Any, results: Results) -> None:
    """Three places along the way as both cameras saw them on the second passage."""
    cell = results.cells[0]
    cells = results.where(site_seed=SITE_SEEDS[cell.site], passage=1)
    chosen = [cells[int(share * (len(cells) - 1))] for share in (0.15, 0.55, 0.9)]
    panels = part.subplots(1, 6)
    for k, place in enumerate(chosen):
        along = results["distance"][place][results.cells[place].n_frames // 2]
        for j, name in enumerate(("visible", "uv")):
            axes = panels[2 * k + j]
            draw_frame(axes, results[f"shown_{name}"][place])
            axes.set_title(f"{name.replace('uv', 'UV')}, {along:.0f} m", loc="left")
    along = results["distance"][chosen[0]][cell.n_frames // 2]
    name_panel(panels[0], "a", f"visible, {along:.0f} m")


def caption(results: Results, made_of: str) -> str:
    """What the figure shows."""
    cell = results.cells[0]
    cells = results.where(site_seed=SITE_SEEDS[cell.site], passage=0)
    n = len(cells) * cell.n_frames
    n_training = sum(c.n_frames for c in results.cells if c.site_seed != SITE_SEEDS[c.site])
    length = SITES[cell.site].length * n / cell.of_frames
    return (
        f"Rendered, no photographs: {length:.0f} m of {made_of}, two passages of n = {n} frames on two days, with "
        "lane, sway, speed, light and clouds of their own. (a) Three places as both cameras see them. (b–e) Matches; "
        "green: within 5 frames of the truth, red: farther off; line: truth. FAB-MAP and rotation matching take single "
        f"frames, SeqSLAM sequences of 10; FAB-MAP's vocabulary is of {n_training} frames of other rendered sites. "
        "(f) Precision over recall, and its upper right corner larger; w is the length of the sequences. Contrast is "
        "that of the ten neighbouring references, but for the sky in single frames, the nearest frame, and for "
        "sequences of rotation matching: over all references."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Each published number of a figure beside ours."""
    rows, there = (
        {(row["method"], row["sequence_length"]): row for row in table if row["passages"] == part}
        for part in (WHOLE, OTHER_SITE)
    )
    why = _why(rows, [row for row in table if row["passages"] in VARIATIONS])
    names = {"vanilla": (VANILLA, 10), "FAB-MAP": (FABMAP, 1)} | {
        "sky": (SKY, 10), "sky, w = 20": (SKY, 20), "sky, single images": (SKY_WHOLE, 1)
    }  # fmt: skip
    columns = {
        "recall at full precision": "recall_at_full_precision",
        "precision at full recall": PRECISION,
    }
    sky = rows[SKY, 10]
    part = whole_or_why_not(SITES[sky["site"]], sky["n_frames"])
    claims = claimed(rows, there) | dict.fromkeys(UNTESTED, (NONE, 0.0))
    verdicts = []
    for value in published.values():
        if value.quantity in claims:
            ours = claims[value.quantity]
        else:
            what, _, who = value.quantity.partition(", ")
            row = rows[names[who]]
            ours = with_error(row, columns[what])
        verdicts.append(judge(value, *ours, why=why, not_comparable=UNTESTED.get(value.quantity, part)))
    return verdicts


def _why(rows: Mapping[tuple[str, int], Mapping[str, Any]], varied_rows: Sequence[Mapping[str, Any]]) -> str:
    """What was measured of the causes: lane, orientation, exact masks, contrast, and matching in the overlap alone."""
    parts = [
        f"{method} (w = {w}) {rows[method, w][PRECISION]:.0f}"
        for w, methods in ((10, (TRUE, PLAIN, WATERSHED, SKY_WHOLE, POINTS, NEUTRAL)), (1, (SKY, SINGLE)))
        for method in methods
    ]
    vanilla, sky = rows[VANILLA, 10], rows[SKY, 10]
    sunlit = sky["mislabelled_where_sunlit"]
    turned = [
        f"{name} {row['right_where_turned_least']:.0f} and {row['right_where_turned_most']:.0f}"
        for name, row in (("vanilla", vanilla), ("sky", sky))
    ]
    lanes = [
        f"{row['method']}, {row['passages']} {row[PRECISION]:.0f}" for row in varied_rows if row["method"] != VANILLA
    ]
    return (
        f"rendered, another place; right in percent in the thirds of the frames whose cameras are turned apart least "
        f"and most: {', '.join(turned)}; sky labelled right in {sky['sky_labelled_right']:.1f} % of the pixels, "
        f"wrong in {sunlit:.2f} % where the sun shines in ({sunlit - sky['mislabelled_by_flare']:.2f} % without the "
        f"lens flare, which is assumed), in {sky['mislabelled_in_shade']:.2f} % in the shade; "
        f"precision at full recall in percent of {', '.join(parts)}; over the first part of the way: {'; '.join(lanes)}"
    )
