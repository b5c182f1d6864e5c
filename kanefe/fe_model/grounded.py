"""Stiffness that resists rigid turns: springs from rotations to the ground, and elements that are not free to turn.

A spring to ground at a rotation, such as PARAM,K6ROT of MYSTRAN at each node of a shell, answers a rigid rotation of
the nodes by moments alone. A support answers by forces, and so does a wrong order of the nodes, to rigid rotations.
Quadrangles that are warped and were made for flat ones (OpenSees' ShellMITC4, ShellDKGQ) answer to rigid rotations too,
but little.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.fe_model.model import ROTATIONS, FiniteElementModel

BESIDE = 1e-3
"""Unbalanced forces times the size of the body, relative to unbalanced moments, up to which they count as none."""

LEAST = 1e-13
"""Unbalanced moments relative to their terms below which they are round-off of double precision."""


class GroundSprings(NamedTuple):
    """Springs from rotations to the ground.

    Attributes
    ----------
    nodes : ndarray of int
        Nodes that have some.
    stiffness : float
        Largest moment of all for a rigid rotation of the nodes by 1 rad, N m.
    square : float
        Largest squared angular frequency of a rigid rotation against them, by the diagonal of M, (rad/s)2.
    """

    nodes: np.ndarray
    stiffness: float
    square: float

    def __str__(self) -> str:
        named = ", ".join(str(n) for n in self.nodes[:4]) + (", ..." if len(self.nodes) > 4 else "")
        return (
            f"a rigid rotation by 1 rad is resisted by {self.stiffness:.3g} N m, by moments and no forces: springs to "
            f"ground at the rotations of {len(self.nodes)} node(s) ({named}), such as PARAM,K6ROT of MYSTRAN makes. "
            "Remedy: export without them"
        )


class ResistedTurns(NamedTuple):
    """Forces of elements that a rigid rotation of all nodes strains.

    Attributes
    ----------
    stiffness, square : float
        As of `GroundSprings`.
    """

    stiffness: float
    square: float

    def __str__(self) -> str:
        return (
            f"a rigid rotation by 1 rad is resisted by {self.stiffness:.3g} N m, and translations are free, as of "
            "warped quadrangles of shells that were made for flat ones. Remedy: triangles there, or elements that turn "
            "freely"
        )


def resisted_turns(model: FiniteElementModel) -> ResistedTurns:
    """Return how much rigid rotations of the nodes are resisted."""
    R = model.rigid_modes(about=tuple(model.nodes.mean(axis=0)))[:, 3:]
    energies = np.einsum("ij,ij->j", R, model.stiffness @ R)
    masses = np.einsum("ij,i,ij->j", R, model.mass.diagonal(), R)
    squares = energies / np.where(masses > 0.0, masses, np.inf)
    return ResistedTurns(float(energies.max()), float(squares.max()))


def ground_springs(model: FiniteElementModel) -> GroundSprings | None:
    """Return the springs from rotations of nodes to the ground, if rigid motions raise moments and no forces."""
    R = model.rigid_modes(about=tuple(model.nodes.mean(axis=0)))
    turning = np.zeros(model.size, dtype=bool)
    turning[: model.nodal_size] = np.tile(np.isin(model.components, ROTATIONS), len(model.nodes))
    size = np.ptp(model.nodes, axis=0).max()
    answered = model.stiffness @ R
    # forces and moments for translations by the size of the body and for turns by 1 rad, all in N m
    work = abs(answered) * np.where(turning, 1.0, size)[:, None] * np.repeat((size, 1.0), 3)
    moments = work[turning, 3:].sum()
    terms = (abs(model.stiffness) @ abs(R))[turning, 3:]
    is_noise = abs(answered[turning, 3:]).max(initial=0.0) <= LEAST * terms.max(initial=0.0)
    if is_noise or work.sum() - moments > BESIDE * moments:
        return None
    rows = np.flatnonzero(turning & (abs(answered).max(axis=1) > 1e-6 * abs(answered[turning]).max()))
    return GroundSprings(np.unique(rows // len(model.components)), *resisted_turns(model))
