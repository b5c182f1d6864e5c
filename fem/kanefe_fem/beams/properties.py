"""Stiffnesses of beam elements, and their form in a body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kanefe.fe_model.model import Elasticity


@dataclass(frozen=True, eq=False)
class ElementProperties:
    """Length and stiffnesses of m elements of either theory, of shape (m,) except for the last.

    Attributes
    ----------
    length : ndarray
        l in m.
    EA, GJ, EI_y, EI_z : ndarray
        Axial stiffness in N; torsional and bending stiffnesses in N m2.
    shear_y, shear_z : ndarray
        kappa G A along y and z in N; ``inf`` for Euler-Bernoulli.
    coupling : ndarray, shape (m, 6, 6), or None
        Off-diagonal stiffness of the sections, in the order of `matrices`. None: there is none.
    """

    length: np.ndarray
    EA: np.ndarray
    GJ: np.ndarray
    EI_y: np.ndarray
    EI_z: np.ndarray
    shear_y: np.ndarray
    shear_z: np.ndarray
    coupling: np.ndarray | None = None

    @property
    def phi_y(self) -> np.ndarray:
        """Shear parameter of bending in the x-y plane, ``12 E I_z / (kappa_y G A l^2)``."""
        return 12.0 * self.EI_z / (self.shear_y * self.length**2)

    @property
    def phi_z(self) -> np.ndarray:
        """Shear parameter of bending in the x-z plane, ``12 E I_y / (kappa_z G A l^2)``."""
        return 12.0 * self.EI_y / (self.shear_z * self.length**2)

    @property
    def matrices(self) -> np.ndarray:
        """D: (N, V_y, V_z, T, M_y, M_z) from the strains of the sections, shape (m, 6, 6).

        Zero where the shear stiffness is infinite, since there is no shear strain.
        """
        diagonal = np.column_stack([self.EA, self.shear_y, self.shear_z, self.GJ, self.EI_y, self.EI_z])
        D = np.zeros((len(diagonal), 6, 6)) if self.coupling is None else self.coupling.copy()
        D[:, range(6), range(6)] = np.where(np.isfinite(diagonal), diagonal, 0.0)
        return D

    @property
    def coupled(self) -> np.ndarray:
        """Numbers of the elements whose section has off-diagonal stiffness."""
        if self.coupling is None:
            return np.zeros(0, dtype=int)
        return np.flatnonzero(self.coupling.any(axis=(1, 2)))


def of_matrices(length: np.ndarray, stiffness: np.ndarray) -> ElementProperties:
    """Return the properties of elements from their lengths (m,) and the stiffness of their sections (m, 6, 6).

    Where a shear stiffness is ``inf`` there is no shear strain, and its coupling terms are dropped.
    """
    EA, shear_y, shear_z, GJ, EI_y, EI_z = np.diagonal(stiffness, axis1=1, axis2=2).T
    coupling = np.array(stiffness, dtype=float)
    coupling[:, range(6), range(6)] = 0.0
    for row, finite in ((1, np.isfinite(shear_y)), (2, np.isfinite(shear_z))):
        coupling[~finite, row, :] = coupling[~finite, :, row] = 0.0
    return ElementProperties(
        length, EA, GJ, EI_y, EI_z, shear_y, shear_z, coupling=coupling if coupling.any() else None
    )


def section_elasticity(
    stiffness: np.ndarray, axes: np.ndarray, fibres: Sequence[np.ndarray | None] | None = None
) -> Elasticity:
    """Return the stiffness of sections (m, 6, 6) in the form of a body, with the axes A_GL (m, 3, 3) of the elements.

    `fibres` has for each element those of its section, (p, 3), or None; see `Elasticity`.
    """
    count = max((len(one) for one in fibres or () if one is not None), default=0)
    none = np.zeros((count, 3))
    around = np.array([none if one is None else one for one in fibres or [None] * len(stiffness)])
    both = np.column_stack((stiffness.reshape(-1, 36), around.reshape(len(stiffness), 3 * count)))
    different, of_cell = np.unique(both, axis=0, return_inverse=True)
    outlines = different[:, 36:].reshape(len(different), count, 3)
    return Elasticity(different[:, :36].reshape(-1, 6, 6), of_cell.reshape(-1), axes, outlines if count else None)


def properties_of(elasticity: Elasticity, length: np.ndarray) -> ElementProperties:
    """Return the properties of elements from the result of `section_elasticity` and their lengths (m,) in m."""
    return of_matrices(length, elasticity.table[elasticity.of_cell])
