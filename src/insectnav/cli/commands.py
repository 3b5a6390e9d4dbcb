"""The commands under one name, and how bad input and interruption end."""

import errno
import sys
from typing import Annotated

import typer

from insectnav.checks import InputError, quoted
from insectnav.cli.align_command import align
from insectnav.cli.experiment_commands import RunInterruptedError, list_experiments, report, run
from insectnav.cli.home_command import home
from insectnav.cli.label_command import label
from insectnav.cli.map_commands import map_app
from insectnav.cli.render_command import render
from insectnav.cli.segment_command import segment

INTERRUPTED = 130  # exit code, as of shells
REFUSALS = frozenset(  # of the system, for which the name of a file or the disk is to blame, not the program
    {errno.EACCES, errno.EPERM, errno.EROFS, errno.ENAMETOOLONG, errno.ENOSPC, errno.EDQUOT, errno.EIO}
)

app = typer.Typer(
    name="insectnav",
    help="Insect visual navigation: sky and places, homing by views, path integration.",
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


@app.callback(invoke_without_command=True)
def _commands(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and stop.")] = False,
) -> None:
    if version:
        from insectnav import __version__

        print(__version__)
        raise typer.Exit
    if context.invoked_subcommand is None:
        print(context.get_help())


app.command()(home)
app.command()(segment)
app.command("list")(list_experiments)
app.command()(run)
app.command()(report)
app.command()(render)
app.command()(label)
app.command()(align)
app.add_typer(map_app)


def run_command(figure: object = None) -> int:
    """Run what the command line asks for and return the exit code; bad input ends with one sentence on stderr and 2.

    Parameters
    ----------
    figure : FigureProcess, optional
        For `insectnav home`, if it has been started already.
    """
    try:
        code = app(standalone_mode=False, obj=figure)
    except InputError as error:
        code = _refuse(str(error))
    except OSError as error:  # that nobody foresaw
        if error.errno not in REFUSALS or error.filename is None:
            raise
        code = _refuse(f"{quoted(error.filename, 200)} cannot be used ({error.strerror})")
    except typer.TyperException as error:
        code = _refuse(error.format_message())
    except RunInterruptedError as error:
        print(f"insectnav: interrupted, finished {error.parts} are kept: add {error.option} to go on", file=sys.stderr)
        return INTERRUPTED
    except (KeyboardInterrupt, typer.Abort):
        code = INTERRUPTED
    if code == INTERRUPTED:  # which is also how typer reports it
        print("insectnav: interrupted, nothing written", file=sys.stderr)
    return code if isinstance(code, int) else 0


def _refuse(sentence: str) -> int:
    print("insectnav:", " ".join(sentence.split()), file=sys.stderr)
    return 2
