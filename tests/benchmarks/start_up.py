"""Figures of new processes: imports, the first call with kernels in the cache, and their compilation."""

from __future__ import annotations

import tempfile

from benchmarks.clocks import Race
from benchmarks.goals import Figure, Goal, median
from benchmarks.new_process import completed

ANNOUNCED = "kanefe: preparing the solver"
SECONDS_OF_SILENCE = 2.0

IMPORT = """
import time
start = time.process_time()
import {}
print(time.process_time() - start)
"""

# Three kinds of scenes, since each has kernels of its own: in space, in a plane, with flexible bodies. What makes the
# flexible body is not part of the call.
FIRST_CALL = """
import sys, time
import kanefe as kf
kind = {!r}
if kind == "flexible":
    import scenes
    body = scenes.lattice_body(1, reduction=kf.CraigBampton(modes=3))
start = time.process_time()
scene = kf.System(gravity=(0.0, 0.0, -9.81))
arm = scene.add_rigid_body("arm", 1.0, 0.1, com=(0.5, 0.0, 0.0), joint=kf.Revolute("y"))
scene.add_rigid_body("rod", 1.0, 0.1, joint=kf.Revolute("z" if kind == "spatial" else "y"), parent=arm)
if kind == "flexible":
    scene.add_flexible_body("beam", body, joint=kf.Revolute("z"), parent=arm)
model = scene.freeze()
rates = model.rhs(0.0, model.initial_state)
print(time.process_time() - start)
assert rates.any(), rates
"""
KINDS = ("spatial", "planar", "flexible")

IMPORTS = Goal("import kanefe / import numpy", 1.3)
CACHED = {kind: Goal(f"first call in a new process, {kind} scene, kernels built [s]", 0.06) for kind in KINDS}
COMPILED = Goal("all kernels compiled once, in an empty cache [s]", 20.0)
SILENT = Goal("compilations without a line that says so", 0.0)


def imports(rounds: int) -> list[Figure]:
    """Compare the import of kanefe with that of numpy."""
    race = Race(lambda: _timed(IMPORT.format("kanefe"))[0], lambda: _timed(IMPORT.format("numpy"))[0], 2 * rounds)
    remark = f"{1e3 * race.ours:.3g} ms against {1e3 * race.theirs:.3g} ms"
    return [IMPORTS.figure(race.ratio, remark)]


def first_calls(rounds: int) -> list[Figure]:
    """Time the first right-hand side of a process, without compiled kernels and then with them."""
    with tempfile.TemporaryDirectory() as cache:
        compiled = {kind: _timed(FIRST_CALL.format(kind), cache) for kind in KINDS}
        cached = {kind: [_timed(FIRST_CALL.format(kind), cache) for _ in range(rounds)] for kind in KINDS}
    total = sum(seconds for seconds, _ in compiled.values())
    each = ", ".join(f"{kind} scene {seconds:.3g}" for kind, (seconds, _) in compiled.items())
    lines = [line for _, errors in compiled.values() for line in errors.splitlines() if ANNOUNCED in line]
    # a planar scene may share the kernels in space, but what takes seconds was compiled
    silent = sum(seconds > SECONDS_OF_SILENCE and ANNOUNCED not in errors for seconds, errors in compiled.values())
    return [
        *(CACHED[kind].figure(median([seconds for seconds, _ in runs])) for kind, runs in cached.items()),
        COMPILED.figure(total, each),
        SILENT.figure(silent, f"the line: {lines[0].partition(' (')[0]}" if lines else "there was none"),
    ]


def _timed(code: str, cache: str | None = None) -> tuple[float, str]:
    """Return the seconds that a new process prints, and what it wrote to its error stream."""
    surroundings = {} if cache is None else {"XDG_CACHE_HOME": cache}
    done = completed("-c", code, **surroundings)
    return float(done.stdout), done.stderr


GROUPS = {
    imports: [IMPORTS],
    first_calls: [*CACHED.values(), COMPILED, SILENT],
}
