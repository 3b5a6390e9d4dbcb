"""Work on blocks of frames, on several threads; how many there are changes nothing in the results."""

from insectnav.workers import run_blocks

__all__ = ["run_blocks"]
