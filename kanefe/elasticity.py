"""Stiffness of the material in every cell of a body: what stresses are recovered with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Elasticity:
    """Linear elastic moduli of the cells of a mesh, in components of G.

    Stresses and strains are listed as xx, yy, zz, yz, xz, xy, with engineering shear strains (2 e_yz, ...).

    Attributes
    ----------
    table : ndarray, shape (m, 6, 6)
        Different stiffness matrices, Pa. Of a plane body the moduli of plane stress or strain are in the places of
        xx, yy and xy.
    of_cell : ndarray of int, shape (cells,)
        Which of them each cell has, in the order of the body's blocks of cells.
    """

    table: np.ndarray
    of_cell: np.ndarray
