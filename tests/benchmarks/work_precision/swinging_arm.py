"""The scene of ``kanefe demo``: a hub with a motor, a flexible arm from a mesh, a tip mass."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from functools import cache
from importlib.resources import as_file, files

import numpy as np

from benchmarks.work_precision.scene import BenchScene, Setting
from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.verification.scenes import frame_at
from kanefe.equations.model import Model
from kanefe_fem import demo

OUTPUTS = 20


@cache
def arm() -> FlexibleBody:
    """Return the arm from its mesh, as the demo makes it."""
    with ExitStack() as stack:
        return demo.solid_arm(stack.enter_context(as_file(files("kanefe_fem") / "data" / "arm.msh")))


def tip_mass(model: Model, t: float, q: np.ndarray) -> np.ndarray:
    """Return the position of the tip mass in N, m."""
    return frame_at(model, "tip", (t, q, np.zeros(model.free_count))).p_NoFo_N


def swinging_arm() -> BenchScene:
    """Return the demo."""
    return BenchScene(
        name="demo",
        title="demo · hub, arm from a mesh, tip mass",
        build=lambda: demo.swing_scene(arm()).freeze(),
        measure=tip_mass,
        quantity=f"tip mass, largest of {OUTPUTS} times to {demo.END:g} s",
        end=demo.END,
        reference=Setting("dop853", rtol=1e-10),
        agreement=1e-7,
        outputs=OUTPUTS,
        largest_step=0.05,
        parameters={"torque": demo.TORQUE, "pulse": demo.PULSE, "modes": 12, "damping": 0.01},
        needs="dolfinx",
    )


SCENES: dict[str, Callable[[], BenchScene]] = {"demo": swinging_arm}
