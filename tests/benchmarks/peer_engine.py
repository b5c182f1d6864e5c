"""The engine against its peers, Exudyn, Pinocchio and MuJoCo, and against its goals.

    python tests/benchmarks/peer_engine.py [--quick] [--json FILE]

makes an environment of its own for the peers, runs both sides in turn on one core with one thread, and prints a table.
Times are CPU times; what is compared must first give the same motion.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(1, str(Path(__file__).resolve().parents[1] / "shared"))

from benchmarks.clocks import FEW_ROUNDS, ROUNDS, Disagreement
from benchmarks.command_line import parser, run
from benchmarks.goals import Figure, Goal

SERVER = Path(__file__).with_name("peer_scenes.py")


def default_environment() -> Path:
    """Return the folder of the peers' environment in the user's cache."""
    import platformdirs

    return Path(platformdirs.user_cache_dir("kanefe")) / "peers"


def arguments(given: Sequence[str] | None = None) -> argparse.Namespace:
    """Return the options of the command line."""
    options = parser(__doc__, quick="fewer rounds, and the fine mesh with 8 modes only")
    return options.parse_args(given)


def measured(options: argparse.Namespace) -> list[Figure]:
    """Return all figures; what cannot be measured is there with the reason."""
    # numpy reads the number of threads when it is imported, which these do
    from benchmarks import (
        against_peers,
        around_a_run,
        fixed_costs,
        loops,
        mujoco_chains,
        own_figures,
        own_functions,
        rigid_contacts,
        sampled_arm,
        start_up,
        stepping,
        viscoelastic_body,
    )
    from benchmarks.new_process import BrokenProcess
    from benchmarks.peer_process import NoPeers, Peers, peer_python
    from kanefe.errors import KanefeError

    rounds = FEW_ROUNDS if options.quick else ROUNDS
    failures = (NoPeers, Disagreement, BrokenProcess, KanefeError, ModuleNotFoundError)
    figures: list[Figure] = []

    def measure(name: str, goals: Sequence[Goal], group: Callable[[], list[Figure]]) -> None:
        print(f"measuring {name.replace('_', ' ')}", file=sys.stderr, flush=True)
        try:
            figures.extend(group())
        except failures as failure:
            figures.extend(_skipped(goals, failure))

    every = against_peers.GROUPS | mujoco_chains.GROUPS | sampled_arm.GROUPS
    with_peers = {g: goals for g, goals in every.items() if options.only in g.__name__}
    if with_peers:
        try:
            with Peers(peer_python(options.env or default_environment()), SERVER) as peers:
                versions = ", ".join(f"{name} {number}" for name, number in peers.ask("versions").items())
                print(f"peers: {versions}", file=sys.stderr, flush=True)
                for group, goals in with_peers.items():
                    measure(group.__name__, goals, partial(group, peers, rounds))
        except NoPeers as failure:
            figures.extend(_skipped([goal for goals in with_peers.values() for goal in goals], failure))
    alone = (
        own_figures.GROUPS
        | own_functions.GROUPS
        | loops.GROUPS
        | around_a_run.GROUPS
        | fixed_costs.GROUPS
        | rigid_contacts.GROUPS
        | start_up.GROUPS
        | stepping.GROUPS
        | viscoelastic_body.GROUPS
    )
    for group, goals in alone.items():
        if options.only in group.__name__:
            measure(group.__name__, goals, partial(group, rounds))
    return figures


def _skipped(goals: Sequence[Goal], failure: Exception) -> list[Figure]:
    """Return the figures that a failure leaves out, and print it in full."""
    print(failure, file=sys.stderr, flush=True)
    return [goal.skipped(str(failure).partition("\n")[0]) for goal in goals]


def main(given: Sequence[str] | None = None) -> int:
    """Measure and print; the status is 1 where a goal is missed."""
    return run(arguments(given), measured)


if __name__ == "__main__":
    sys.exit(main())
