"""The command line that the benchmarks share: options, and what is printed and written at the end."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from pathlib import Path

from benchmarks.clocks import use_one_core
from benchmarks.goals import Figure, table, write_json


def parser(description: str | None, quick: str) -> argparse.ArgumentParser:
    """Return a parser of the common options; `quick` says what a quick run leaves out."""
    found = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    found.add_argument("--json", type=Path, metavar="FILE", help="also write a list of {what, value, goal, met}")
    found.add_argument("--quick", action="store_true", help=quick)
    found.add_argument("--env", type=Path, metavar="FOLDER", help="environment of the peers; made if it is missing")
    found.add_argument("--core", type=int, metavar="NUMBER", help="core to run on; default: the last")
    found.add_argument("--only", default="", metavar="TEXT", help="only the groups of figures with this in the name")
    return found


def run(options: argparse.Namespace, measured: Callable[[argparse.Namespace], list[Figure]]) -> int:
    """Measure on one core and print; the status is 1 where a goal is missed."""
    use_one_core(options.core)
    os.environ.pop("KANEFE_JIT", None)
    figures = measured(options)
    print(table(figures))
    if options.json:
        write_json(figures, options.json)
    return 0 if all(figure.met for figure in figures) else 1
