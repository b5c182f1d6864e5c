"""Matrices of Nastran: op2 and op4 files, and DMIG cards of punch files.

The best export has labels: ``EXTSEOUT(STIFFNESS,MASS,DMIGPCH)`` punches the matrices KAAX and MAAX as DMIG cards with
grid and component (for a body condensed to its a-set), ``PARAM,EXTDROUT,DMIGPCH`` in older versions. An op4 file with
KGG and MGG (by DMAP or ``PARAM,OGEOM`` and OUTPUT4) has all six components of every grid point in ascending labels.

A Craig-Bampton superelement (boundary grid points in ASET or BSET, modes in QSET and SPOINT) is read from ``EXTSEOUT``
with DMIGPCH, or with DMIGOP2 and MATOP4: the op4 file with KXX and MXX, and the punch file with the cards GRID,
SPOINT and EXTRN, which identify the rows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Unpack

import numpy as np
import scipy.sparse as sp

from kanefe.arguments import checked
from kanefe.errors import FileError, ModelError
from kanefe.fe_model.model import FiniteElementModel
from kanefe.imports import _pyyeti
from kanefe.imports.bulk_data import Card, bulk_cards
from kanefe.imports.direct_matrices import direct_matrices, extern_freedoms, scalar_points
from kanefe.imports.grid_points import grid_points
from kanefe.imports.labelled import LabelledMatrix, given_freedoms, mirrored, model_of_labelled, with_generalised
from kanefe.imports.node_table import NodeTable
from kanefe.imports.self_check import Expected
from kanefe.imports.units import Units

NAMES = {
    "stiffness": ("KGG", "KAA", "KAAX", "K2GG", "KXX", "K"),
    "mass": ("MGG", "MAA", "MAAX", "M2GG", "MXX", "M"),
    "damping": ("BGG", "BAA", "BAAX", "B2GG"),
}
"""Names under which Nastran writes the matrices, in order of precedence."""


@checked("bulk", "matrices", "expected_mass", "expected_center", "expected_inertia")
def read_nastran(
    bulk: str | Path,
    matrices: str | Path | Sequence[str | Path],
    *,
    names: Mapping[str, str] | None = None,
    freedoms: np.ndarray | Sequence[tuple[int, int]] | None = None,
    generalised: Sequence[int] = (),
    groups: Mapping[str, int | Sequence[int]] | None = None,
    units: Units = "m, kg, s",
    trusted: bool = False,
    **expected: Unpack[Expected],
) -> FiniteElementModel:
    """Return the model of matrices from Nastran.

    Parameters
    ----------
    bulk : path
        Bulk data file with the GRID, GRDSET and CORD1/2R/C/S cards; grid points may have local displacement coordinate
        systems. A file that it includes may be in its folder or in that of the file that includes it.
    matrices : path or several
        .op4 or .op2 files; any other suffix (.pch, .bdf, .dat) is read for DMIG cards.
    names : dict, optional
        Names of the matrices for "stiffness", "mass" and "damping" in the files, such as {"stiffness": "KGG1"}.
        Default: the usual ones.
    freedoms : rows of (grid, component), optional
        Degrees of freedom of the rows in an op4 or op2 file, component 0 for a scalar point. Default: those
        of an EXTRN card in the bulk data, or all six components of all grid points, and the scalar points, in
        ascending labels.
    generalised : sequence of int, optional
        Grid points that are not points of the body but carry generalised coordinates, if a QSET names grid points.
        Scalar points (SPOINT) always carry them.
    groups, units : optional
        See `read_abaqus`.
    trusted : bool
        Whether the bulk data may include files outside their folder.
    **expected
        See `read_abaqus`.

    Returns
    -------
    FiniteElementModel
        In m, kg, s and in basic coordinates.

    Raises
    ------
    FileError
        If a file does not exist, is truncated, or in another format, or a card is not as it should be, with its line.
    ModelError
        If matrices are missing, do not belong to these grid points, or fail the self-check.
    MissingDependency
        Without pyyeti, of op2 and op4 files.

    Examples
    --------
    >>> arm = kf.read_nastran("arm.bdf", "arm.pch", groups={"tip": 1001})  # doctest: +SKIP

    A superelement with its cards in the punch file and its matrices in an op4 file:

    >>> arm = kf.read_nastran("arm.pch", "arm.op4", groups={"root": 3, "tip": 27})  # doctest: +SKIP
    >>> body = kf.flexible_body(arm, {"root": "clamped", "tip": "node"})  # doctest: +SKIP
    """
    cards = bulk_cards(Path(bulk), trusted=trusted, reader="read_nastran")
    table = _nodes(cards, Path(bulk))
    files = [Path(p) for p in ((matrices,) if isinstance(matrices, (str, Path)) else matrices)]
    found: dict[str, LabelledMatrix] = {}
    for path in files:
        if path.suffix.lower() in (".op4", ".op2"):
            found |= {
                name: _placed(matrix, name, path, _rows(freedoms, cards, table, matrix.shape[0]))
                for name, matrix in _pyyeti.matrices(path).items()
                if name in _wanted(names)
            }
        else:
            found |= _direct(path, cards if path == Path(bulk) else bulk_cards(path, trusted=trusted))
    source = ", ".join(path.name for path in files)
    chosen = _chosen(found, names or {}, source)
    return model_of_labelled(
        {what: with_generalised(matrix, generalised) for what, matrix in chosen.items()},
        table,
        groups=groups,
        units=units,
        expected=expected,
        source=f"Nastran {source}",
    )


def _nodes(cards: Sequence[Card], path: Path) -> NodeTable:
    """Return the grid points of a deck, with the axes of their displacements."""
    found = grid_points(cards)
    if not len(found.labels):
        raise FileError(f"{path} has no GRID. Remedy: give the bulk data file of the run that wrote the matrices")
    table = NodeTable.of_rows(np.column_stack((found.labels, found.points)), str(path))
    axes = None if found.axes is None else found.axes[np.argsort(found.labels)]
    return NodeTable(table.labels, table.points, axes=axes)


def _direct(path: Path, cards: Sequence[Card]) -> dict[str, LabelledMatrix]:
    """Return the matrices of the DMIG cards of a file."""
    found = direct_matrices(cards)
    if not found:
        raise FileError(f"{path} has no DMIG cards. Remedy: EXTSEOUT(STIFFNESS,MASS,DMIGPCH), or an op4 file")
    return found


def _wanted(names: Mapping[str, str] | None) -> set[str]:
    return {n for usual in NAMES.values() for n in usual} | {name.upper() for name in (names or {}).values()}


def _chosen(found: Mapping[str, LabelledMatrix], names: Mapping[str, str], source: str) -> dict[str, LabelledMatrix]:
    """Return the stiffness, mass and damping matrices by these names."""
    unknown = set(names) - set(NAMES)
    if unknown:
        raise ModelError(f"names are given for {', '.join(NAMES)}, not for {', '.join(sorted(unknown))}")
    chosen = {}
    for what, usual in NAMES.items():
        candidates = (names[what].upper(),) if what in names else usual
        name = next((n for n in candidates if n in found), None)
        if name is not None:
            chosen[what] = found[name]
        elif what != "damping" or what in names:
            raise ModelError(
                f"{source} has no {what} matrix called {' or '.join(candidates)}; it has "
                f"{', '.join(sorted(found)) or 'none'}. Remedy: names={{{what!r}: '...'}}"
            )
    return chosen


def _rows(
    freedoms: np.ndarray | Sequence[tuple[int, int]] | None, cards: Sequence[Card], table: NodeTable, size: int
) -> np.ndarray:
    """Return (label, number) of the rows of a matrix of `size` rows without labels."""
    if freedoms is not None:
        return given_freedoms(freedoms, "freedoms", "grid")
    named, scalar = extern_freedoms(cards), scalar_points(cards)
    of_grids = np.array([(label, number) for label in table.labels for number in range(1, 7)])
    if named is not None and len(named) == size:
        return named
    if len(of_grids) == size or not len(scalar):
        return of_grids
    rows = np.concatenate((of_grids, np.column_stack((scalar, np.zeros_like(scalar)))))
    return np.asarray(rows[np.argsort(rows[:, 0], kind="stable")])


def _placed(matrix: sp.csr_matrix, name: str, path: Path, rows: np.ndarray) -> LabelledMatrix:
    """Return a matrix without labels at its degrees of freedom."""
    if matrix.shape != (len(rows), len(rows)):
        raise ModelError(
            f"matrix {name} in {path} has shape {matrix.shape}, its points make {len(rows)} degrees of freedom. "
            "Remedy: export the g-set, or DMIG cards, which carry their labels; of a superelement give the file with "
            "its EXTRN card as bulk; or give freedoms=[(grid, component), ...], with (scalar point, 0)"
        )
    used = np.asarray(abs(matrix).sum(axis=1)).ravel() + np.asarray(abs(matrix).sum(axis=0)).ravel() > 0
    # empty rows are unused grid points, and components without stiffness or mass
    return LabelledMatrix(rows[used], mirrored(matrix[used][:, used]))
