"""The command line: how the program starts and ends. What it does is in `insectnav.cli.commands`."""

import gc
import io
import os
import signal
import sys
from contextlib import suppress

TERMINATED = 143  # exit code, as of shells


def main(figure: object = None) -> None:
    """Run the command line and leave with its exit code.

    Parameters
    ----------
    figure : FigureProcess, optional
        For `insectnav home`, if it has been started already.
    """
    from insectnav.cli.commands import run_command

    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # of names of files that are no UTF-8
    sys.exit(run_command(figure))


def program() -> None:
    """Run the command line as a program: `main` without what a short life does not need.

    The process that draws is started before anything is imported. Collecting garbage during the imports and taking the
    interpreter apart at the end would take a fifth of the time.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # more of them only wait for each other
    for library, level in (("OPENCV_LOG_LEVEL", "ERROR"), ("OPENCV_FFMPEG_LOGLEVEL", "-8")):
        os.environ.setdefault(library, level)  # what is wrong with a film is told in one sentence, by this program
    gc.disable()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(TERMINATED))  # so that temporary folders are removed
    try:
        if sys.argv[1:2] == ["home"] and "--help" not in sys.argv:
            from insectnav.experiments.figure_process import HOME_FIGURE, FigureProcess

            with FigureProcess(HOME_FIGURE) as figure:
                main(figure)
        main()
    except SystemExit as exit_:
        with suppress(OSError):  # a closed pipe
            sys.stdout.flush()
        sys.stderr.flush()
        os._exit(exit_.code if isinstance(exit_.code, int) else 1)
