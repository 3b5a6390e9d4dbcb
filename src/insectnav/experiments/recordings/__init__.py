"""Recordings that others have made: how well places are recognised in them, where the data are at hand.

The recordings of chapters 3 and 4 of T. Stone's thesis are not public. These are others, so that no number here can
agree or differ with a published one, but for claims that hold for any recording. `docs/place-recognition-results.md`
says where they are from.
"""

PAPER = "other recordings"
