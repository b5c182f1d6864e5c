"""The finite element side against its peers and its goals.

    python tests/benchmarks/fe_pipeline.py [--quick] [--large] [--json FILE]

makes meshes and an environment of its own for the peer, runs each figure in processes of its own on one core with one
thread, and prints a table. Figures live in the modules ``fe_figures_*.py``, each with a table ``GROUPS`` of functions
that take the `Settings` and return figures, and the goals of each.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.measure import FEW_ROUNDS, ROUNDS, Disagreement, use_one_core
from benchmarks.report import Figure, Goal, table, write_json


def default_folder() -> Path:
    """Return the folder of the meshes and of the peers' environment in the user's cache."""
    import platformdirs

    return Path(platformdirs.user_cache_dir("kanefe")) / "benchmarks"


def arguments(given: Sequence[str] | None = None) -> argparse.Namespace:
    """Return the options of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write a list of {what, value, goal, met}")
    parser.add_argument("--quick", action="store_true", help="fewer rounds")
    parser.add_argument("--large", action="store_true", help="also 870,000 degrees of freedom: 16 GB, some minutes")
    parser.add_argument("--env", type=Path, metavar="FOLDER", help="environment of the peers; made if it is missing")
    parser.add_argument("--meshes", type=Path, metavar="FOLDER", help="of the meshes; made if they are missing")
    parser.add_argument("--core", type=int, metavar="NUMBER", help="core to run on; default: the last")
    parser.add_argument("--only", default="", metavar="TEXT", help="only the groups of figures with this in the name")
    return parser.parse_args(given)


def measured(options: argparse.Namespace) -> list[Figure]:
    """Return all figures; what cannot be measured is there with the reason."""
    from benchmarks.fe_figures_pipeline import LARGE, BrokenProcess, Settings
    from benchmarks.peer_environment import NoPeers
    from kanefe.errors import KanefeError

    settings = Settings(
        rounds=FEW_ROUNDS if options.quick else ROUNDS,
        meshes=options.meshes or default_folder() / "meshes",
        peers=options.env or default_folder() / "peers",
    )
    groups: dict[Callable[[Settings], list[Figure]], list[Goal]] = {}
    names = sorted(path.stem for path in Path(__file__).parent.glob("fe_figures_*.py"))
    for name in sorted(names, key=lambda name: name != "fe_figures_pipeline"):
        groups |= import_module(f"benchmarks.{name}").GROUPS
        if options.large and name == "fe_figures_pipeline":
            groups |= LARGE
    figures: list[Figure] = []
    for group, goals in groups.items():
        if options.only not in group.__name__:
            continue
        print(f"measuring {group.__name__.replace('_', ' ')}", file=sys.stderr, flush=True)
        try:
            figures.extend(group(settings))
        except (NoPeers, Disagreement, BrokenProcess, KanefeError, ModuleNotFoundError) as failure:
            print(failure, file=sys.stderr, flush=True)
            figures.extend(goal.skipped(str(failure).partition("\n")[0]) for goal in goals)
    return figures


def main(given: Sequence[str] | None = None) -> int:
    """Measure and print; the status is 1 where a goal is missed."""
    options = arguments(given)
    use_one_core(options.core)
    os.environ.pop("KANEFE_JIT", None)
    figures = measured(options)
    print(table(figures))
    if options.json:
        write_json(figures, options.json)
    return 0 if all(figure.met for figure in figures) else 1


if __name__ == "__main__":
    sys.exit(main())
