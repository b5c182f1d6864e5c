"""Statics of bodies and their reduced modes in tied coordinates, for tests of reductions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse.linalg as spla

import kanefe as kf
from kanefe.fe_model.statics import StaticProblem
from kanefe.fe_model.ties import tie_interfaces
from kanefe.reduction import splu_factorise
from kanefe.reduction.build import unrestrained_motions
from kanefe.reduction.load_cases import LoadGroup
from kanefe.reduction.orthonormal import orthonormal_modes
from kanefe_fem.beams.body import straight_beam
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.materials.isotropic import Material


def problem_of(model: kf.FiniteElementModel, interfaces: dict) -> StaticProblem:
    """Return the statics of a body."""
    ties = tie_interfaces(model, interfaces)
    return StaticProblem(model, ties, unrestrained_motions(model, ties), splu_factorise)


def tied_modes(problem: StaticProblem, reduction: Any) -> np.ndarray:
    """Return the M-orthonormal modes of a reduction in tied coordinates, shape (tied, k)."""
    columns = reduction.basis(problem).columns
    return orthonormal_modes(columns, problem.stiffness, problem.mass, problem.rigid_modes, problem.largest_masses)


def pendulum_beam(elements: int = 8) -> tuple[kf.FiniteElementModel, dict, float]:
    """Return C01's beam, its supports, and a highest frequency in Hz."""
    aluminium = Material(E=70e9, nu=0.3, rho=2700.0)
    model = straight_beam(1.0, Rectangle(width=0.005, height=0.02), aluminium, elements=elements, planar=True)
    return model, {"root": "clamped"}, 20.0


def crank_rod(elements: int = 6) -> tuple[kf.FiniteElementModel, dict, float]:
    """Return C06's rod in the frame of its chord, its supports, and twice the frequency of its crank in Hz."""
    steel = Material(E=200e9, nu=0.3, rho=7870.0)
    model = straight_beam(
        0.3,
        Rectangle(width=0.008, height=0.008),
        steel,
        elements=elements,
        theory="euler-bernoulli",
        rotary_inertia=False,
        planar=True,
    )
    held = kf.Interface(fixed=("x", "y"))
    return model, {"root": held, "tip": held}, 150.0 / np.pi


def hinged_bar(elements: int = 5) -> tuple[kf.FiniteElementModel, dict, float]:
    """Return the bar of S3 made of beams, its supports, and a highest frequency in Hz."""
    steel = Material(E=210e9, nu=0.3, rho=7850.0)
    model = straight_beam(1.0, Rectangle(width=0.1, height=0.05), steel, elements=elements)
    return model, {"root": "clamped", "tip": "rigid"}, 50.0


def exact_errors(
    problem: StaticProblem, modes: np.ndarray, groups: Sequence[LoadGroup], up_to_frequency: float
) -> dict[tuple[str, str], float]:
    """Return the relative errors of responses by load and motion, from direct solves with the whole matrices.

    Nothing is shared with the estimate but the frequencies, and the norms that its documentation states.
    """
    moving = np.setdiff1d(np.arange(problem.size), problem.fixed)
    K, M = (m[moving][:, moving] for m in (problem.stiffness, problem.mass))
    squares = np.einsum("ij,ij->j", modes, problem.stiffness @ modes)
    extent = np.linalg.norm(np.ptp(problem.model.nodes, axis=0))
    R = problem.model.rigid_modes()[:, :3]
    mass = np.diag(R.T @ (problem.model.mass @ R)).max()
    top = 2 * np.pi * up_to_frequency
    worst: dict[tuple[str, str], float] = {}
    for s in (0.0, *(0.2 * top + 1j * np.linspace(0.0, top, 9))):
        for group in groups:
            forces = problem.relieved(group.forces)
            exact = problem.solve(group.forces).astype(complex)
            if s != 0.0:
                exact[moving] = spla.splu((K + s * s * M).astype(complex).tocsc()).solve(forces[moving].astype(complex))
            error = modes @ ((modes.T @ group.forces) / (squares + s * s)[:, None]) - exact
            own, missed = (
                np.sqrt(np.einsum("ij,ij->j", u.conj(), problem.mass @ u).real / mass).max() for u in (exact, error)
            )
            shares = {"displacement": missed / own}
            for tie in problem.ties.ties:
                kinds = {"translation": ((0, 1, 2), 1.0), "rotation": ((3, 4, 5), 1.0 / extent)}
                for kind, (numbers, scale) in kinds.items():
                    rows = [
                        r
                        for r, c in zip(tie.rows, tie.components, strict=True)
                        if c in numbers and r in problem.released
                    ]
                    if rows:
                        moved = max(np.linalg.norm(exact[rows], axis=0).max(), 0.1 * own * scale)
                        shares[f"{tie.name} {kind}"] = np.linalg.norm(error[rows], axis=0).max() / moved
            for name, share in shares.items():
                worst[group.name, name] = max(worst.get((group.name, name), 0.0), float(share))
    return worst
