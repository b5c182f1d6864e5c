"""The moduli of materials on the cells of a mesh, for the forms of solids."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class IsotropicModuli:
    """Lame's parameters of each cell in Pa (times the thickness in 2D).

    Attributes
    ----------
    lame, shear : ndarray, shape (m,)
        lambda and mu.
    """

    lame: np.ndarray
    shear: np.ndarray

    def times(self, shares: np.ndarray) -> IsotropicModuli:
        """Return shares (m,) of the moduli of each cell."""
        return IsotropicModuli(shares * self.lame, shares * self.shear)


@dataclass(frozen=True, eq=False)
class AnisotropicModuli:
    """Stiffness matrix of each cell, engineering shear strains, in Pa (times the thickness in 2D).

    Attributes
    ----------
    matrices : ndarray, shape (m, 6, 6), or (m, 3, 3) in 2D
        Symmetric; in the order of `VOIGT`, axes of the mesh.
    """

    matrices: np.ndarray

    def times(self, shares: np.ndarray) -> AnisotropicModuli:
        """Return shares (m,) of the moduli of each cell."""
        return AnisotropicModuli(shares[:, None, None] * self.matrices)


Moduli = IsotropicModuli | AnisotropicModuli
