"""Outputs of a model at a state: its energies, and the motion of a frame."""

from __future__ import annotations

from typing import NamedTuple

from kanefe.frames import Matrix, Vector


class MechanicalEnergy(NamedTuple):
    """Energies of a state in J; `gravity` is zero with every centre of mass at N's origin."""

    kinetic: float
    elastic: float
    gravity: float

    @property
    def total(self) -> float:
        """Their sum."""
        return self.kinetic + self.elastic + self.gravity


class FrameKinematics(NamedTuple):
    """Position and motion of a frame F.

    Attributes
    ----------
    position : ndarray, shape (3,)
        In N, m.
    rotation : ndarray, shape (3, 3)
        A_NF.
    velocity, angular_velocity : ndarray, shape (3,)
        In components of F, m/s and rad/s.
    partial_velocities, partial_angular_velocities : ndarray, shape (3, free)
        V and W: Jacobians of the velocities with respect to the free speeds, in components of F.
    """

    position: Vector
    rotation: Matrix
    velocity: Vector
    angular_velocity: Vector
    partial_velocities: Matrix
    partial_angular_velocities: Matrix
