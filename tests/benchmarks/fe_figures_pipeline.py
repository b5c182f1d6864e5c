"""Figures of the way from a mesh file to a body, and of the second run, which takes it from the cache."""

from __future__ import annotations

import json
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.clocks import check_agreement
from benchmarks.fe_meshes import bar
from benchmarks.goals import Figure, Goal, median
from benchmarks.new_process import BrokenProcess, answer_of
from benchmarks.peer_process import IMPORTS_OF_MESHES, OF_MESHES, NoPeers, peer_python, surroundings

PEER = Path(__file__).with_name("peer_fe_body.py")
MODES = 20
"""Normal modes with the ends held; the two ends bring 12 constraint modes."""

SAME_FREQUENCIES = 1e-5
"""Difference of frequencies to the peer's, as a part of the largest: the tolerance of its eigenvalue solver."""

BODY_25K = Goal("mesh file -> Craig-Bampton, 25k dofs, forms compiled [s]", 1.0)
AGAINST_PEER = Goal("same, 105k dofs / Exudyn with scipy's eigenmodes, same mesh", 0.05)
BODY_270K, MEMORY_270K = Goal("same, 270k dofs [s]", 20.0), Goal("same, 270k dofs, peak memory [GB]", 3.0)
BODY_870K, MEMORY_870K = Goal("same, 870k dofs [s]", 90.0), Goal("same, 870k dofs, peak memory [GB]", 10.0)
MATRICES = Goal("matrices alone, 300k dofs / dolfinx's own calls", 1.2)
SECOND_RUN = Goal("second run of a scene, new process: start to first step, 270k dofs [s]", 1.0)


@dataclass(frozen=True)
class Settings:
    """What all figures need to know.

    Attributes
    ----------
    rounds : int
        How often what is short is repeated.
    meshes : Path
        Folder of the meshes.
    peers : Path
        Folder of the peers' environment.
    """

    rounds: int
    meshes: Path
    peers: Path


def smallest_body(settings: Settings) -> list[Figure]:
    """Time a body of 25,000 degrees of freedom."""
    runs = [answer_of("fe_process", "body", bar(settings.meshes, "25k"), MODES) for _ in range(settings.rounds)]
    return [BODY_25K.figure(median([run["cpu"] for run in runs]), told(runs[-1]))]


def body_against_peer(settings: Settings) -> list[Figure]:
    """Time the same mesh with the peer; both must find the same frequencies."""
    mesh = bar(settings.meshes, "105k")
    ours = answer_of("fe_process", "body", mesh, MODES)
    python = peer_python(settings.peers, OF_MESHES, IMPORTS_OF_MESHES)
    done = subprocess.run(
        [str(python), str(PEER), str(mesh), str(MODES)], capture_output=True, text=True, env=surroundings(), check=False
    )
    if done.returncode != 0:
        raise NoPeers(f"the peer cannot make a body:\n{done.stderr[-800:]}")
    theirs = json.loads(done.stdout.splitlines()[-1])
    check_agreement("frequencies", ours["frequencies"], theirs["frequencies"], SAME_FREQUENCIES)
    total = sum(theirs["seconds"].values())
    each = ", ".join(f"{stage} {seconds:.3g} s" for stage, seconds in theirs["seconds"].items())
    return [AGAINST_PEER.figure(ours["cpu"] / total, f"{told(ours)}; the peer {total:.3g} s: {each}")]


def large_body(settings: Settings) -> list[Figure]:
    """Time and memory of a body of 270,000 degrees of freedom."""
    run = answer_of("fe_process", "body", bar(settings.meshes, "270k"), MODES)
    return [BODY_270K.figure(run["cpu"], told(run)), MEMORY_270K.figure(run["gigabytes"])]


def largest_body(settings: Settings) -> list[Figure]:
    """Time and memory of a body of 870,000 degrees of freedom."""
    run = answer_of("fe_process", "body", bar(settings.meshes, "870k"), MODES)
    return [BODY_870K.figure(run["cpu"], told(run)), MEMORY_870K.figure(run["gigabytes"])]


def matrices(settings: Settings) -> list[Figure]:
    """Compare our matrices with what dolfinx's own calls take for the same ones."""
    run = answer_of("fe_process", "matrices", bar(settings.meshes, "300k"))
    for name, ours, theirs in zip(("stiffness", "mass"), *run["traces"], strict=True):
        check_agreement(f"trace of the {name}", [ours], [theirs], 1e-12)
    ratio = median([a / b for a, b in zip(run["ours"], run["theirs"], strict=True)])
    remark = f"{run['dofs']} dofs, {median(run['ours']):.3g} s against {median(run['theirs']):.3g} s"
    return [MATRICES.figure(ratio, remark + " (ours: from nodes and cells to a model, checks and groups included)")]


def second_run(settings: Settings) -> list[Figure]:
    """Time a scene whose body is in the cache, from the start of the process."""
    mesh = bar(settings.meshes, "270k")
    with tempfile.TemporaryDirectory() as cache:
        first, _ = _scene(mesh, cache)  # and compiles the kernels, if they are not
        runs = [_scene(mesh, cache) for _ in range(max(3, settings.rounds))]
    heavy = [name for _, answer in runs for name in answer["heavy"]]
    if heavy or not all(answer["found"] for _, answer in runs):
        raise BrokenProcess(f"the second run imported {heavy or 'nothing'}, and did not find its body")
    clock = ", ".join(f"{seconds:.3g}" for seconds, _ in runs)
    remark = f"by the clock {clock} s; the first run took {first:.3g} s"
    return [SECOND_RUN.figure(median([answer["cpu"] for _, answer in runs]), remark)]


def told(run: dict[str, Any]) -> str:
    """Return what a run of `benchmarks.fe_process` took, as text."""
    stages = ", ".join(f"{stage} {seconds:.3g}" for stage, seconds in run["stages"].items())
    return f"{run['dofs']} dofs, {run['cpu']:.3g} s of CPU time, {run['wall']:.3g} s by the clock ({stages})"


def _scene(mesh: Path, cache: str) -> tuple[float, dict[str, Any]]:
    """Return the seconds by the clock from the start of a process to its first time step, and what it says."""
    start = time.time()
    answer = answer_of("fe_process", "scene", mesh, MODES, KANEFE_CACHE="1", KANEFE_CACHE_DIR=cache)
    return answer["at"] - start, answer


GROUPS = {
    smallest_body: [BODY_25K],
    body_against_peer: [AGAINST_PEER],
    large_body: [BODY_270K, MEMORY_270K],
    matrices: [MATRICES],
    second_run: [SECOND_RUN],
}
LARGE = {largest_body: [BODY_870K, MEMORY_870K]}
