"""A paper of the tests' own: cells that take a while, and cells that misbehave."""

PAPER = "Nobody 1900"
