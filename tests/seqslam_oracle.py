"""SeqSLAM, plainly: each step as its equation says, one frame, one place and one speed at a time.

After Milford & Wyeth 2012, doi 10.1109/ICRA.2012.6224623, in the form of OpenSeqSLAM v1. To compare answers and times
with; it shares nothing with the package.
"""

from fractions import Fraction

import numpy as np


def patch_normalise(image, side=8, flat_patch=0):
    """An image (rows, columns) as bytes, each patch less its mean over its standard deviation."""
    out = np.zeros(image.shape, np.uint8)
    for top in range(0, image.shape[0], side):
        for left in range(0, image.shape[1], side):
            patch = image[top : top + side, left : left + side].astype(np.float64)
            deviation = np.std(patch, ddof=1)
            here = np.full(patch.shape, float(flat_patch))
            if deviation > 0:
                scaled = (patch - np.mean(patch)) / deviation
                here = 127 + np.sign(scaled) * np.floor(np.abs(scaled) + 0.5)
            out[top : top + side, left : left + side] = here
    return out


def difference(references, queries):
    """Sum of absolute differences over the number of references, (reference, query)."""
    n = len(references)
    matrix = np.empty((n, len(queries)))
    for j, query in enumerate(queries):
        for i, reference in enumerate(references):
            matrix[i, j] = np.sum(np.abs(reference.astype(np.int64) - query.astype(np.int64))) / n
    return matrix


def enhance(matrix, window=10):
    """Each value less the mean of its neighbours on the reference axis, over their standard deviation."""
    n = len(matrix)
    out = np.empty(matrix.shape)
    for i in range(n):
        near = matrix[max(0, i - window // 2) : min(n, i + window // 2 + 1)]
        out[i] = (matrix[i] - np.mean(near, axis=0)) / np.std(near, axis=0, ddof=1)
    return out - np.min(out)


def search(enhanced, sequence_length=10, window=10, slowest=0.8, fastest=1.2):
    """Reference and score of each query, NaN where its sequence is not whole."""
    n_references, n_queries = enhanced.shape
    ds = sequence_length // 2 * 2
    found = np.full((n_queries, 2), np.nan)
    slow, fast = (Fraction(str(speed)) for speed in (slowest, fastest))
    moves = [slow * ds + step for step in range(1000) if slow * ds + step <= fast * ds]
    lines = [[int(move * k // ds) for k in range(ds + 1)] for move in moves]
    for query in range(ds // 2, n_queries - ds // 2):
        columns = query - ds // 2 + np.arange(ds + 1)
        score = np.empty(n_references)
        for start in range(n_references):
            least = np.inf
            for line in lines:
                total = 0.0
                for k in range(ds + 1):
                    row = start + line[k]
                    total += enhanced[row, columns[k]] if row < n_references else np.inf
                least = min(least, total)
            score[start] = least
        best = int(np.argmin(score))
        outside = [s for s in range(n_references) if abs(s - best) > window // 2]
        found[query] = best + ds // 2, score[best] / min(score[outside])
    return found
