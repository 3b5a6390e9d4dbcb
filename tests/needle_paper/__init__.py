"""A paper with one figure, π by throwing a needle, small enough to be run again in a test."""

PAPER = "Buffon 1777"
