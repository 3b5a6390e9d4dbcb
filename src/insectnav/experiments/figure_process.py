"""Figures drawn by a process of their own, while the simulation goes on.

Loading the plotting library takes longer than most simulations; here it happens at the same time.
"""

import gc
import io
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class FigureProcess:
    """A Python process that waits for data on its standard input, draws them and leaves figures in a folder.

    Parameters
    ----------
    module : str
        Name of a module that ends with ``serve(draw)`` under ``if __name__ == "__main__"``.
    folder : Path
        Where ``figure.png`` and ``figure.pdf`` go.
    """

    def __init__(self, module: str, folder: Path) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", module, str(folder)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        )

    def draw(self, data: Mapping[str, Any]) -> None:
        """Hand over the data, arrays, numbers or text by name."""
        buffer = io.BytesIO()
        np.savez(buffer, allow_pickle=False, **{name: np.asarray(value) for name, value in data.items()})
        assert self._process.stdin is not None
        try:
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
    """Read data from standard input and leave their figure in the folder named on the command line."""
    gc.disable()  # a short life: collecting garbage would take a fifth of it
    import matplotlib.backends.backend_agg
    import matplotlib.backends.backend_pdf  # noqa: F401  load both while the simulation runs

    from insectnav.experiments.figures import save_figure

    with np.load(io.BytesIO(sys.stdin.buffer.read()), allow_pickle=False) as data:
        save_figure(draw({name: data[name][()] for name in data.files}), Path(sys.argv[1]))
