"""GrowCut as the paper gives it, cell by cell and step by step: slow, plain, and unlike the package's own way."""

import math

import numpy as np

VON_NEUMANN = ((0, -1), (0, 1), (-1, 0), (1, 0))
MOORE = (*VON_NEUMANN, (-1, -1), (-1, 1), (1, -1), (1, 1))


def as_bands(image: np.ndarray) -> np.ndarray:
    return np.atleast_3d(image).astype(float)


def similarity(image: np.ndarray) -> np.ndarray:
    """g of the step from each pixel to its neighbour on the side of each offset of MOORE, (offset, rows, columns); 0
    beyond the edge.
    """
    colours = as_bands(image)
    greatest = np.sqrt((colours**2).sum(axis=-1)).max() or 1.0
    apart = [np.linalg.norm(colours - moved(colours, offset), axis=-1) for offset in MOORE]
    inside = [moved(np.ones(colours.shape[:2]), offset) for offset in MOORE]
    return np.array([np.maximum(1.0 - x / greatest, 0.0) * i for x, i in zip(apart, inside, strict=True)])


def moved(array: np.ndarray, offset: tuple[int, int]) -> np.ndarray:
    """Value of each cell's neighbour on the side of the offset, 0 beyond the edge."""
    rows, columns = array.shape[:2]
    wide = np.zeros((rows + 2, columns + 2, *array.shape[2:]), array.dtype)
    wide[1:-1, 1:-1] = array
    return wide[1 + offset[0] : 1 + offset[0] + rows, 1 + offset[1] : 1 + offset[1] + columns]


def published_automaton(
    image: np.ndarray, strokes: np.ndarray, offsets: tuple = MOORE, seed_strength: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """The pseudo-code of the paper: of several who win in one step, the last in the order of neighbours stays."""
    g = similarity(image)
    rows, columns = strokes.shape
    labels, strength = strokes.copy(), np.where(strokes > 0, seed_strength, 0.0)
    changes = True
    while changes:
        changes = False
        new_labels, new_strength = labels.copy(), strength.copy()
        for r in range(rows):
            for c in range(columns):
                for k, (dr, dc) in enumerate(offsets):
                    if not (0 <= r + dr < rows and 0 <= c + dc < columns):
                        continue
                    attack = g[k, r, c] * strength[r + dr, c + dc]
                    if attack > strength[r, c]:
                        new_labels[r, c], new_strength[r, c] = labels[r + dr, c + dc], attack
                        changes = True
        labels, strength = new_labels, new_strength
    return labels, strength


def array_automaton(
    image: np.ndarray, strokes: np.ndarray, offsets: tuple = MOORE, g: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray, int]:
    """The same on whole arrays; of several who win in one step the strongest stays. Also the number of steps."""
    g = similarity(image) if g is None else g
    labels, strength, n_steps = strokes.copy(), (strokes > 0).astype(float), 0
    while True:
        new_labels, new_strength = labels.copy(), strength.copy()
        for k, offset in enumerate(offsets):
            attack = g[k] * moved(strength, offset)
            wins = attack > new_strength
            new_labels[wins], new_strength[wins] = moved(labels, offset)[wins], attack[wins]
        if np.array_equal(new_strength, strength):
            return labels, strength, n_steps
        labels, strength, n_steps = new_labels, new_strength, n_steps + 1


def exact_automaton(image: np.ndarray, strokes: np.ndarray, offsets: tuple = MOORE) -> tuple[np.ndarray, np.ndarray]:
    """Labels and −log strengths in whole units, which add up without rounding: equally strong is exactly so.

    Of several who win in one step the strongest stays, and of those the lowest label.
    """
    nothing = 2**62
    g = similarity(image)
    rows, columns = strokes.shape
    labels, length = strokes.copy(), np.where(strokes > 0, 0, nothing).astype(object)
    changes = True
    while changes:
        changes = False
        new_labels, new_length = labels.copy(), length.copy()
        for r, c in np.ndindex(rows, columns):
            attacks = []
            for k, (dr, dc) in enumerate(offsets):
                inside = 0 <= r + dr < rows and 0 <= c + dc < columns
                if inside and labels[r + dr, c + dc] and g[k, r, c] > 0.0:
                    attack = length[r + dr, c + dc] + int(0.5 - 2.0**36 * math.log(g[k, r, c]))
                    attacks.append((attack, labels[r + dr, c + dc]))
            if attacks and min(attacks)[0] < length[r, c]:
                new_length[r, c], new_labels[r, c] = min(attacks)
                changes = True
        labels, length = new_labels, new_length
    return labels, length
