"""Units of exporting programs, and the conversion of matrices to m, kg, s.

With lengths of l metres and masses of m kilograms (time in seconds, angles in radians) translations u scale by l and
rotations not at all, so every quadratic form ``u^T A u`` (K, C, M) scales by ``m l^2`` as a whole: with
D = diag(1 for translations, l for rotations) the matrix in SI is ``m D A D``. A generalised coordinate, whose scale is
arbitrary, counts as a translation.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.fe_model.model import TRANSLATIONS
from kanefe.frames import numbers

Units: TypeAlias = str | tuple[float, float]
"""Name of a system of units, or (metres per unit of length, kilograms per unit of mass); time is in seconds."""

INCH, POUND_FORCE, FOOT = 0.0254, 4.4482216152605, 0.3048
SYSTEMS: dict[str, tuple[float, float]] = {
    "m, kg, s": (1.0, 1.0),
    "mm, t, s": (1e-3, 1e3),
    "mm, kg, s": (1e-3, 1.0),
    "in, lbf, s": (INCH, POUND_FORCE / INCH),
    "ft, lbf, s": (FOOT, POUND_FORCE / FOOT),
}
"""Metres and kilograms per unit. With lbf the unit of mass is lbf s2 per unit of length (slinch, slug)."""


def scales(units: Units) -> tuple[float, float]:
    """Return metres per unit of length and kilograms per unit of mass.

    Raises
    ------
    ModelError
        If the name is unknown or a scale is not above zero.
    """
    if isinstance(units, str):
        if units not in SYSTEMS:
            known = ", ".join(repr(name) for name in SYSTEMS)
            raise ModelError(
                f"units {units!r} are not known. Remedy: one of {known}, or (metres a length, kg a mass) with seconds"
            )
        return SYSTEMS[units]
    given = numbers(units)
    length, mass = given.tolist() if given.shape == (2,) else (np.nan, np.nan)
    if not (0 < length < np.inf and 0 < mass < np.inf):
        raise ModelError(f"units must be (metres a length, kg a mass), both above zero, not {units!r}")
    return length, mass


def in_si(matrix: sp.spmatrix, components: tuple[str, ...], units: Units, generalised: int = 0) -> sp.csr_matrix:
    """Return M, C or K in m, kg, s, rad.

    Parameters
    ----------
    matrix : sparse matrix, shape (N, N)
        Rows of the nodes, each with all components, then those of generalised coordinates.
    components : tuple of str
    units : str or (float, float)
    generalised : int
        Number of generalised coordinates.
    """
    length, mass = scales(units)
    of_node = [1.0 if c in TRANSLATIONS else length for c in components]
    of_nodes = np.tile(of_node, (matrix.shape[0] - generalised) // len(components))
    scale = sp.diags(np.append(of_nodes, np.ones(generalised)))
    return (mass * (scale @ matrix @ scale)).tocsr()
