"""Parts of a body with losses in its reduced coordinates, and the shapes that these need.

Where parts relax or lose differently, what they pull with is no multiple of the elastic forces of a kept motion, and
its static response is no kept motion. With these responses, of the long-term stiffness, the reduced stiffness at each
frequency is that of the full one to first order in what the parts add (Rouleau, Deue & Legay, Mech. Syst. Signal
Process. 90 (2017) 178: modes with a first-order correction).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.linalg

from kanefe.bodies.relaxation import Relaxation
from kanefe.errors import ModelError
from kanefe.fe_model.model import FiniteElementModel
from kanefe.fe_model.statics import StaticProblem

PROPORTIONAL = 1e-8
"""Part of the forces of a lossy part, across the elastic ones and relative to them, that needs no shapes of its own."""

NO_STIFFNESS = 1e-12
"""Stiffness of an arm in a motion, relative to that of the body, below which it has none there."""

ROUND_OFF = 1e-11
"""Stiffness of a part between two modes, relative to that in one, that is round-off of the reduction."""


def loss_shapes(problem: StaticProblem, columns: np.ndarray) -> np.ndarray:
    """Return static responses to what each part with losses pulls with in motions (tied, m), (tied, parts m)."""
    model = problem.model
    parts = [part.stiffness for part in model.viscoelastic]
    parts += [] if model.structural is None else [model.structural]
    if not parts:
        return columns[:, :0]
    found = [columns[:, :0]]
    elastic = problem.stiffness @ columns
    sizes = np.einsum("ij,ij->j", elastic, elastic)
    for part in parts:
        pulled = problem.ties.project(part) @ columns
        alike = np.einsum("ij,ij->j", pulled, elastic) / np.where(sizes > 0.0, sizes, 1.0)
        if np.linalg.norm(pulled - alike * elastic) > PROPORTIONAL * np.linalg.norm(pulled):
            found.append(problem.solve(pulled))
    return np.hstack(found)


def relaxation_of(model: FiniteElementModel, basis: np.ndarray, stiffness: np.ndarray) -> Relaxation | None:
    """Return the arms of a body in its free coordinates; None: nothing of it relaxes.

    Parameters
    ----------
    model : FiniteElementModel
    basis : ndarray, shape (N, k)
        Motion of the degrees of freedom from the free coordinates.
    stiffness : ndarray, shape (k, k)
        Long-term stiffness over them.
    """
    if not model.viscoelastic or not basis.shape[1]:
        return None
    factors, times = [], []
    scale = np.sqrt(np.maximum(np.diag(stiffness), np.finfo(float).tiny))
    for part in model.viscoelastic:
        reduced = basis.T @ (part.stiffness @ basis) / np.outer(scale, scale)
        if np.abs(reduced - np.diag(np.diag(reduced))).max() < ROUND_OFF * np.diag(reduced).max():
            squares, vectors = np.diag(reduced), np.eye(len(reduced))  # an arm for each mode, which pulls on no other
        else:
            squares, vectors = scipy.linalg.eigh(0.5 * (reduced + reduced.T))
        if squares.min() < -1e-9 * abs(squares).max():
            raise ModelError("a viscoelastic part gives energy (its stiffness is negative). Remedy: check its signs")
        kept = squares > NO_STIFFNESS * max(squares.max(), 1.0)
        own = scale[:, None] * (vectors[:, kept] * np.sqrt(squares[kept]))
        for weight, time in zip(part.weights, part.times, strict=True):
            factors.append(np.sqrt(weight) * own)
            times.append(np.full(own.shape[1], time))
    return Relaxation(np.hstack(factors), np.concatenate(times))


def reduced_losses(model: FiniteElementModel, basis: np.ndarray, stiffness: np.ndarray) -> dict[str, Any]:
    """Return `structural` and `relaxation` of a `FlexibleBody`; parameters are those of `relaxation_of`."""
    H = None if model.structural is None else np.asarray(basis.T @ (model.structural @ basis))
    return {"structural": H, "relaxation": relaxation_of(model, basis, stiffness)}


def refuse_losses(model: FiniteElementModel) -> None:
    """Raise a ModelError if an unreduced body has losses that are kept in reduced coordinates only."""
    if model.viscoelastic or model.structural is not None:
        what = "a Prony series" if model.viscoelastic else "a loss factor"
        raise ModelError(
            f"a material of this body has {what}, which unreduced bodies do not have. Remedy: "
            "reduction=CraigBampton(), or damping of the material by RayleighDamping"
        )
