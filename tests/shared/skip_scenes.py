"""Scenes for the tests of what is skipped: a chain, and the same chain beside something that leaves it alone."""

from __future__ import annotations

import importlib
import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

import kanefe as kf
from bent_bodies import bent
from kanefe.contact.rigid.rigid_contact import SLIPS
from kanefe.equations.model import Model
from scenes import lattice_body, random_inertia, unit_axis

T = 0.2


def chain(beside: Callable[[kf.System], None] | None = None, **arm: Any) -> Model:
    """Return two links in space, the second one with an arm if a body is given, and what is beside them."""
    rng = np.random.default_rng(3)
    scene = kf.System(gravity=(0.3, -1.0, -9.0))
    parent = None
    for name in ("one", "two"):
        com, joint = rng.uniform(-0.2, 0.2, 3), kf.Revolute(unit_axis(rng))
        inertia = random_inertia(rng)
        parent = scene.add_rigid_body(name, 1.5, inertia, com=com, parent=parent, joint=joint, at=(0.5, 0, 0))
    if arm:
        is_bent = arm.pop("is_bent", False)
        body = lattice_body(1, **arm)
        scene.add_flexible_body("arm", bent(body) if is_bent else body, parent=parent, at=(0.3, 0.1, 0))
    if beside is not None:
        beside(scene)
    return scene.freeze()


def flexible_beside(scene: kf.System) -> None:
    scene.add_flexible_body("idle", lattice_body(2))


def spring_beside(scene: kf.System) -> None:
    scene.add_spring("idle", scene.ground, scene.add_rigid_body("block", 1.0, at=(1, 0, 0)), stiffness=3.0)


def contact_beside(scene: kf.System, gap: float) -> None:
    ball = scene.add_rigid_body("ball", 1.0, 0.1, at=(3, 0, 0.2 + gap), joint=kf.Prismatic("z"))
    skin, floor = (
        scene.add_surface("skin", ball, kf.shapes.Sphere(0.2)),
        scene.add_surface("floor", scene.ground, kf.shapes.Plane("z")),
    )
    scene.add_contact("idle", skin, floor, normal=kf.HuntCrossley(1e4))


def loop_beside(scene: kf.System) -> None:
    block = scene.add_rigid_body("block", 1.0, at=(1, 0, 0), joint=kf.Prismatic("x"))
    scene.add_loop_joint("idle", kf.Prismatic("x"), scene.ground, block)


def switched_beside(scene: kf.System, is_on: bool) -> None:
    block = scene.add_rigid_body("block", 1.0, at=(1, 0, 0), joint=kf.Prismatic("x"))
    scene.add_loop_joint("idle", kf.Prismatic("x"), scene.ground, block, starts_on=is_on)


def drive_beside(scene: kf.System) -> None:
    table = kf.Motion(np.sin, np.cos, lambda t: -np.sin(t))
    scene.add_rigid_body("idle", 1.0, 0.1, at=(1, 0, 0), joint=kf.Revolute("z", motion=table))


def block_beside(scene: kf.System) -> None:
    slide = scene.add_rigid_body("slide", 1.0, at=(1, 0, 0), joint=kf.Prismatic("x"))
    block = scene.add_rigid_body("block", 1.0, parent=slide, joint=kf.Prismatic("z"))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    scene.add_contact("contact", block, floor, normal=kf.Rigid(), friction=kf.Coulomb(0.3))


def slipping(model: Model) -> Model:
    """Return a model whose point slips as it starts."""
    z = model.initial_states.copy()
    model.rigid_contact(0).with_status(z, 0, SLIPS, np.zeros(3))
    return replace(model, initial_states=z)


DAMPED: dict[str, Any] = {"reduction": kf.CraigBampton(modes=2), "damping": kf.ModalDamping(0.1)}
FREE: dict[str, Any] = {"reduction": kf.CraigBampton(modes=2)}

# name -> functions that are skipped, the scene that skips them, and one of the same motion that does not
SKIPS: dict[str, tuple[list[str], Callable[[], Model], Callable[[], Model]]] = {
    "elastic code without flexible bodies": (
        [
            "evaluation.evaluation.modal_dissipation",
            "evaluation.evaluation.add_field_loads",
            "sweeps.outward.modal_state",
            "sweeps.outward.move_interface",
            "sweeps.inertia.set_flexible",
            "constraints.tree_sweeps.eliminate_modes",
            "constraints.tree_sweeps.modal_accelerations",
        ],
        chain,
        lambda: chain(flexible_beside),
    ),
    "springs": (["evaluation.evaluation.add_loads_between"], chain, lambda: chain(spring_beside)),
    "contacts out of reach": (
        ["loads.loads_between.evaluate_load", "loads.loads_between.apply_load"],
        lambda: chain(lambda scene: contact_beside(scene, gap=1e-3)),
        lambda: chain(lambda scene: contact_beside(scene, gap=-1e-4)),
    ),
    "constraints": (
        ["constraints.tree_sweeps.close_at", "constraints.tree_sweeps.exert_at"],
        chain,
        lambda: chain(loop_beside),
    ),
    "points of rigid contacts": (
        [
            "constraints.row_wrenches.meet",
            "evaluation.evaluation.hold",
            "constraints.multipliers.share_forces",
            "evaluation.evaluation.put_contact_rates",
        ],
        lambda: chain(loop_beside),
        lambda: slipping(chain(block_beside)),
    ),
    "constraints that are switched off": (
        ["constraints.row_wrenches._write_joint", "constraints.loop_system.put_visits"],
        lambda: chain(lambda scene: switched_beside(scene, is_on=False)),
        lambda: chain(lambda scene: switched_beside(scene, is_on=True)),
    ),
    "driving forces": (["evaluation.evaluation.put_driving_forces"], chain, lambda: chain(drive_beside)),
    "damping product": (
        ["evaluation.evaluation.total", "sweeps.elastic._subtract_product"],
        lambda: chain(**FREE),
        lambda: chain(**DAMPED),
    ),
    "fluid around a body": (["sweeps.inertia.add_fluid"], lambda: chain(**FREE), lambda: chain(**FREE, in_fluid=True)),
    "second-order displacement": (["sweeps.elastic._bend"], lambda: chain(**FREE), lambda: chain(**FREE, is_bent=True)),
}


def rates(model: Model) -> np.ndarray:
    """Return dy/dt of the order-n route, without powers, at a state where what is beside the chain is at rest."""
    q, u = np.zeros(model.coordinate_count), np.zeros(model.free_count)
    q[:2], u[:2] = (0.4, -0.7), (1.2, -0.8)
    return model.rhs(T, np.concatenate((q, u, model.initial_states)))


def patched_rates(model: Model, functions: list[str]) -> list[str]:
    """Return the functions that a model calls, by replacing each of them in turn by one that raises."""
    called = []
    for where in functions:
        module_name, name = where.rsplit(".", 1)
        module = importlib.import_module(f"kanefe.kernels.{module_name}")
        kept = getattr(module, name)

        def refuse(*arguments: Any, where: str = where) -> None:
            raise LookupError(where)

        setattr(module, name, refuse)
        try:
            rates(model)
        except LookupError:
            called.append(where)
        finally:
            setattr(module, name, kept)
    return called


def report() -> str:
    """Return for each skip, as json: the functions, those that the one scene calls, those that the other calls."""
    found = {}
    for name, (functions, sparing, busy) in SKIPS.items():
        found[name] = functions, patched_rates(sparing(), functions), patched_rates(busy(), functions)
    return json.dumps(found)
