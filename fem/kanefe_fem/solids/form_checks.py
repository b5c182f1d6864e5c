"""Checks of matrices from forms of the user: symmetric, positive, and without resistance to rigid motions.

A body in a scene moves freely, and its joints and supports hold it: what K or C do to a rigid motion would be a hidden
support. An added mass has its own inertia in each rigid motion, which Kirchhoff's equations take.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from kanefe.errors import ModelError
from kanefe.fe_model.factorise import Factorise
from kanefe.fe_model.model import FiniteElementModel
from kanefe_fem._petsc import SMALL

ROUND_OFF = 1e-9
"""Asymmetry or negative eigenvalue, relative to the largest entry, that counts as round-off of an assembly."""

RESISTED = 1e-8
"""Force against a unit rigid motion, relative to the largest row, that counts as round-off and quadrature."""

DENSE = 600
"""Number of rows up to which eigenvalues are computed with dense matrices."""

MOTIONS = ("translation x", "translation y", "translation z", "rotation x", "rotation y", "rotation z")


def check_stiffness(model: FiniteElementModel, K: sp.csr_matrix, factorise: Factorise) -> sp.csr_matrix:
    """Return K of a form, symmetrised; raise a ModelError if it is not that of a free elastic body."""
    K = _symmetric(K, "stiffness")
    remedy = (
        "a stress that vanishes for a rotation, such as of f.strain(u) and not of grad(u); a prestress in balance "
        "without loads, or kanefe_fem.Preload for one that loads hold; springs to ground as loads of the scene"
    )
    _free_of_rigid_motions(model, K, "stiffness", remedy)
    _not_negative(K, "stiffness", "moduli above zero; a compression below the buckling load", factorise)
    return K


def check_damping(model: FiniteElementModel, C: sp.csr_matrix, factorise: Factorise) -> sp.csr_matrix:
    """Return C of a form, symmetrised; raise a ModelError if it is not the damping of a deformation."""
    C = _symmetric(C, "damping")
    remedy = "a form of f.strain(u); a drag of the body is a load of the scene, since C never damps rigid motion"
    _free_of_rigid_motions(model, C, "damping", remedy)
    _not_negative(C, "damping", "viscosities above zero", factorise)
    return C


def check_mass(Ms: sp.csr_matrix) -> sp.csr_matrix:
    """Return the scalar mass matrix of a form, symmetrised; raise a ModelError if it is not positive definite."""
    Ms = _symmetric(Ms, "mass")
    diagonal = Ms.diagonal()
    if diagonal.min() > 0.0:
        scale = sp.diags(1.0 / np.sqrt(diagonal))
        lowest = _lowest(scale @ Ms @ scale)  # of Lagrange elements above 0.1, whatever the mesh
        if lowest > ROUND_OFF:
            return Ms
        raise ModelError(
            f"the form of the mass is not positive: a motion has {lowest:.3g} of the mass of its nodes. Remedy: a "
            "density above zero everywhere; an inertia in one direction alone is an added_mass"
        )
    raise ModelError(
        f"the form of the mass is not positive: the node with the least has {diagonal.min():.3g} kg. Remedy: a density "
        "above zero in every cell"
    )


def check_fluid(A: sp.csr_matrix, factorise: Factorise) -> sp.csr_matrix:
    """Return the added mass of a form, symmetrised; raise a ModelError if it is negative in some motion."""
    A = _symmetric(A, "added mass")
    _not_negative(A, "added mass", "a mass above zero, and the same function of f.u and f.v", factorise)
    return A


def _symmetric(A: sp.csr_matrix, what: str) -> sp.csr_matrix:
    if not np.all(np.isfinite(A.data)):
        raise ModelError(
            f"the matrix of the form of the {what} has {np.sum(~np.isfinite(A.data))} entries that are not finite. "
            "Remedy: check divisions and roots in the form"
        )
    error, largest = abs(A - A.T).max(), abs(A).max()
    if error > ROUND_OFF * largest:
        raise ModelError(
            f"the form of the {what} is not symmetric: entries differ from their mirrors by up to "
            f"{error / largest:.2g} of the largest. Remedy: exchange of the two functions must give the same form, "
            "such as stress(u) : strain(v) with symmetric moduli"
        )
    return (0.5 * (A + A.T)).tocsr()


def _free_of_rigid_motions(model: FiniteElementModel, A: sp.csr_matrix, what: str, remedy: str) -> None:
    R, kept = model.unit_rigid_modes()
    scale = spla.norm(A, np.inf)
    forces = np.linalg.norm(A @ R, axis=0) / (scale or 1.0)
    worst = int(np.argmax(forces))
    if forces[worst] > RESISTED:
        raise ModelError(
            f"the form of the {what} resists the rigid {MOTIONS[kept[worst]]} of the body (by {forces[worst]:.2g} of "
            f"its largest row). Remedy: {remedy}"
        )


def _not_negative(A: sp.csr_matrix, what: str, remedy: str, factorise: Factorise) -> None:
    """Raise a ModelError if a symmetric matrix has an eigenvalue below zero, scaled by its diagonal."""
    diagonal = A.diagonal()
    largest = diagonal.max(initial=0.0)
    rows = np.flatnonzero(diagonal > ROUND_OFF * largest)
    lowest = float(diagonal.min(initial=0.0)) / (largest or 1.0)
    if lowest >= -ROUND_OFF and len(rows):
        scale = sp.diags(1.0 / np.sqrt(diagonal[rows]))
        scaled = sp.csc_matrix(scale @ A[rows][:, rows] @ scale)
        if len(rows) > DENSE and _has_factors(scaled + 1e-8 * sp.identity(len(rows), format="csc"), factorise):
            return
        lowest = _lowest(scaled)
    if lowest < -1e-8:
        raise ModelError(
            f"the form of the {what} is not positive: it has the eigenvalue {lowest:.3g} beside 1 of its diagonal. "
            f"Remedy: {remedy}"
        )


def _has_factors(matrix: sp.csc_matrix, factorise: Factorise) -> bool:
    """Return whether a matrix is positive definite, by the signs of its pivots."""
    try:
        if matrix.shape[0] > SMALL:
            factorise(matrix)  # MUMPS counts them
            return True
        whole = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
        return bool(spla.splu(matrix, permc_spec="MMD_AT_PLUS_A", **whole).U.diagonal().min() > 0.0)
    except (ModelError, RuntimeError):
        return False


def _lowest(matrix: sp.spmatrix) -> float:
    """Return the lowest eigenvalue of a symmetric matrix, roughly."""
    size: Sequence[int] = matrix.shape
    if size[0] <= DENSE:
        return float(scipy.linalg.eigh(matrix.toarray(), eigvals_only=True, subset_by_index=(0, 0))[0])
    start = np.random.default_rng(0).standard_normal(size[0])
    try:
        return float(spla.eigsh(matrix, k=1, which="SA", tol=1e-3, v0=start, return_eigenvectors=False)[0])
    except spla.ArpackNoConvergence as problem:
        return float(min(problem.eigenvalues, default=0.0))
