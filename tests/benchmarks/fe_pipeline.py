"""The finite element side against its peers and its goals.

    python tests/benchmarks/fe_pipeline.py [--quick] [--large] [--json FILE]

makes meshes and an environment of its own for the peer, runs each figure in processes of its own on one core with one
thread, and prints a table. Figures live in the modules ``fe_figures_*.py``, each with a table ``GROUPS`` of functions
that take the `Settings` and return figures, and the goals of each.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(1, str(Path(__file__).resolve().parents[1] / "shared"))

from benchmarks.clocks import FEW_ROUNDS, ROUNDS, Disagreement
from benchmarks.command_line import parser, run
from benchmarks.goals import Figure, Goal


def default_folder() -> Path:
    """Return the folder of the meshes and of the peers' environment in the user's cache."""
    import platformdirs

    return Path(platformdirs.user_cache_dir("kanefe")) / "benchmarks"


def arguments(given: Sequence[str] | None = None) -> argparse.Namespace:
    """Return the options of the command line."""
    options = parser(__doc__, quick="fewer rounds")
    options.add_argument("--large", action="store_true", help="also 870,000 degrees of freedom: 16 GB, some minutes")
    options.add_argument("--meshes", type=Path, metavar="FOLDER", help="of the meshes; made if they are missing")
    return options.parse_args(given)


def measured(options: argparse.Namespace) -> list[Figure]:
    """Return all figures; what cannot be measured is there with the reason."""
    from benchmarks.fe_figures_pipeline import LARGE, Settings
    from benchmarks.new_process import BrokenProcess
    from benchmarks.peer_process import NoPeers
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
    return run(arguments(given), measured)


if __name__ == "__main__":
    sys.exit(main())
