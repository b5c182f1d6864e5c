"""The frame that carries a scene, and its motion at many times, as a rigid displacement of space."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.joints.given_pose import PoseDriven, PoseRates
from kanefe.joints.motion import Motion, of_body
from kanefe.joints.pose_table import PoseTable
from kanefe.tree.body_terms import BodyTerms


@cache
def still_pose() -> PoseTable:
    """Return a constant pose."""
    return PoseTable(np.arange(4.0), np.zeros((4, 3)))


@dataclass(frozen=True, eq=False)
class Displacement:
    """``p -> x + R p`` of all points at some times, T of them, with its rates.

    Attributes
    ----------
    x, v, a : ndarray, shape (T, 3)
        m, m/s, m/s2.
    R : ndarray, shape (T, 3, 3)
    w, dw : ndarray, shape (T, 3)
        Angular velocity and acceleration in axes rotated by R, rad/s, rad/s2.
    """

    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    R: np.ndarray
    w: np.ndarray
    dw: np.ndarray

    def seen_from(self, p: Vector, A: np.ndarray) -> Displacement:
        """Return the displacement in axes A with origin p."""
        if not p.any() and np.array_equal(A, np.eye(3)):
            return self
        arm = np.einsum("tij,j->ti", self.R, p)
        w, dw = (np.einsum("tij,tj->ti", self.R, item) for item in (self.w, self.dw))
        spin = np.cross(w, arm)
        rates = (self.x + arm - p, self.v + spin, self.a + np.cross(dw, arm) + np.cross(w, spin))
        x, v, a = (found @ A for found in rates)
        return Displacement(x, v, a, np.einsum("ji,tjk,kl->til", A, self.R, A), self.w @ A, self.dw @ A)


class Carrier:
    """The one frame of a scene that is driven from the ground.

    Parameters
    ----------
    model : Model

    Raises
    ------
    ModelError
        If there is none, or anything else is driven too.
    """

    def __init__(self, model: Model) -> None:
        driven = [body for body in model.bodies if body.is_driven]
        if len(driven) != 1 or driven[0].parent != -1 or len(driven[0].driven) != len(driven[0].coordinates):
            listed = ", ".join(repr(body.name) for body in driven) or "nothing"
            raise ModelError(
                f"a screened run needs a scene on one frame that is driven from the ground; driven here: {listed}. "
                "Remedy: kf.System.simulate"
            )
        self.body: BodyTerms = driven[0]
        self.number = model.bodies.index(self.body)
        at = np.zeros(1)
        joint = self._stilled().joint
        start = joint.pose(np.zeros(len(joint.coordinate_names)) if not isinstance(joint, PoseDriven) else at)
        self._p0 = self.body.p_PoFo_P + self.body.A_PF @ start[0]
        self._A0 = self.body.A_PF @ start[1]

    def _stilled(self) -> BodyTerms:
        joint = self.body.joint
        if isinstance(joint, PoseDriven):
            return replace(self.body, joint=replace(joint, given=still_pose()))
        still = Motion.steady(0.0, 0.0)
        motion = still if len(joint.coordinate_names) == 1 else (still,) * len(joint.coordinate_names)
        held: Any = replace(joint, motion=motion)  # type: ignore[type-var,call-arg]
        return replace(self.body, joint=held)

    def stilled(self, model: Model) -> Model:
        """Return the model with the carrier at rest at zero coordinates."""
        bodies = list(model.bodies)
        bodies[self.number] = self._stilled()
        return replace(model, bodies=tuple(bodies))

    def over(self, times: Vector) -> Displacement:
        """Return the displacement of the carrier from its pose at zero coordinates, at times in s."""
        given = self._rates(times)
        A_PF, p = self.body.A_PF, given.position @ self.body.A_PF.T + self.body.p_PoFo_P
        v, a = given.velocity @ A_PF.T, given.acceleration @ A_PF.T
        A = A_PF @ given.axes
        R = A @ self._A0.T
        w, dw = given.angular_velocity @ self._A0.T, given.angular_acceleration @ self._A0.T
        w_N, dw_N = (np.einsum("tij,tj->ti", R, item) for item in (w, dw))
        arm = R @ self._p0
        spin = np.cross(w_N, arm)
        return Displacement(p - arm, v - spin, a - np.cross(dw_N, arm) - np.cross(w_N, spin), R, w, dw)

    def _rates(self, times: Vector) -> PoseRates:
        joint = self.body.joint
        if isinstance(joint, PoseDriven):
            return joint.given.over(times)
        found = []
        for t in times.tolist():
            q, u, du = (
                np.array(
                    [motion.at(kind, t, of_body(self.body.name)) for motion in joint.motions if motion is not None]
                )
                for kind in ("position", "velocity", "acceleration")
            )
            (p, A), (V, W), (v, w) = joint.pose(q), joint.partial_velocities(q), joint.remainders(q, u)
            found.append(PoseRates(p, V @ u, V @ du + v, A, A.T @ (W @ u), A.T @ (W @ du + w)))
        return PoseRates(*(np.array(column) for column in zip(*found, strict=True)))
