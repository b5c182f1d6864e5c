"""Springs and dampers of joints that no CoordinateForce is: polynomials, and those of free and spherical joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from kanefe.frames import Vector, euler_parameters_from_rotation_vector, rotation_matrix
from kanefe.loads.offered_function import CompiledByNumba, compiled
from kanefe.robots.pose import Pose

if TYPE_CHECKING:
    from kanefe.scene.scene import Frame
    from kanefe.system import System

Coefficients = tuple[float, float, float]


@dataclass(frozen=True)
class AxisForces:
    """``-(k1 x + k2 x^2 + k3 x^3) - (c1 v + c2 v |v| + c3 v^3)`` along a coordinate, with x from where it rests.

    MuJoCo makes the polynomial of the damper odd and that of the spring not: ``k2 x^2`` pushes one way on both sides.

    Attributes
    ----------
    stiffness, damping : tuple of float
        k1, k2, k3 and c1, c2, c3, N/m^n or N m/rad^n, and with s.
    rest : float
        m or rad.
    """

    stiffness: Coefficients
    damping: Coefficients
    rest: float = 0.0

    def put_on(self, scene: System, name: str, parent: Frame, child: str) -> None:
        """Apply them along the joint of a child."""
        reads = f"joint_coordinates {child}", f"joint_speeds {child}"
        scene.add_motor(scene.body(child), replace(_compiled(self), reads=reads))


@lru_cache(maxsize=256)
def _compiled(law: AxisForces) -> CompiledByNumba:
    """Return the function of a law, which all joints with its numbers share: numba takes a second for each."""
    (k1, k2, k3), (c1, c2, c3), rest = law.stiffness, law.damping, law.rest

    def spring_and_damper(t: float, reads: Vector) -> float:
        x, v = reads[0] - rest, reads[1]
        return -x * (k1 + x * (k2 + x * k3)) - v * (c1 + abs(v) * (c2 + abs(v) * c3))

    return compiled(spring_and_damper, reads=("coordinate", "speed"))


@dataclass(frozen=True)
class PoseForces:
    """Springs and dampers of a free or spherical joint, as MuJoCo has them.

    The spring pulls along the displacement and about the rotation vector, by ``k1 r + k2 r^2 + k3 r^3`` of their
    lengths r; the damper acts on each speed, by ``c1 v + c2 v |v| + c3 v^3``.

    Attributes
    ----------
    stiffness, damping : tuple of float
        k1, k2, k3 and c1, c2, c3: for displacements N/m^n, for rotations N m/rad^n, and with s.
    rest : Pose
        Of the moving frame in the fixed one where the spring is slack.
    translates : bool
        Whether they act on displacements too.
    """

    stiffness: Coefficients
    damping: Coefficients
    rest: Pose
    translates: bool

    def put_on(self, scene: System, name: str, parent: Frame, child: str) -> None:
        """Apply them between the fixed frame of a joint and the child, which is its moving frame."""
        moving, at_rest = scene.body(child), parent.frame(tuple(self.rest.at), self.rest.axes)
        acts = np.array([self.translates] * 3 + [True] * 3, dtype=float)
        if not is_linear_law(self.stiffness, self.damping):
            scene.add_bushing(name, at_rest, moving, law=self)
        else:
            scene.add_bushing(name, at_rest, moving, stiffness=self.stiffness[0] * acts, damping=self.damping[0] * acts)

    def __call__(self, moved: Vector, rate: Vector) -> Vector:
        """Return force and moment on the child, (6,), in the axes at rest: the law of a bushing."""
        turned = rotation_matrix(euler_parameters_from_rotation_vector(moved[3:]))
        force = np.zeros(3)
        if self.translates:
            force = self._pull(moved[:3]) + self.rest.axes.T @ self._brake(self.rest.axes @ rate[:3])
        return np.concatenate((force, self._pull(moved[3:]) + turned @ self._brake(turned.T @ rate[3:])))

    def _pull(self, x: Vector) -> Vector:
        r = float(np.linalg.norm(x))
        return -x * _polynomial(self.stiffness, r)

    def _brake(self, v: Vector) -> Vector:
        return -v * _polynomial(self.damping, abs(v))


JointForces = AxisForces | PoseForces


def is_linear_law(stiffness: Coefficients, damping: Coefficients) -> bool:
    """Return whether a CoordinateForce can be it: linear, and neither a spring nor a damper that drives."""
    return min(stiffness[0], damping[0]) >= 0.0 and not any((*stiffness[1:], *damping[1:]))


def _polynomial(coefficients: Sequence[float], x: float | Vector) -> float | Vector:
    one, two, three = coefficients
    return one + x * (two + x * three)
