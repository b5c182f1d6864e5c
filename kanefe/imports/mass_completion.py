"""The mass field of a superelement: exact as far as M determines it, the rest estimated.

A superelement has M and K for motions Psi_i of nodes of its boundary and of generalised coordinates (fixed-boundary
modes), but no longer the body itself. With the rigid motions R of the nodes, M gives ``int rho Psi_i``,
``int rho X x Psi_i``, mass, centre of mass and inertia, and ``int rho Psi_i . Psi_j``: all terms of the equations at
rest. The further terms for a rotating, deformed body (the single components of ``int rho X_a Psi_b,i`` and
``int rho Psi_a,i Psi_b,j``) were lost in the reduction. They are estimated by the decomposition

    Psi_i = R r_i + Psi'_i,    r_i = (R^T M R)^-1 R^T M Psi_i,

of each motion into the rigid one with its momenta, whose products are known exactly, and a rest without momenta. For
the rest, the part of ``X_a Psi'_b`` that is symmetric in a and b is that of the static shape with a uniform strain of
the nodes, and the products ``M' = M - r^T R^T M R r`` are distributed equally over the three directions.

The matrices of the body at rest, its momenta and energy are exact. Of the terms of the order of the deformation times
the square of the angular velocity, those of the rest are estimates: for the lowest modes of a slender body the rest is
some percent.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from kanefe.bodies.mass_moments import MassMoments
from kanefe.fe_model.model import TRANSLATIONS, FiniteElementModel, MassField
from kanefe.frames import skew
from kanefe.imports.rest_of_mass import affine_moments, inverse_inertia


def completed_mass_field(model: FiniteElementModel) -> MassField:
    """Return the mass field of a superelement with three translations per node, in all of its degrees of freedom."""
    return abstract_field(completed_moments(model))


def estimated_part(model: FiniteElementModel) -> float:
    """Return the mean part of the energy of the generalised coordinates that is of motions without momenta."""
    R = model.rigid_modes()
    momenta = R.T @ model.mass
    carried = np.einsum("ai,ai->i", momenta, inverse_inertia(momenta @ R) @ momenta)
    energy = model.mass.diagonal()
    own = np.flatnonzero(energy[model.nodal_size :] > 0.0) + model.nodal_size
    return float(1.0 - (carried[own] / energy[own]).mean()) if len(own) else 0.0


def completed_moments(model: FiniteElementModel) -> MassMoments:
    """Return the mass moments of all N degrees of freedom of a superelement: see the description of this module."""
    M, R = model.mass.toarray(), model.rigid_modes()
    momenta = R.T @ M  # (6, N)
    rigid = momenta @ R
    gram = affine_moments(rigid)
    carried = inverse_inertia(rigid) @ momenta
    rest = np.eye(model.size) - R @ carried

    # coefficients of the rigid parts in the functions 1, X_0, X_1, X_2: (3, 4, N)
    parts = np.zeros((3, 4, model.size))
    parts[:, 0] = carried[:3]
    parts[:, 1:] = np.stack([skew(turn) for turn in carried[3:].T], axis=2)
    weighted = np.einsum("de,beN->dbN", gram, parts)  # inner products with 1 and X_a, (4, 3, N)

    strains = _strained(model)
    seen = np.einsum("abN,NK->abK", strains @ M, rest)  # (3, 3, N), symmetric in a and b
    cross = np.einsum("adI,dbJ->abIJ", parts[:, 1:], seen)
    remaining = M - carried.T @ rigid @ carried
    product = np.einsum("aeI,ebJ->abIJ", parts, weighted) + cross + cross.transpose(1, 0, 3, 2)
    product += np.einsum("ab,IJ->abIJ", np.eye(3) / 3.0, 0.5 * (remaining + remaining.T))
    return MassMoments(gram[0, 0], gram[0, 1:], gram[1:, 1:], momenta[:3], weighted[1:] + seen, product)


def _strained(model: FiniteElementModel) -> np.ndarray:
    """Return the static motions with nodes displaced by a unit strain, other coordinates free, (3, 3, N)."""
    width, count = len(model.components), len(model.nodes)
    places = [model.components.index(c) for c in TRANSLATIONS]
    held = (width * np.arange(count)[:, None] + places).ravel()
    free = np.setdiff1d(np.arange(model.size), held)
    K = model.stiffness.toarray()
    points = model.nodes - model.nodes.mean(axis=0)
    found = np.zeros((3, 3, model.size))
    follow = -np.linalg.pinv(K[np.ix_(free, free)], rcond=1e-12, hermitian=True) @ K[np.ix_(free, held)]
    for a in range(3):
        for b in range(a + 1):
            field = np.zeros((count, 3))
            field[:, a] += 0.5 * points[:, b]
            field[:, b] += 0.5 * points[:, a]
            found[a, b, held] = field.ravel()
            found[a, b, free] = follow @ field.ravel()
            found[b, a] = found[a, b]
    return found


def abstract_field(moments: MassMoments) -> MassField:
    """Return a mass field with given moments.

    The constant, the coordinates X_a and the shapes Phi_a,i are functions on the body, and the moments are their
    inner products. In the basis (1 - sum of all others, X_a, Phi_a,i) the constant has the coefficients 1, X_a and
    Phi_a,i unit vectors, and the Gram matrix is the mass matrix: 4 + 3 k abstract points replace the mesh.
    """
    count = moments.shape_first.shape[1]
    size = 4 + 3 * count
    gram = np.zeros((size, size))
    gram[0, 0] = moments.mass
    gram[0, 1:4] = moments.first
    gram[0, 4:] = moments.shape_first.reshape(-1)
    gram[1:4, 1:4] = moments.second
    gram[1:4, 4:] = moments.shape_second.reshape(3, -1)
    gram[4:, 4:] = moments.shape_product.transpose(0, 2, 1, 3).reshape(3 * count, 3 * count)
    gram = np.triu(gram) + np.triu(gram, 1).T
    change = np.eye(size)
    change[1:, 0] = -1.0
    points = np.zeros((size, 3))
    points[1:4] = np.eye(3)
    basis = np.zeros((size, 3, count))
    for a in range(3):
        basis[4 + a * count : 4 + (a + 1) * count, a] = np.eye(count)
    return MassField(points, sp.csr_matrix(change.T @ gram @ change), sp.csr_matrix(basis.reshape(3 * size, count)))
