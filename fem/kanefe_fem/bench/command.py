"""``kanefe bench``: the options, checked before anything is measured in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Annotated

import typer

from kanefe.errors import ModelError
from kanefe_fem.bench.clocks import ONE_THREAD
from kanefe_fem.bench.options import Options


def bench(
    scenes: Annotated[str, typer.Option(help="Scenes, such as S1,S3; default: S1,S2,S3,S4,C06,demo.")] = "",
    methods: Annotated[str, typer.Option(help="Methods, such as auto,rk4; default: all there are.")] = "",
    quick: Annotated[bool, typer.Option("--quick", help="Fewer tolerances and repetitions: a minute or two.")] = False,
    peer: Annotated[bool, typer.Option("--peer", help="Also run Exudyn, in an environment of its own.")] = False,
    bodies: Annotated[
        bool, typer.Option("--bodies", help="Instead: mesh size, element order and number of modes (S3, demo).")
    ] = False,
    skips: Annotated[bool, typer.Option("--skips", help="Instead: what skipping saves.")] = False,
    figures: Annotated[bool, typer.Option("--figures", help="Instead: the figures that have goals.")] = False,
    json: Annotated[Path | None, typer.Option(help="Write what was found to this file as JSON.")] = None,
    csv: Annotated[Path | None, typer.Option(help="Write the runs to this file as a table.")] = None,
    png: Annotated[Path | None, typer.Option(help="Draw the curves into this file.")] = None,
    env: Annotated[Path | None, typer.Option(help="Folder of the peer's environment; made if it is missing.")] = None,
    tests: Annotated[
        Path | None, typer.Option(help="With --figures: the repository whose test suite is timed as well.")
    ] = None,
    core: Annotated[int | None, typer.Option(help="Core to run on; default: the last.")] = None,
) -> None:
    """Measure error against CPU time, on one core and one thread; exit 1 if a figure misses its goal."""
    options = Options(
        scenes=_names(scenes),
        methods=_names(methods),
        quick=quick,
        peer=peer,
        figures=figures,
        skips=skips,
        bodies=bodies,
        json=_file(json),
        csv=_file(csv),
        png=_file(png),
        env=_file(env),
        tests=_file(tests),
        core=core,
    )
    check(options)
    # the number of threads is read when numpy is loaded, which has happened here
    surroundings = {name: value for name, value in os.environ.items() if name != "KANEFE_JIT"} | ONE_THREAD
    command = [sys.executable, "-m", "kanefe_fem.bench", options.text()]
    raise typer.Exit(subprocess.run(command, env=surroundings, check=False).returncode)


def check(options: Options) -> None:
    """Refuse what cannot be done.

    Raises
    ------
    ModelError
        If a scene, a method, a core or a combination of options does not exist.
    FileError
        If a file cannot be written.
    """
    from kanefe.storage.files import ready_path
    from kanefe_fem.bench.bodies import TRIALS
    from kanefe_fem.bench.catalogue import chosen_scenes
    from kanefe_fem.bench.settings import chosen_methods

    kinds = [name for name in ("bodies", "skips", "figures") if getattr(options, name)]
    if len(kinds) > 1:
        raise ModelError(f"--{kinds[0]} and --{kinds[1]} are benchmarks of their own. Remedy: one after the other")
    chosen = chosen_scenes(options.scenes)
    chosen_methods(options.methods)
    without = {
        "bodies": ("methods", "peer", "csv", "tests"),
        "skips": ("scenes", "methods", "peer", "csv", "png", "tests"),
        "figures": ("scenes", "methods", "peer", "csv", "png"),
        "": ("tests",),
    }[kinds[0] if kinds else ""]
    for name in without:
        if getattr(options, name):
            with_what = f"with --{kinds[0]}" if kinds else "without --figures"
            raise ModelError(f"--{name} has no meaning {with_what}. Remedy: leave it out")
    if options.bodies and options.scenes and not set(chosen) <= set(TRIALS):
        raise ModelError(f"--bodies is for {', '.join(TRIALS)}, not {', '.join(options.scenes)}")
    if options.core is not None and hasattr(os, "sched_getaffinity") and options.core not in os.sched_getaffinity(0):
        raise ModelError(f"there is no core {options.core}. There are: {sorted(os.sched_getaffinity(0))}")
    if options.tests is not None and not (Path(options.tests) / "tests").is_dir():
        raise ModelError(f"--tests {options.tests} is no repository with a folder of tests")
    for path in (options.json, options.csv, options.png):
        if path is not None:
            ready_path(path)


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())


def _file(path: Path | None) -> str | None:
    return None if path is None else str(path)
