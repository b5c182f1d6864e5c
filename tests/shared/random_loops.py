"""Random scenes with loops that are closed by construction: each end b is placed where a is at the start."""

from __future__ import annotations

from typing import Any

import numpy as np

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.errors import SimulationError
from kanefe.frames import euler_parameters_from_matrix
from kanefe.joints.base import ScalarJoint
from kanefe.literal.loop_closure import project_positions, project_speeds
from kanefe.scene.scene import Frame
from kanefe.states.constraints import constraint_rates
from kanefe.states.state import State
from random_scenes import RandomScene, Recipe
from scenes import random_state, unit_axis

Pose = tuple[np.ndarray, np.ndarray]

KINDS = (
    "revolute",
    "prismatic",
    "cylindrical",
    "universal",
    "spherical",
    "planar",
    "fixed",
    "screw",
    "translation",
    "distance",
    "gear",
    "wheel",
    "ball",
)


class LoopScene(RandomScene):
    """A random tree with `loops` constraints, some of them twice."""

    def __init__(self, recipe: Recipe, loops: int) -> None:
        super().__init__(recipe)
        self.tree = RandomScene(recipe).scene.freeze()
        self.start = State(self.tree, 0.0, self.tree.initial_coordinates, self.tree.initial_speeds)
        for i in range(min(loops, 1 + self.tree.free_count // 8)):
            self._add_loop(self._random(4, i), f"l{i}")

    def frozen(self) -> Model | None:
        """Return the model; None if a drive moves what the loops hold."""
        try:
            return self.scene.freeze()
        except kf.ModelError as error:
            if "no speeds at the start" not in str(error):
                raise
            return None

    def pose(self, frame: Frame) -> Pose:
        """Return position and A_NF of a frame at the start."""
        F = self.start.marker(self.scene._marker(frame, "a place"))
        return F.p_NoFo_N, F.A_NF

    def frame_at(self, carrier: Frame, pose: Pose) -> Frame:
        """Return the frame of a carrier that is at a pose at the start."""
        p, A = self.pose(carrier)
        at = A.T @ (pose[0] - p)
        return (
            carrier.frame(at=at) if carrier.is_node else carrier.frame(at, euler_parameters_from_matrix(A.T @ pose[1]))
        )

    def _add_loop(self, rng: np.random.Generator, name: str) -> None:
        kind = KINDS[int(rng.integers(len(KINDS)))]
        if kind == "gear" and self._add_gear(rng, name):
            return
        is_point = kind in ("distance", "spherical", "gear")
        a = self.frame(rng, points=is_point)
        others = [F for F in (*self.carriers[1:], *(self.points if is_point else ())) if F.number != a.number]
        if not others:
            return
        carrier = others[int(rng.integers(len(others)))]
        if kind in ("distance", "gear"):
            b = carrier.frame(at=rng.uniform(-0.3, 0.3, 3))
            self.scene.add_distance(name, a, b, float(np.linalg.norm(self.pose(a)[0] - self.pose(b)[0])))
        elif kind in ("wheel", "ball"):
            self._add_rolling(rng, name, kind, a, carrier)
        else:
            b = self.frame_at(carrier, self.pose(a))
            self.scene.add_loop_joint(name, _loop_joint(rng, kind), a, b)
            if rng.uniform() < 0.3:  # rows that say it again
                again = kf.Spherical() if kind in ("revolute", "universal", "fixed") else _loop_joint(rng, "planar")
                if kind in ("planar", "fixed", "revolute", "universal"):
                    self.scene.add_loop_joint(f"{name} again", again, a, b)

    def _add_gear(self, rng: np.random.Generator, name: str) -> bool:
        found: list[Any] = [
            (body, i)
            for body in self.bodies
            for i in range(len(self.joints[body.name].speed_names))
            if isinstance(self.joints[body.name], ScalarJoint)
        ]
        if len(found) < 2:
            return False
        chosen = rng.permutation(len(found))[: int(rng.integers(2, 4))]
        self.scene.add_gear(name, {found[i]: float(rng.uniform(0.5, 2.0)) for i in chosen})
        return True

    def _add_rolling(self, rng: np.random.Generator, name: str, kind: str, hub: Frame, floor: Frame) -> None:
        if hub.number < 0:
            hub, floor = floor, hub
        p, A = self.pose(hub)
        normal, axle, radius = unit_axis(rng), A[:, 2], rng.uniform(0.1, 0.4)
        across = normal - (normal @ axle) * axle
        down = across / np.linalg.norm(across) if kind == "wheel" else normal
        x = np.cross(normal, unit_axis(rng))
        x /= np.linalg.norm(x)
        plane = np.column_stack((x, np.cross(normal, x), normal))
        at = self.frame_at(floor, (p - radius * down + rng.uniform(-1, 1) * x, plane))
        if kind == "wheel":
            self.scene.add_rolling_wheel(name, hub, radius, at)
        else:
            self.scene.add_rolling_ball(name, hub, radius, at)


def _loop_joint(rng: np.random.Generator, kind: str) -> kf.Joint:
    axis = unit_axis(rng)
    axes = {"revolute": kf.Revolute, "prismatic": kf.Prismatic, "cylindrical": kf.Cylindrical}
    if kind in axes:
        return axes[kind](axis)
    if kind == "screw":
        return kf.Screw(axis, lead=float(rng.uniform(-1, 1)))
    if kind == "universal":
        return kf.Universal(axis, np.cross(axis, unit_axis(rng)) + 0.2 * axis)
    return {"spherical": kf.Spherical, "planar": kf.Planar, "fixed": kf.Fixed, "translation": kf.Translation}[kind]()


def closed_state(model: Model, seed: int) -> tuple[np.ndarray, np.ndarray] | None:
    """Return a random state near the start at which the loops are closed and stay closed, at t = 0.

    None if there is none: a drive moves what the loops hold, or a random loop locks up beside its start.
    """
    rng = np.random.default_rng(seed)
    q, u = random_state(model, seed, amplitude=0.02, speed=0.5)
    start, step = model.initial_coordinates, 0.1 * rng.standard_normal(model.free_count)
    for body in model.bodies:
        if body.flexible is not None:
            step[body.flexible.speeds] = q[body.flexible.eta] - start[body.flexible.eta]
    try:
        q = project_positions(model, 0.0, model.advance(start, step))
    except SimulationError:
        return None
    u = project_speeds(model, 0.0, q, u)
    J = constraint_jacobian(model, q, u)
    slip = J @ model.all_speeds(0.0, u)[: J.shape[1]]
    return (q, u) if abs(slip).max(initial=0.0) < 1e-9 else None


def constraint_jacobian(model: Model, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Return J of all rows over free and driven speeds, at t = 0."""
    return constraint_rates(State(model, 0.0, q, u)).J
