"""Constants of a flexible body for the kernels: its mass moments in modes of unit mass, in the kernels' order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.frames import Matrix
from kanefe.storage.scipy_later import scipy
from kanefe.tree.body_terms import FlexibleTerms

if TYPE_CHECKING:
    from kanefe.bodies.wet_moments import WetMoments
    from kanefe.loads.field_load import FieldLoad

PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
AXES = ((1, 2), (2, 0), (0, 1))

ROUND_OFF = 1e-12
"""Largest off-diagonal entry, relative to the largest diagonal one, of a matrix that is diagonal up to round-off."""


@dataclass(frozen=True, eq=False)
class ModalConstants:
    """What the kernels need of a body.

    Attributes
    ----------
    constants : tuple of ndarray
        Mass, first and second moments, diagonal of K, and the moments with the modes.
    transform : (ndarray, ndarray) or None
        L and L^-1, each (k, k): the modes are L^T eta, with M the identity and K diagonal. None: they are eta.
    damping : ndarray or None, shape (k, k)
        C where there is any.
    quadratic : ndarray or None, shape (k, 6 k)
        Moments G of the second-order displacement, and the part of the products that gives Coriolis forces.
    fluid : tuple of ndarray or None
        Added mass of G, and between G and the modes, where there is a fluid.
    """

    constants: tuple[np.ndarray, ...]
    transform: tuple[Matrix, Matrix] | None
    damping: Matrix | None
    quadratic: Matrix | None
    fluid: tuple[np.ndarray, ...] | None = None

    @property
    def count(self) -> int:
        """How many modes there are."""
        return len(self.constants[3])

    def of_interface(self, motion: Matrix) -> Matrix:
        """Return the motion of an interface (6, k) from the modes of unit mass."""
        return motion if self.transform is None else motion @ self.transform[1].T

    def of_bending(self, quadratic: Matrix) -> Matrix:
        """Return second-order motions (m, k, k) in modes of unit mass, as (k, m k)."""
        if self.transform is not None:
            quadratic = self.transform[1] @ quadratic @ self.transform[1].T
        return side_by_side(quadratic)

    def of_field(self, load: FieldLoad, k: int) -> tuple[Any, ...]:
        """Return the constants of a distributed load for the modes of unit mass."""
        pattern = load.pattern
        shapes = pattern.pressure_elastic[:k] if load.is_pressure else pattern.shape_first[:, :k]
        shapes = shapes if self.transform is None else shapes @ self.transform[1].T
        if load.is_pressure:
            return pattern.pressure_force, pattern.pressure_moment, shapes
        return pattern.measure, pattern.first, shapes

    def of_following(self, change: Matrix, k: int) -> tuple[Matrix, Matrix]:
        """Return the change (6 + K, K) of the forces of a pressure, of its resultants (6, k) and shares (k, k)."""
        to_modes = np.eye(k) if self.transform is None else self.transform[1]
        resultants, shares = change[:6, :k] @ to_modes.T, to_modes @ change[6 : 6 + k, :k] @ to_modes.T
        return np.ascontiguousarray(resultants), np.ascontiguousarray(shares)


def modal_constants(terms: FlexibleTerms) -> ModalConstants:
    """Return the constants of a body."""
    from kanefe.bodies.mass_moments import MassMoments
    from kanefe.bodies.wet_moments import WetMoments

    moments, k = terms.free_moments, terms.body.free_count
    if not isinstance(moments, MassMoments):
        raise TypeError("the order-n route takes bodies with a mass field")
    S, D, products = moments.shape_first, moments.shape_second, moments.shape_product
    C = None if terms.damping is None else terms.damping[:k]
    diagonal, transform = _of_unit_mass(moments.elastic_mass, terms.body.stiffness[:k, :k])
    if transform is not None:
        inverse = transform[1]
        S, D = S @ inverse.T, D @ inverse.T
        products = inverse @ products @ inverse.T
        C = None if C is None else inverse @ C @ inverse.T
    symmetric = [0.5 * (products[a, b] + products[b, a]) for a, b in PAIRS]
    antisymmetric = [products[b, a] - products[a, b] for a, b in AXES]
    quadratic = None
    if moments.quadratic_first is not None and moments.quadratic_second is not None:
        first, second = moments.quadratic_first, moments.quadratic_second
        if transform is not None:
            first, second = (transform[1] @ X @ transform[1].T for X in (first, second))
        quadratic = side_by_side(np.array((*first, *antisymmetric)))
        symmetric = [X + 0.5 * (second[a, b] + second[b, a]) for X, (a, b) in zip(symmetric, PAIRS, strict=True)]
        antisymmetric = [X + second[a, b] - second[b, a] for X, (a, b) in zip(antisymmetric, AXES, strict=True)]
    columns = side_by_side(np.array((*symmetric, *antisymmetric)))
    constants = (
        np.atleast_1d(moments.mass),
        moments.first,
        0.5 * (moments.second + moments.second.T)[np.triu_indices(3)],
        diagonal,
        S,
        np.array([0.5 * (D[a, b] + D[b, a]) for a, b in PAIRS]),
        np.array([D[a, b] - D[b, a] for a, b in AXES]),
        columns.ravel(),
    )
    fluid = _of_fluid(moments, transform) if isinstance(moments, WetMoments) else None
    return ModalConstants(constants, transform, C, quadratic, fluid)


def _of_fluid(moments: WetMoments, transform: tuple[Matrix, Matrix] | None) -> tuple[np.ndarray, ...]:
    """Return the added mass in the kernels' order: of translation, between it and rotation, of rotation, of modes."""
    A, with_modes = moments.fluid[:6, :6], moments.fluid[:6, 6:]
    with_modes = with_modes if transform is None else with_modes @ transform[1].T
    upper = np.triu_indices(3)
    return A[:3, :3][upper], A[:3, 3:].ravel(), A[3:, 3:][upper], with_modes[:3], with_modes[3:]


def _of_unit_mass(mass: Matrix, K: Matrix) -> tuple[np.ndarray, tuple[Matrix, Matrix] | None]:
    """Return the stiffnesses of modes of unit mass, and what makes these of coordinates; None: they are the same."""
    if are_modes_of_unit_mass(mass, K):
        return np.diag(K), None
    diagonal, modes = scipy.linalg.eigh(K, mass)
    return diagonal, (mass @ modes, modes.T)


def are_modes_of_unit_mass(mass: Matrix, K: Matrix) -> bool:
    """Return whether M of some coordinates is the identity, and their K diagonal."""
    diagonal = np.diag(K)
    return not len(K) or bool(
        np.abs(mass - np.eye(len(K))).max() <= ROUND_OFF
        and np.abs(K - np.diag(diagonal)).max() <= ROUND_OFF * diagonal.max()
    )


def side_by_side(matrices: Matrix) -> Matrix:
    """Return matrices (m, k, k) as (k, m k): row j is column j of each of them, so that x^T of it is each times x."""
    m, k = matrices.shape[:2]
    return np.ascontiguousarray(matrices.transpose(2, 0, 1)).reshape(k, m * k)
