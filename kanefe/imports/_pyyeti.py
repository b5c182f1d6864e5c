"""Door to pyyeti: Nastran's op2, op4 and bulk files. The only file that imports pyyeti."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from kanefe.errors import FileError, MissingDependency, ModelError
from kanefe.imports.labelled import LabelledMatrix
from kanefe.imports.node_table import NodeTable
from kanefe.storage.files import regular_file

_DAMAGE = (OSError, ValueError, KeyError, IndexError, TypeError, EOFError, struct.error, AttributeError, RuntimeError)
"""Exceptions that pyyeti raises on a damaged file."""


def nodes(path: Path) -> NodeTable:
    """Return the grid points of a bulk data file in basic coordinates, with the axes of their displacements."""
    nastran = _import_pyyeti()
    regular_file(path, "for the nodes")
    try:
        grids = nastran.bulk.rdgrids(str(path))
        if grids is None:
            raise FileError(f"{path} has no GRID. Remedy: give the bulk data file of the run that wrote the matrices")
        uset = nastran.bulk.bulk2uset(str(path))[0]
        modes = nastran.n2p.rbgeom_uset(uset)
    except FileError:
        raise
    except _DAMAGE as error:
        raise FileError(f"cannot read the nodes of {path}: {error}. Remedy: check its GRID and CORD2x cards") from error
    labels = uset.index.get_level_values(0).to_numpy(dtype=np.int64)[::6]
    points = uset.to_numpy(dtype=float)[::6, 1:4]
    # the translations of a node under unit translations of basic, in the node's own axes
    axes = np.asarray(modes, dtype=float).reshape(-1, 6, 6)[:, :3, :3].transpose(0, 2, 1)
    table = NodeTable.of_rows(np.column_stack((labels, points)), str(path))
    turned = abs(axes - np.eye(3)).max() > 1e-9
    return NodeTable(table.labels, table.points, axes=axes if turned else None)


def reduced_freedoms(path: Path) -> tuple[np.ndarray | None, np.ndarray]:
    """Return (label, number) of the rows of a superelement by its EXTRN card, None without one, and scalar points."""
    nastran = _import_pyyeti()
    regular_file(path, "for the nodes")
    try:
        scalar = np.asarray(nastran.bulk.rdspoints(str(path)), dtype=np.int64)
        with path.open(errors="replace") as file:
            named = any(line.upper().startswith("EXTRN") for line in file)
        rows = np.asarray(nastran.bulk.rdextrn(str(path)), dtype=np.int64) if named else None
    except _DAMAGE as error:
        raise FileError(f"cannot read {path}: {error}. Remedy: check its SPOINT and EXTRN cards") from error
    return rows, scalar


def matrices(path: Path) -> dict[str, sp.csr_matrix]:
    """Return the matrices of an op4 or op2 file by upper-case name."""
    nastran = _import_pyyeti()
    regular_file(path, "for the matrices")
    try:
        if path.suffix.lower() == ".op2":
            found = nastran.op2.rdmats(str(path))
        else:
            found = nastran.op4.read(str(path), sparse=True)
    except _DAMAGE as error:
        raise FileError(
            f"{path} is truncated or no {path.suffix[1:]} file ({error}). Remedy: export it again"
        ) from error
    return {name.upper(): sp.csr_matrix(matrix) for name, matrix in found.items()}


def direct_matrices(path: Path) -> dict[str, LabelledMatrix]:
    """Return the matrices of DMIG cards (punch or bulk file) by upper-case name."""
    nastran = _import_pyyeti()
    regular_file(path, "for the matrices")
    with path.open(errors="replace") as file:
        if not any(line.lstrip().upper().startswith("DMIG") for line in file):
            raise FileError(f"{path} has no DMIG cards. Remedy: EXTSEOUT(STIFFNESS,MASS,DMIGPCH), or an op4 file")
    try:
        found = nastran.bulk.rddmig(str(path), square=True)
    except _DAMAGE as error:
        raise FileError(f"{path} is truncated or has damaged DMIG cards ({error}). Remedy: punch it again") from error
    return {name.upper(): _labelled(name, frame, path) for name, frame in found.items()}


def _labelled(name: str, frame: Any, path: Path) -> LabelledMatrix:
    values = frame.to_numpy()
    if np.iscomplexobj(values):
        raise ModelError(f"matrix {name.upper()} in {path} is complex. Remedy: export K without structural damping")
    if values.shape[0] != values.shape[1]:
        raise ModelError(
            f"matrix {name.upper()} in {path} is not square: it is not a mass, stiffness or damping matrix"
        )
    return LabelledMatrix(np.array(frame.index.to_list(), dtype=np.int64), sp.csr_matrix(values))


def _import_pyyeti() -> Any:
    try:
        from pyyeti import nastran
        from pyyeti.nastran import bulk, n2p, op2, op4  # noqa: F401
    except ImportError as problem:  # pyyeti itself, or what it needs in turn
        missing = (problem.name or "pyyeti").partition(".")[0]
        raise MissingDependency(missing, "read_nastran", "pip install 'kanefe[nastran]'") from problem
    return nastran
