"""Figures of unreduced bodies: steps against the peer's, and Newton iterations against triangular solves."""

from __future__ import annotations

import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from benchmarks.clocks import check_agreement
from benchmarks.fe_figures_pipeline import Settings
from benchmarks.fe_meshes import bar
from benchmarks.goals import Figure, Goal, median
from benchmarks.new_process import answer_of
from benchmarks.peer_process import IMPORTS_OF_MESHES, OF_MESHES, NoPeers, peer_python, surroundings

PEER = Path(__file__).with_name("peer_unreduced.py")

STEP = 1e-3
STEPS = {
    "0.7k": (20, Goal("unreduced bar on a hinge, 240 nodes: time of a step / Exudyn's", 0.02)),
    "1.5k": (6, Goal("same, 520 nodes", 0.02)),
}
"""Steps of 1 ms that the peer is asked for, the run of its own scene; they take it 20 to 300 ms each."""

ITERATIONS = {
    "25k": (30, Goal("unreduced body, 25k dofs: Newton iteration / triangular solve", 2.5)),
    "105k": (10, Goal("same, 105k dofs", 2.5)),
}

SAME_END = 1e-4
"""Difference of the corner to the peer's, of the length: it holds the mean of two edges where ours holds the face."""


def steps_against_peer(settings: Settings) -> list[Figure]:
    """Time steps of the bar, released on its hinge, beside the peer's of the same matrices; both by generalised-alpha.

    Ours choose their size: factorisations of all sizes that are met are in the time.
    """
    python = peer_python(settings.peers, OF_MESHES, IMPORTS_OF_MESHES)
    figures = []
    for size, (steps, goal) in STEPS.items():
        mesh = bar(settings.meshes, size)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "bar.npz"
            nodes = answer_of("unreduced_process", "matrices", mesh, file)["nodes"]
            theirs = _peer(python, file, steps)
            ours = answer_of("unreduced_process", "swing", mesh, steps * STEP, settings.rounds)
        check_agreement(f"bar of {nodes} nodes", ours["end"], theirs["end"], SAME_END)
        own, other = median(ours["seconds"]), theirs["seconds"] / steps
        remark = (
            f"{nodes} nodes, {1e3 * own:.3g} ms against {1e3 * other:.3g} ms; ours in {ours['steps']} steps with "
            f"{ours['iterations']} iterations and {ours['factorisations']} factorisations"
        )
        figures.append(goal.figure(own / other, remark))
    return figures


def iterations(settings: Settings) -> list[Figure]:
    """Time a Newton iteration, residual and solve, and a solve alone, in turn."""
    figures = []
    for size, (count, goal) in ITERATIONS.items():
        run = answer_of("unreduced_process", "iterate", bar(settings.meshes, size), count)
        remark = (
            f"{run['dofs']} dofs, {1e3 * run['iteration']:.3g} ms against {1e3 * run['solve']:.3g} ms; "
            f"S is factored in {run['factoring']:.3g} s"
        )
        figures.append(goal.figure(run["ratio"], remark))
    return figures


def _peer(python: Path, file: Path, steps: int) -> dict[str, Any]:
    command = [str(python), str(PEER), str(file), str(STEP), str(steps)]
    done = subprocess.run(command, capture_output=True, text=True, env=surroundings(), check=False)
    if done.returncode != 0:
        raise NoPeers(f"the peer cannot run an unreduced body:\n{done.stderr[-800:]}")
    answer: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return answer


GROUPS = {
    steps_against_peer: [goal for _, goal in STEPS.values()],
    iterations: [goal for _, goal in ITERATIONS.values()],
}
