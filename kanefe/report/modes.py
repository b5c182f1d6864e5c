"""Modes of a flexible body with its fixed interfaces held: frequencies, effective masses, shares of compliance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from kanefe.bodies.flexible import FlexibleBody


@dataclass(frozen=True, eq=False)
class BodyModes:
    """Modes of the free coordinates, lowest first.

    Attributes
    ----------
    frequencies : ndarray, shape (k,)
        Hz.
    shapes : ndarray, shape (k, k)
        Mass-normalised columns in the free coordinates.
    damping_ratios : ndarray, shape (k,)
        Of the diagonal of modal damping.
    participation : ndarray, shape (6, k)
        L = R^T M phi, R the rigid motions of the body: translations (kg^1/2) and rotations about the origin of G
        (kg^1/2 m). Their squares are the effective masses.
    rigid : ndarray, shape (6,)
        Mass, mass, mass, and the moments of inertia about the origin of G: the totals of the effective masses.
    mass_condition, stiffness_condition : float
        Condition numbers of M and K of the free coordinates.
    """

    frequencies: np.ndarray
    shapes: np.ndarray
    damping_ratios: np.ndarray
    participation: np.ndarray
    rigid: np.ndarray
    mass_condition: float
    stiffness_condition: float

    @property
    def effective_shares(self) -> np.ndarray:
        """Effective masses as shares of the whole, shape (6, k)."""
        return np.asarray(self.participation**2 / np.where(self.rigid > 0.0, self.rigid, np.inf)[:, None])


def body_modes(body: FlexibleBody) -> BodyModes:
    """Return the modes of a reduced body (dense in its free coordinates)."""
    k = body.free_count
    K, M = body.stiffness[:k, :k], body.moments.elastic_mass[:k, :k]
    squares, shapes = scipy.linalg.eigh(K, M) if k else (np.zeros(0), np.zeros((0, 0)))
    omega = np.sqrt(np.maximum(squares, 0.0))
    damping = np.einsum("ik,ij,jk->k", shapes, body.damping, shapes)
    ratios = np.divide(damping, 2.0 * omega, out=np.zeros(k), where=omega > 0.0)
    zero = np.zeros(body.count)
    generalised, _ = body.moments.terms(zero, zero, np.zeros(3))
    return BodyModes(
        frequencies=omega / (2.0 * np.pi),
        shapes=shapes,
        damping_ratios=ratios,
        participation=generalised[:6, 6 : 6 + k] @ shapes,
        rigid=np.diag(generalised)[:6].copy(),
        mass_condition=_condition(M),
        stiffness_condition=_condition(K),
    )


def interface_masses(body: FlexibleBody, modes: BodyModes) -> np.ndarray:
    """Return the effective masses of every fixed interface component, shape (fixed, k), in kg and kg m2.

    ``(phi_i^T M psi_j)^2`` with psi_j the static shape of a unit motion of the component alone.
    """
    k = body.free_count
    return np.asarray((body.moments.elastic_mass[k:, :k] @ modes.shapes) ** 2)


def compliance_shares(motion: np.ndarray, modes: BodyModes) -> np.ndarray:
    """Return the share of each mode in the static compliance of an interface's components, shape (6, k).

    ``(N phi_i)^2 / w_i^2`` over its sum, with the motion N (6, k) of the interface; zero where nothing moves.
    """
    squares = (2.0 * np.pi * modes.frequencies) ** 2
    parts = (motion @ modes.shapes) ** 2 / np.where(squares > 0.0, squares, np.inf)
    total = parts.sum(axis=1, keepdims=True)
    return np.divide(parts, total, out=np.zeros_like(parts), where=total > 1e-12 * total.max(initial=0.0))


def _condition(matrix: np.ndarray) -> float:
    if not len(matrix):
        return 1.0
    values = np.linalg.eigvalsh(matrix)
    return float(values[-1] / values[0]) if values[0] > 0.0 else float("inf")
