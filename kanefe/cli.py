"""The command line: ``kanefe doctor``, ``kanefe verify`` ..., and the commands of plugins (``kanefe demo``)."""

from __future__ import annotations

import sys
from importlib.metadata import entry_points
from typing import Annotated

import typer

from kanefe._version import __version__
from kanefe.errors import KanefeError

COMMANDS = "kanefe.commands"
"""Group of entry points whose functions become commands."""

FIRST = ("demo",)
"""Plugin commands that are listed first, because newcomers run them before all others."""

VARIABLES = (
    "Environment: KANEFE_CACHE_DIR is the folder of the cache, also for compiled kernels; KANEFE_CACHE_GB the size "
    "above which its files are removed, least recently used first (default 10); with KANEFE_CACHE=0 bodies and models "
    "are not cached."
)


def verify(
    cases: Annotated[list[str] | None, typer.Argument(help="Cases to run, such as A01 C03; default: all.")] = None,
    json: Annotated[
        str | None, typer.Option(help="Write the results to this file as JSON; '-' for standard output.")
    ] = None,
    tol: Annotated[
        float,
        typer.Option(help="Factor on the relative tolerance of every run; the tolerances of the checks stay."),
    ] = 1.0,
) -> None:
    """Run the verification cases that ship with the package; exit 1 if one misses its tolerance."""
    from kanefe.checks.verification.runner import verify as run

    raise typer.Exit(run(cases or [], json, tol))


def stress(
    cases: Annotated[list[str] | None, typer.Argument(help="Cases to run, such as drift spin; default: all.")] = None,
    json: Annotated[
        str | None, typer.Option(help="Write the findings to this file as JSON; '-' for standard output.")
    ] = None,
    html: Annotated[str | None, typer.Option(help="Write the table to this file as a page of HTML.")] = None,
) -> None:
    """Try extremes for a minute, and print the worst figure of each against its limit; exit 1 if one fails."""
    from kanefe.checks.robustness.runner import stress as run

    raise typer.Exit(run(cases or [], json_path=json, html_path=html))


def doctor(
    json: Annotated[
        str | None, typer.Option(help="Also write what was found to this file as JSON; '-' for standard output.")
    ] = None,
) -> None:
    """Show the installed packages, the caches, and a solve on each route; exit code 1 if something is broken."""
    from kanefe.doctor.examination import doctor as run

    raise typer.Exit(run(json))


def new(
    name: Annotated[str, typer.Argument(help="The folder to create; its last part is the name of the project.")],
    step: Annotated[
        str | None, typer.Option(help="A STEP file of an assembly: the script reads it and lists the joints found.")
    ] = None,
) -> None:
    """Create a folder with a mesh source, a script that runs, and a page with the next steps."""
    from kanefe.new_project.project import new_project

    written = new_project(name, step)
    folder = written[0].parent
    typer.echo(f"made {folder} with {', '.join(path.name for path in written)}")
    typer.echo(f"next: cd {folder} && python run.py")


def version() -> None:
    """Print the version."""
    typer.echo(__version__)


def prepare() -> None:
    """Build the solver for this machine now, not in the first runs; a wheel already contains it."""
    from kanefe.kernels.compiler.build import build
    from kanefe.kernels.compiler.processors import own_folder, processors_here

    built = build(own_folder(), processors_here(), typer.echo)
    if not built:
        typer.echo("the solver is there already")
    typer.echo(f"folder: {own_folder()}")


def view(
    run: Annotated[str, typer.Argument(help="A file written by result.save, such as out/run.h5.")],
    to: Annotated[str | None, typer.Option(help="Write the page to this .html file; open no browser.")] = None,
) -> None:
    """Show a saved run in the browser as an animation that can be turned with the mouse."""
    from kanefe.result import load_result

    result = load_result(run)
    if to is None:
        result.view()
    else:
        typer.echo(f"written: {result.to_html(to)}")


def skill() -> None:
    """Print recipes for coding assistants: imports, units, frames, ten scenes, how to check an answer."""
    from kanefe.skill import recipes

    typer.echo(recipes())


def _print_version(is_asked: bool) -> None:
    if is_asked:
        version()
        raise typer.Exit


def options(
    is_asked: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Rigid-flexible multibody dynamics by Kane's method."""


def list_cache() -> None:
    """List the bodies and the models in the cache, last used first."""
    import time

    from kanefe.bodies import cache

    found = cache.entries()
    if not found:
        typer.echo(f"the cache {cache.bodies_folder()} is empty")
        return
    typer.echo(f"{cache.bodies_folder()}: {len(found)} files, {1e-6 * sum(entry.size for entry in found):.1f} MB")
    for entry in found:
        used = time.strftime("%Y-%m-%d %H:%M", time.localtime(entry.used))
        kind = entry.kind or "?"
        typer.echo(f"{entry.key[:8]}  {kind:5}  {1e-6 * entry.size:8.1f} MB  used {used}  {entry.summary}")


def clear_cache(
    kernels: Annotated[bool, typer.Option("--kernels", help="Remove the compiled kernels as well.")] = False,
) -> None:
    """Remove all bodies and models from the cache."""
    from kanefe.bodies import cache

    count, freed = cache.clear()
    typer.echo(f"{count} files, {1e-6 * freed:.1f} MB removed")
    if kernels:
        freed = cache.clear_kernels()
        typer.echo(f"the compiled kernels, {1e-6 * freed:.1f} MB, removed")


def main() -> None:
    """Run the command line; an error of kanefe is printed as one sentence on standard error, with exit code 2."""
    app = typer.Typer(
        name="kanefe",
        epilog=VARIABLES,
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
    )
    app.callback()(options)
    given = {command.name: command.load() for command in entry_points(group=COMMANDS)}
    first = {name: given.pop(name) for name in FIRST if name in given}
    own = {
        "new": new,
        "view": view,
        "doctor": doctor,
        "prepare": prepare,
        "verify": verify,
        "stress": stress,
        "skill": skill,
    }
    for name, command in {**first, **own, **given, "version": version}.items():
        app.command(name)(command)
    of_cache = typer.Typer(
        name="cache", help="The cache of flexible bodies and their models.", epilog=VARIABLES, no_args_is_help=True
    )
    of_cache.command("list")(list_cache)
    of_cache.command("clear")(clear_cache)
    app.add_typer(of_cache)
    try:
        app()
    except KanefeError as error:
        print(f"kanefe: {error}", file=sys.stderr)
        sys.exit(2)


if __name__ == "__main__":
    main()
