"""Stiffness of the material or section in every cell of a body: what stresses and section forces come from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Elasticity:
    """Linear elastic moduli of the cells of a mesh: of solids in components of G, of beams in their own axes.

    Stresses and strains are listed as xx, yy, zz, yz, xz, xy, with engineering shear strains (2 e_yz, ...).

    Attributes
    ----------
    table : ndarray, shape (m, 6, 6)
        Different stiffness matrices, Pa. Of a plane body the moduli of plane stress or strain are in the places of
        xx, yy and xy.
    of_cell : ndarray of int, shape (cells,)
        Which of them each cell has, in the order of the body's blocks of cells.
    axes : ndarray, shape (cells, 3, 3), or None
        A_GL of beams, axes of each element as columns: x along it, y and z across. The table then holds the stiffness
        of sections to stretch, shear along y and z, twist, and bending about y and z: N for the first three, N m2 for
        the others; infinite where a theory has no shear strain. None: a solid or plane body.
    """

    table: np.ndarray
    of_cell: np.ndarray
    axes: np.ndarray | None = None
