"""Moduli of isotropic materials in Voigt's notation: strains xx, yy, zz, yz, xz, xy with engineering shears."""

from __future__ import annotations

import numpy as np


def isotropic(lame: float, shear: float) -> np.ndarray:
    """Return the stiffness of Lame's parameters in Pa, shape (6, 6)."""
    C = np.diag([2.0 * shear] * 3 + [shear] * 3)
    C[:3, :3] += lame
    return C
