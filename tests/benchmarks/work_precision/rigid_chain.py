"""S1: a chain of rigid links on hinges about y and z in turn, released under gravity."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import cycle
from typing import Any

import numpy as np

from benchmarks.work_precision.scene import BenchScene, Setting
from kanefe.checks.verification.scenes import frame_at
from kanefe.equations.model import Model
from kanefe.joints import JointFriction, Revolute
from kanefe.system import System

GRAVITY = (0.0, 0.0, -9.81)

# A box of 0.5 m x 0.05 m x 0.05 m and 1000 kg/m3, hinged at its end.
LENGTH, WIDTH, DENSITY = 0.5, 0.05, 1000.0
MASS = DENSITY * LENGTH * WIDTH**2
INERTIA = MASS / 12 * np.array([2 * WIDTH**2, LENGTH**2 + WIDTH**2, LENGTH**2 + WIDTH**2])

END = 2.0


def chain_start(count: int) -> list[float]:
    """Return q of the chain at the start: hinges about z are turned to either side."""
    return [angle for _, angle in zip(range(count), cycle((0.0, 0.3, 0.0, -0.3)), strict=False)]


def chain_links(count: int) -> list[dict[str, Any]]:
    """Return the links of the chain as numbers: hinges about y and z in turn."""
    return [
        {
            "axis": "yz"[i % 2],
            "at": [LENGTH if i else 0.0, 0.0, 0.0],
            "com": [LENGTH / 2, 0.0, 0.0],
            "mass": MASS,
            "inertia": INERTIA.tolist(),
        }
        for i in range(count)
    ]


def chain_scene(count: int, axes: Sequence[Any] = "yz", friction: JointFriction | None = None) -> System:
    """Return the chain; `axes` are those of its hinges in turn, `friction` is in each."""
    scene = System(gravity=GRAVITY)
    last = None
    for i, (link, angle, axis) in enumerate(zip(chain_links(count), chain_start(count), cycle(axes), strict=False)):
        hinge = Revolute(axis, position=angle, friction=friction)
        last = scene.add_rigid_body(
            f"link {i}", MASS, INERTIA, com=link["com"], joint=hinge, parent=last, at=link["at"]
        )
    return scene


def tip(model: Model, t: float, q: np.ndarray) -> np.ndarray:
    """Return the position of the last link's end in N, m."""
    last = frame_at(model, model.bodies[-1].name, (t, q, np.zeros(model.free_count)))
    return last.p_NoFo_N + last.A_NF @ [LENGTH, 0.0, 0.0]


def chain(count: int, name: str) -> BenchScene:
    """Return the scene of the benchmark with so many links."""
    return BenchScene(
        name=name,
        title=f"S1 · chain of {count} rigid links",
        build=lambda: chain_scene(count).freeze(),
        measure=tip,
        quantity=f"tip position at {END:g} s",
        end=END,
        reference=Setting("dop853", rtol=1e-12),
        agreement=1e-9,
        largest_step=0.04,
        parameters={"links": chain_links(count), "start": chain_start(count), "gravity": GRAVITY},
    )


SCENES: dict[str, Callable[[], BenchScene]] = {"S1": partial(chain, 5, "S1"), "S1-20": partial(chain, 20, "S1-20")}
