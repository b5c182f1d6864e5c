"""Our side of the scenes: chains, bars, and how they are stepped and evaluated."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import kanefe as kf
import scenes
from benchmarks.work_precision import steel_bar
from benchmarks.work_precision.rigid_chain import GRAVITY, chain_scene
from benchmarks.work_precision.steel_bar import FREE_MODES
from kanefe.equations.model import Model
from kanefe.fe_model.model import FiniteElementModel
from kanefe.integrate.run import integrate

STEP = 1e-3


def planar_chain(count: int, tilt: float = 0.0) -> Model:
    """Return the chain with all hinges about y, so that it stays in a plane; a tilt (rad) of the last takes it out."""
    return chain_scene(count, ["y"] * (count - 1) + [(tilt, 1.0, 0.0)]).freeze()


def flexible_chain(count: int, modes: int) -> Model:
    """Return a chain of equal flexible bodies of `modes` elastic coordinates, each hinged to the tip of the last."""
    constraint_modes = 6
    body = scenes.lattice_body(
        1,
        {"root": "clamped", "tip": "rigid"},
        interior=modes,
        reduction=kf.CraigBampton(modes=modes - constraint_modes),
    )
    scene = kf.System(gravity=GRAVITY)
    last = None
    for i in range(count):
        member = scene.add_flexible_body(f"body {i}", body, joint=kf.Revolute("yz"[i % 2]), parent=last)
        last = member.interface("tip")
    return scene.freeze()


def hinged_bar(model: FiniteElementModel, modes: int) -> Model:
    """Return S3 without damping, Craig-Bampton with `modes` normal modes beside the six of its tip."""
    from kanefe_fem._petsc import factorise

    reduction = kf.CraigBampton(modes=modes)
    return steel_bar.hinged_bar(kf.flexible_body(model, steel_bar.ENDS, reduction=reduction, factorise=factorise))


def free_bar(model: FiniteElementModel) -> Model:
    """Return S4: the bar tumbling freely, with its free modes."""
    return steel_bar.free_bar(kf.flexible_body(model, {}, reduction=kf.CraigBampton(modes=FREE_MODES)))


def mixed(links: int, bars: int, model: FiniteElementModel) -> Model:
    """Return the chain with so many links, and beside it so many bars that tumble freely, with their free modes."""
    scene, (velocity, omega) = chain_scene(links), steel_bar.free_start()
    body = kf.flexible_body(model, {}, reduction=kf.CraigBampton(modes=FREE_MODES))
    for i in range(bars):
        free = kf.Free(velocity=velocity, angular_velocity=omega)
        scene.add_flexible_body(f"bar {i}", body, joint=free, gravity=False)
    return scene.freeze()


def run(model: Model, steps: int, h: float = STEP, method: str = "rk4") -> np.ndarray:
    """Take steps from the start, if not told otherwise of the classical Runge-Kutta method, and return q at the end."""
    end = steps * h
    return integrate(model, (0.0, end), method=method, step=h, output_step=end, progress=False).coordinates[-1]


def evaluation(model: Model) -> Callable[[], np.ndarray]:
    """Return one evaluation of the right-hand side at the start, as a user calls it."""
    y, rhs = model.initial_state, model.rhs
    return lambda: rhs(0.0, y)
