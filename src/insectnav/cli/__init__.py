"""The command line: how the program starts and ends. What it does is in `insectnav.cli.commands`."""

import gc
import io
import os
import signal
import sys
import threading
from contextlib import suppress
from typing import NoReturn

INTERRUPTED, TERMINATED = 130, 143  # exit codes, as of shells; the command itself knows the first, too
PAUSE = 0.05  # [s] before an interrupt that was lost comes again


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
    _open_what_is_closed()
    _end_by_signals()
    code: object = 0
    try:
        if sys.argv[1:2] == ["home"] and "--help" not in sys.argv:
            from insectnav.experiments.figure_process import HOME_FIGURE, FigureProcess

            with FigureProcess(HOME_FIGURE) as figure:
                main(figure)
        main()
    except KeyboardInterrupt:  # before the command has begun, or after its end
        print("insectnav: interrupted", file=sys.stderr)
        code = INTERRUPTED
    except SystemExit as exit_:
        code = exit_.code
    # What was raised is gone by now, and with it what it held: a folder whose block had not quite begun is removed.
    _leave(code if isinstance(code, int) else 1)


def _open_what_is_closed() -> None:
    """Give output and complaints that the shell has closed a place to vanish; else print takes one for the other."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 (until the program ends)


def _leave(code: int) -> NoReturn:
    with suppress(OSError):  # a closed pipe
        sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def _end_by_signals() -> None:
    """Let Ctrl-C and SIGTERM raise something, so that temporary folders are removed, however often that takes.

    The compiler of kernels does not pass on what is raised while it calls Python: the signal is then sent again.
    """
    received: list[int] = []

    def end(number: int, _: object) -> NoReturn:
        received.append(number)
        if number == signal.SIGTERM:
            sys.exit(TERMINATED)
        raise KeyboardInterrupt

    def look_at_lost(lost: "sys.UnraisableHookArgs") -> None:
        if received and issubclass(lost.exc_type, KeyboardInterrupt | SystemExit):
            again = threading.Timer(PAUSE, os.kill, (os.getpid(), received[-1]))
            again.daemon = True
            again.start()
        elif not received:  # else it may be half an object, whose making was interrupted, that complains
            sys.__unraisablehook__(lost)

    sys.unraisablehook = look_at_lost
    signal.signal(signal.SIGTERM, end)
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # else it is to be ignored
        signal.signal(signal.SIGINT, end)
