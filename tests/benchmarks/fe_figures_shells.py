"""Figures of shell bodies: what they cost beside solids of as many degrees of freedom, in the making and in a run."""

from __future__ import annotations

import json
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

from benchmarks.clocks import FEW_ROUNDS, check_agreement
from benchmarks.fe_figures_pipeline import MODES, PEER, SAME_FREQUENCIES, Settings, told
from benchmarks.fe_meshes import bar, sheet
from benchmarks.goals import Figure, Goal, median, median_ratio
from benchmarks.new_process import answer_of
from benchmarks.peer_process import IMPORTS_OF_MESHES, OF_MESHES, NoPeers, peer_python, surroundings

SAME_MODES = 8
"""Normal modes of the two bodies whose right-hand sides are compared; both have the six of the free end beside."""

AGAINST_SOLID = Goal("mesh file -> shell body, 105k dofs / solid body of as many", 0.6)
AGAINST_IMPORT = Goal("same / Exudyn with scipy's eigenmodes, of the same matrices", 0.1)
EVALUATION = Goal("right-hand side with a shell body / with a solid one of as many modes", 1.05)


def shell_against_solid(settings: Settings) -> list[Figure]:
    """Time a shell and a solid from their meshes in turn."""
    kinds = {"shell": sheet(settings.meshes, "105k"), "body": bar(settings.meshes, "105k")}
    rounds = min(settings.rounds, FEW_ROUNDS)
    pairs = [{kind: answer_of("fe_process", kind, mesh, MODES) for kind, mesh in kinds.items()} for _ in range(rounds)]
    ratio = median_ratio(*([pair[kind]["cpu"] for pair in pairs] for kind in kinds))
    last = "; ".join(f"{kind}: {told(run)}" for kind, run in pairs[-1].items())
    return [AGAINST_SOLID.figure(ratio, f"{rounds} pairs, the last {last}")]


def shell_against_peer(settings: Settings) -> list[Figure]:
    """Time the peer's normal modes of the matrices of our shell, without any of its constraint modes."""
    mesh = sheet(settings.meshes, "105k")
    ours = answer_of("fe_process", "shell", mesh, MODES)
    python = peer_python(settings.peers, OF_MESHES, IMPORTS_OF_MESHES)
    with tempfile.TemporaryDirectory() as folder:
        matrices = Path(folder) / "shell.npz"
        answer_of("fe_process", "shell_matrices", mesh, matrices)
        command = [str(python), str(PEER), str(matrices), str(MODES)]
        done = subprocess.run(command, capture_output=True, text=True, env=surroundings(), check=False)
    if done.returncode != 0:
        raise NoPeers(f"the peer cannot make a body:\n{done.stderr[-800:]}")
    theirs = json.loads(done.stdout.splitlines()[-1])
    check_agreement("frequencies", ours["frequencies"], theirs["frequencies"], SAME_FREQUENCIES)
    total = sum(theirs["seconds"].values())
    return [AGAINST_IMPORT.figure(ours["cpu"] / total, f"{told(ours)}; the peer {total:.3g} s, normal modes alone")]


def evaluation_with_shell(settings: Settings) -> list[Figure]:
    """Time right-hand sides with both bodies in turn: neither the mesh nor its kind is left in them."""
    files = sheet(settings.meshes, "3k"), bar(settings.meshes, "3k")
    run = answer_of("fe_process", "evaluations", *files, SAME_MODES)
    remark = f"{1e6 * median(run['shell']):.3g} us against {1e6 * median(run['solid']):.3g} us"
    return [EVALUATION.figure(median_ratio(run["shell"], run["solid"]), remark)]


GROUPS: dict[Callable[[Settings], list[Figure]], list[Goal]] = {
    shell_against_solid: [AGAINST_SOLID],
    shell_against_peer: [AGAINST_IMPORT],
    evaluation_with_shell: [EVALUATION],
}
