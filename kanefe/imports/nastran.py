"""Matrices of Nastran: op2 and op4 files, and DMIG cards of punch files.

The best export has labels: ``EXTSEOUT(STIFFNESS,MASS,DMIGPCH)`` punches the matrices KAAX and MAAX as DMIG cards with
grid and component (for a body condensed to its a-set), ``PARAM,EXTDROUT,DMIGPCH`` in older versions. An op4 file with
KGG and MGG (by DMAP or ``PARAM,OGEOM`` and OUTPUT4) has all six components of every grid point in ascending labels.

A Craig-Bampton superelement (boundary grid points in ASET or BSET, modes in QSET and SPOINT) is read from ``EXTSEOUT``
with DMIGPCH, or with DMIGOP2 and MATOP4: the op4 file with KXX and MXX, and the punch file with the cards GRID,
SPOINT and EXTRN, which identify the rows; or, as of MYSTRAN (SOL 31), with rows of a boundary and modes behind them.
OptiStruct's job.full.mat has the names of its rows with it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Unpack

import numpy as np
import scipy.sparse as sp

from kanefe.arguments import checked
from kanefe.errors import FileError, ModelError
from kanefe.fe_model.model import FiniteElementModel
from kanefe.imports import _pyyeti
from kanefe.imports.bulk_data import bulk_cards
from kanefe.imports.bulk_names import warn_of_unknown
from kanefe.imports.card import Card
from kanefe.imports.direct_matrices import direct_matrices
from kanefe.imports.grid_points import grid_points
from kanefe.imports.included import DeckWarning
from kanefe.imports.labelled import LabelledMatrix, model_of_labelled, with_generalised
from kanefe.imports.node_table import NodeTable
from kanefe.imports.optistruct import is_optistruct, optistruct_matrices
from kanefe.imports.output4 import is_output4, output4_matrices
from kanefe.imports.rigid_elements import check_rigid_elements
from kanefe.imports.self_check import Expected
from kanefe.imports.shaped_mass import shaped_field
from kanefe.imports.units import Units
from kanefe.imports.unlabelled_rows import REDUCED, Boundary, GivenRows, rows_of
from kanefe.storage.files import regular_file

NAMES = {
    "stiffness": ("KGG", "KAA", "KAAX", "K2GG", "KXX", "K", "STIFFNESS"),
    "mass": ("MGG", "MAA", "MAAX", "M2GG", "MXX", "M", "MASS"),
    "damping": ("BGG", "BAA", "BAAX", "B2GG"),
}
"""Names under which Nastran writes the matrices, in order of precedence."""

SHAPES, FULL_MASS = "PHIXG", "MGG"
"""Names of the motions of all grid points in the coordinates of a Craig-Bampton model, and of their mass matrix."""

LEAST = 1e-20
"""Entry of a matrix relative to its largest below which it is zero."""


@checked("bulk", "matrices", "expected_mass", "expected_center", "expected_inertia")
def read_nastran(
    bulk: str | Path,
    matrices: str | Path | Sequence[str | Path],
    *,
    names: Mapping[str, str] | None = None,
    freedoms: np.ndarray | Sequence[tuple[int, int]] | None = None,
    boundary: Boundary | None = None,
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
        Files of OUTPUT4 or OUTPUT2, by any name (MYSTRAN writes .OU1); text that is none is read for DMIG cards, or
        is OptiStruct's job.full.mat. A Craig-Bampton model KXX, MXX with PHIXG and MGG of its run has the exact inertia
        of the full model.
    names : dict, optional
        Names of the matrices for "stiffness", "mass" and "damping" in the files, such as {"stiffness": "KGG1"}.
        Default: the usual ones.
    freedoms : rows of (grid, component), optional
        Degrees of freedom of all rows in an op4 or op2 file, component 0 for a scalar point. Default: those
        of an EXTRN card in the bulk data; of `boundary` or, for KXX and MXX, SUPORT cards, with the modes behind them;
        or all six components of all grid points, and the scalar points. Grid points are in ascending labels or in the
        order of their cards, by which of them leaves rigid motions free.
    boundary : rows of (grid, components), optional
        Boundary of a Craig-Bampton model, in any order, with components written together: [(27, 123456)]. Its other
        rows are generalised coordinates.
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
        Without pyyeti, of op2 files.

    Warns
    -----
    AccuracyWarning
        If the deck has rigid elements, of which its matrices know nothing.
    DeckWarning
        If the deck has cards that are not known.

    Examples
    --------
    >>> arm = kf.read_nastran("arm.bdf", "arm.pch", groups={"tip": 1001})  # doctest: +SKIP

    A superelement with its cards in the punch file and its matrices in an op4 file:

    >>> arm = kf.read_nastran("arm.pch", "arm.op4", groups={"root": 3, "tip": 27})  # doctest: +SKIP

    A Craig-Bampton model of MYSTRAN (SOL 31, ``OUTPUT4 KXX,MXX,PHIXG,MGG,//-1/21``), its boundary by SUPORT cards:

    >>> arm = kf.read_nastran("arm.bdf", "arm.OU1", groups={"root": 3, "tip": 27})  # doctest: +SKIP
    >>> body = kf.flexible_body(arm, {"root": "clamped", "tip": "node"})  # doctest: +SKIP
    """
    cards = bulk_cards(Path(bulk), trusted=trusted, reader="read_nastran")
    order, table = _nodes(cards, Path(bulk))
    warn_of_unknown(Path(bulk).name, cards, DeckWarning)
    files = [Path(p) for p in ((matrices,) if isinstance(matrices, (str, Path)) else matrices)]
    found: dict[str, LabelledMatrix | sp.csr_matrix] = {}
    for path in files:
        head = _head(path)
        if is_optistruct(head):
            found |= optistruct_matrices(path)
            continue
        unlabelled = _unlabelled(path, head, {SHAPES, FULL_MASS} | _wanted(names or {}))
        if unlabelled is not None:
            found |= unlabelled
        else:
            found |= _direct(path, cards if path == Path(bulk) else bulk_cards(path, trusted=trusted))
    source = ", ".join(path.name for path in files)
    chosen = _chosen(found, names or {}, source)
    stiffness, name = found[chosen["stiffness"]], chosen["stiffness"]
    rows = None
    if not isinstance(stiffness, LabelledMatrix):
        rows = rows_of(_square(stiffness, name, source), name, GivenRows(freedoms, boundary), cards, order, table)
    labelled = {what: _placed(found[name], name, source, rows) for what, name in chosen.items()}
    field = None
    if rows is not None and chosen["mass"] in REDUCED and {SHAPES, FULL_MASS} <= set(found):
        field = shaped_field(found[SHAPES], found[FULL_MASS], found[chosen["mass"]], rows, order, table)
    stiff, heavy = (set(labelled[what].freedoms[:, 0].tolist()) for what in ("stiffness", "mass"))
    check_rigid_elements(cards, stiff, heavy, groups or {}, name)
    return model_of_labelled(
        {what: with_generalised(matrix, generalised) for what, matrix in labelled.items()},
        table,
        groups=groups,
        units=units,
        expected=expected,
        source=f"Nastran {source}",
        field=field,
    )


def _nodes(cards: Sequence[Card], path: Path) -> tuple[np.ndarray, NodeTable]:
    """Return the labels of grid points in the order of their cards, and the points with axes of displacements."""
    found = grid_points(cards)
    if not len(found.labels):
        raise FileError(f"{path} has no GRID. Remedy: give the bulk data file of the run that wrote the matrices")
    table = NodeTable.of_rows(np.column_stack((found.labels, found.points)), str(path))
    axes = None if found.axes is None else found.axes[np.argsort(found.labels)]
    return found.labels, NodeTable(table.labels, table.points, axes=axes)


def _unlabelled(path: Path, head: bytes, wanted: set[str]) -> dict[str, sp.csr_matrix] | None:
    """Return the matrices of an op4 or op2 file, known by what is in it; None of a file of cards."""
    suffix = path.suffix.lower()
    if is_output4(head) or suffix == ".op4":
        return output4_matrices(path, wanted)
    if suffix == ".op2" or head[:4] in (b"\4\0\0\0", b"\0\0\0\4", b"\10\0\0\0", b"\0\0\0\10"):
        return {name: matrix for name, matrix in _pyyeti.matrices(path).items() if name in wanted}
    if b"\0" in head:
        raise FileError(
            f"{path} is binary, and neither an op4 nor an op2 file. Remedy: the file of OUTPUT4 (MYSTRAN calls it .OU1)"
        )
    return None


def _head(path: Path) -> bytes:
    """Return the first bytes of a file."""
    with regular_file(path, "for the matrices").open("rb") as stream:
        return stream.read(200)


def _direct(path: Path, cards: Sequence[Card]) -> dict[str, LabelledMatrix]:
    """Return the matrices of the DMIG cards of a file."""
    found = direct_matrices(cards)
    if not found:
        raise FileError(f"{path} has no DMIG cards. Remedy: EXTSEOUT(STIFFNESS,MASS,DMIGPCH), or an op4 file")
    return found


def _wanted(names: Mapping[str, str]) -> set[str]:
    return {n for what, usual in NAMES.items() for n in ((names[what].upper(),) if what in names else usual)}


def _chosen(found: Mapping[str, Any], names: Mapping[str, str], source: str) -> dict[str, str]:
    """Return the names of the stiffness, mass and damping matrices in the files; with shapes those of their model."""
    unknown = set(names) - set(NAMES)
    if unknown:
        raise ModelError(f"names are given for {', '.join(NAMES)}, not for {', '.join(sorted(unknown))}")
    chosen = {}
    for what, usual in NAMES.items():
        reduced = tuple(name for name in usual if name in REDUCED) if SHAPES in found else ()
        candidates = (names[what].upper(),) if what in names else (*reduced, *usual)
        name = next((n for n in candidates if n in found), None)
        if name is not None:
            chosen[what] = name
        elif what != "damping" or what in names:
            raise ModelError(
                f"{source} has no {what} matrix called {' or '.join(candidates)}; it has "
                f"{', '.join(sorted(found)) or 'none'}. Remedy: names={{{what!r}: '...'}}"
            )
    return chosen


def _square(matrix: sp.csr_matrix, name: str, source: str) -> sp.csr_matrix:
    if matrix.shape[0] != matrix.shape[1]:
        raise ModelError(f"matrix {name} in {source} has shape {matrix.shape}. Remedy: names= of square matrices")
    return matrix


def _placed(matrix: LabelledMatrix | sp.csr_matrix, name: str, source: str, rows: np.ndarray | None) -> LabelledMatrix:
    """Return a matrix without labels at its degrees of freedom; another as it is."""
    if isinstance(matrix, LabelledMatrix):
        return matrix
    if rows is None or matrix.shape != (len(rows), len(rows)):
        raise ModelError(
            f"matrix {name} in {source} has shape {matrix.shape}, its points make {0 if rows is None else len(rows)} "
            "degrees of freedom. Remedy: export the g-set, or DMIG cards, which carry their labels; of a Craig-Bampton "
            "model say boundary=[(grid, components), ...], behind which its modes are, or give the file with its EXTRN "
            "card as bulk; or freedoms=[(grid, component), ...] of all rows, with (scalar point, 0)"
        )
    matrix = matrix.copy()
    matrix.data[abs(matrix.data) < LEAST * abs(matrix.data).max(initial=0.0)] = 0.0
    matrix.eliminate_zeros()
    used = np.asarray(abs(matrix).sum(axis=1)).ravel() + np.asarray(abs(matrix).sum(axis=0)).ravel() > 0
    # empty rows are unused grid points, and components without stiffness or mass
    return LabelledMatrix(rows[used], matrix[used][:, used].tocsr())
