"""A run for the tests that kills its process in the middle of a step, where the environment asks for it."""

from __future__ import annotations

import os
import signal
import sys
from typing import Any

import kanefe as kf
from kanefe.integrate import checkpoint, loop
from scenes import lattice_body

DEADLY_CALL = 150
calls = {"count": 0}


def watching(t: float, state: Any) -> float:
    """Return what is never zero in the run."""
    calls["count"] += 1
    if "KANEFE_TEST_KILL" in os.environ and calls["count"] == DEADLY_CALL:
        os.kill(os.getpid(), signal.SIGKILL)
    return t - 9.0


def run(**options: Any) -> kf.Result:
    """Run a pendulum and a flexible arm, made anew, with an event that is looked at in every step."""
    calls["count"] = 0
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    first = scene.add_rigid_body("first", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("z", position=-0.3))
    arm = lattice_body(1, reduction=kf.CraigBampton(modes=2))
    scene.add_flexible_body("arm", arm, parent=first, at=(1, 0, 0), joint=kf.Revolute("z"))
    return scene.simulate((0.0, 1.0), events=[kf.Event("never", watching)], method="dop853", rtol=1e-8, **options)


if __name__ == "__main__":
    loop.CHUNK_SECONDS = checkpoint.LEAST_SHARE = 0.0  # a checkpoint after every step
    run(checkpoint=sys.argv[1], checkpoint_seconds=0.0)
