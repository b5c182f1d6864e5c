"""What studies of the tests build and keep: in a module, where worker processes find it."""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
import signal
import sys
import time
import warnings
from typing import Any

import kanefe as kf
from kanefe.studies.table import MEASURED

GRID = {"length": (0.5, 1.0), "angle": (0.0, 0.3), "seed": range(3)}


def hinged(length: float, angle: float, seed: int = 0) -> tuple[kf.System, kf.Frame]:
    """Return a scene with a rod on a hinge, and the rod."""
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    joint = kf.Revolute("z", position=angle + 0.01 * seed)
    return scene, scene.add_rigid_body("rod", 1.0, length**2 / 12, com=(length / 2, 0, 0), joint=joint)


def pendulum(length: float, angle: float, seed: int = 0) -> kf.System:
    return hinged(length, angle, seed)[0]


def lowest(result: kf.Result) -> dict[str, Any]:
    return {"lowest": result.joint_coordinates("rod").min()}


def troubled(seed: int) -> kf.System:
    """Return a scene that does each time something else."""
    if seed == 1:
        raise ValueError("too much wind")
    scene, rod = hinged(1.0, 0.0, seed)
    if seed == 2:
        warnings.warn("it is windy", UserWarning, stacklevel=1)
    if seed == 3:  # grows without bound
        scene.add_torque(rod, lambda t, state: (0.0, 0.0, 1e3 * state.joint_speeds("rod")[0] ** 3))
    if seed == 4:
        return kf.System()
    return scene


def told(result: kf.Result) -> dict[str, Any]:
    if result.joint_coordinates("rod")[0, 0] > 0.045:  # seed 5
        raise RuntimeError("no number")
    return lowest(result)


def deadly(seed: int) -> kf.System:
    """Kill the worker process of one case, in memory of what a kernel does that is out of memory."""
    if seed == 2 and "KANEFE_TEST_KILL" in os.environ:
        os.kill(os.getpid(), signal.SIGKILL)
    return pendulum(1.0, 0.0, seed)


def deadly_in_workers(seed: int, asking: int) -> kf.System:
    """Kill each process that runs one of the cases, but the one that asks."""
    if seed == 1 and os.getpid() != asking:
        os.kill(os.getpid(), signal.SIGKILL)
    return pendulum(1.0, 0.0, seed)


def bits(table: kf.StudyTable) -> str:
    """Return a hash of all columns but those that tell of the machine."""
    columns = {name: values for name, values in table.lists().items() if name not in MEASURED}
    return hashlib.sha256(json.dumps(columns).encode()).hexdigest()


def slow(seed: int) -> kf.System:
    """Say which process works, and take long."""
    if multiprocessing.parent_process() is not None:
        print(os.getpid(), file=sys.stderr, flush=True)
        time.sleep(60.0)
    return pendulum(1.0, 0.0, seed)


def slow_study() -> kf.Study:
    return kf.Study(slow, lowest, duration=0.1, seed=range(2))


def deadly_study() -> kf.Study:
    return kf.Study(deadly, lowest, duration=0.1, seed=range(4))


if __name__ == "__main__":
    import study_scenes  # by its name, where the test finds it too

    if sys.argv[2] == "slow":
        study_scenes.slow_study().run("processes", store=sys.argv[1], workers=1)
    else:
        study_scenes.deadly_study().run(sys.argv[2], store=sys.argv[1])
