"""Figures drawn by a process of their own, while the simulation goes on.

Loading the plotting library takes longer than most simulations; here it happens at the same time.
"""

import gc
import io
import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

if TYPE_CHECKING:
    from matplotlib.figure import Figure


HOME_FIGURE = "insectnav.experiments.home_figure"


class FigureProcess:
    """A Python process that waits for data on its standard input, draws them and leaves figures in a folder.

    Parameters
    ----------
    module : str
        Name of a module that ends with ``serve(draw)`` under ``if __name__ == "__main__"``.
    """

    def __init__(self, module: str) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", module],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        )

    def draw(self, data: Mapping[str, Any], folder: Path) -> None:
        """Hand over the data, arrays, numbers or text by name; ``figure.png`` and ``figure.pdf`` go to the folder."""
        import numpy as np

        buffer = io.BytesIO()
        np.savez(buffer, allow_pickle=False, **{name: np.asarray(value) for name, value in data.items()})
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(os.fsencode(folder.absolute()) + b"\0")
            self._process.stdin.write(buffer.getbuffer())
            self._process.stdin.close()
        except BrokenPipeError:  # it ended early: `finish` says why
            pass
        self._process.stdin = None

    def finish(self) -> None:
        """Wait for the figures.

        Raises
        ------
        RuntimeError
            If drawing failed, with what the process said.
        """
        _, complaint = self._process.communicate()
        if self._process.returncode != 0:
            raise RuntimeError(f"the figure could not be drawn:\n{complaint.decode(errors='replace')}")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._process.kill()  # does nothing to a process that has ended
        self._process.wait()
        for stream in (self._process.stdin, self._process.stderr):
            if stream is not None:
                stream.close()


def serve(draw: Callable[[Mapping[str, Any]], "Figure"]) -> None:
    """Read a folder and data from standard input and leave their figure there."""
    gc.disable()  # a short life: collecting garbage would take a fifth of it
    import matplotlib.backends.backend_agg
    import matplotlib.backends.backend_pdf  # noqa: F401  all that drawing takes, while the simulation runs
    import numpy as np
    from fontTools import subset

    from insectnav.experiments.figures import save_figure

    # Kerning and ligatures are settled when text is drawn; to carry their tables over to the PDF takes half its time.
    drop_tables: list[str] = getattr(subset.Options, "_drop_tables_default", [])
    drop_tables += ["GDEF", "GPOS", "GSUB"]
    _warm_up()
    folder, _, content = sys.stdin.buffer.read().partition(b"\0")
    with np.load(io.BytesIO(content), allow_pickle=False) as data:
        figure = draw({name: data[name][()] for name in data.files})
    _in_parallel(lambda kind: save_figure(figure, Path(os.fsdecode(folder)), kinds=(kind,)), "png", "pdf")
    os._exit(0)  # the figures are written; taking the interpreter apart would only take time


def _warm_up() -> None:
    """Draw a figure of no use, so that fonts and writers are ready when the data come."""
    from matplotlib.figure import Figure

    from insectnav.experiments.figures import journal_style

    with journal_style():
        figure = Figure(figsize=(1.0, 1.0))
        figure.add_subplot().set_title("0")
        for kind in ("png", "pdf"):
            figure.savefig(io.BytesIO(), format=kind)


def _in_parallel(work: Callable[[str], None], first: str, second: str) -> None:
    """Do two pieces of work, at the same time where a process can safely be forked."""
    if sys.platform != "linux":
        work(first)
        work(second)
    elif (other := os.fork()) == 0:
        work(second)
        os._exit(0)
    else:
        work(first)
        if os.waitpid(other, 0)[1] != 0:
            raise RuntimeError(f"the {second} could not be written")
