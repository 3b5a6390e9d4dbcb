"""Commands whose options stand in a table, from which the head that typer reads is made."""

import inspect
from collections.abc import Callable, Sequence
from typing import Annotated, Any

import typer

NUMBER, COUNT, TEXT, TEXTS, FLAG = float | None, int | None, str | None, list[str] | None, bool
# Name, kind, what it says in the help, the default as a person reads it, and what stands for the value.
Option = tuple[str, Any, str, str, str | None]
Argument = tuple[str, Any, str, str | None]  # name, kind, help, what stands for it


def with_table(
    command: Callable[..., None], arguments: Sequence[Argument], options: Sequence[Option]
) -> Callable[..., None]:
    """The command with the head that typer reads; dashes become underscores in the names of its keywords.

    Parameters
    ----------
    command : function of keywords
    arguments, options : in the order of the help
    """
    parameters = [
        _parameter(name, kind, typer.Argument(help=about, metavar=metavar), _default_of(kind))
        for name, kind, about, metavar in arguments
    ]
    for name, kind, about, usual, metavar in options:
        text = f"{about} [default: {usual}]." if usual else f"{about}."
        option = typer.Option(name, help=text, metavar=metavar)
        parameters.append(_parameter(field_of(name), kind, option, False if kind is FLAG else None))
    setattr(command, "__signature__", inspect.Signature(parameters))  # noqa: B010  which mypy does not know of
    command.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return command


def _default_of(kind: Any) -> Any:
    """None where an argument may be left out, nothing where not."""
    return None if kind in (TEXT, TEXTS) else inspect.Parameter.empty


def field_of(option: str) -> str:
    """Keyword of an option, as time_offset of --time-offset."""
    return option.removeprefix("--").replace("-", "_")


def _parameter(name: str, kind: Any, given: Any, default: Any) -> inspect.Parameter:
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[kind, given])
