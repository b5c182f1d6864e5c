"""The command line: ``kanefe verify``, and the commands that plugins such as `kanefe_fem` add (``kanefe demo``)."""

from __future__ import annotations

import sys
from importlib.metadata import entry_points
from typing import Annotated

import typer

from kanefe import __version__
from kanefe.errors import KanefeError

COMMANDS = "kanefe.commands"
"""Entry points whose functions become commands."""


def verify(
    cases: Annotated[list[str] | None, typer.Argument(help="Cases to run, such as A01 C03; default: all.")] = None,
    json: Annotated[
        str | None, typer.Option(help="Write the results to this file as JSON; '-' for standard output.")
    ] = None,
) -> None:
    """Run the verification cases that ship with the package; exit 1 if one misses its tolerance."""
    from kanefe.verify.runner import verify as run

    raise typer.Exit(run(cases or [], json))


def version() -> None:
    """Print the version."""
    typer.echo(__version__)


def main() -> None:
    """Run the command line; what the user can mend is one sentence on standard error and exit code 2."""
    app = typer.Typer(
        name="kanefe",
        help="Rigid-flexible multibody dynamics by Kane's method.",
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
    )
    app.command()(verify)
    app.command()(version)
    for command in entry_points(group=COMMANDS):
        app.command(command.name)(command.load())
    try:
        app()
    except KanefeError as error:
        print(f"kanefe: {error}", file=sys.stderr)
        sys.exit(2)


if __name__ == "__main__":
    main()
