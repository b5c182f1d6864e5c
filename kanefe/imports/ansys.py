"""Matrices of Ansys Mechanical APDL, exported as Harwell-Boeing or Matrix Market text with a mapping file.

After a modal solution without supports (which writes a .full file) they are written by ::

    /AUX2
    FILE,job,full
    HBMAT,job_K,matrix,,ASCII,STIFF,NO,YES     ! the last YES writes job_K.mapping
    HBMAT,job_M,matrix,,ASCII,MASS,NO,NO
    FINISH

or by ``*SMAT,K,D,IMPORT,FULL,job.full,STIFF`` and ``*EXPORT,K,MMF,job_K.mtx`` in the order of the same mapping file,
or with the mappings of APDL Math, ``*VEC,BACK,I,IMPORT,FULL,job.full,BACK`` (labels of the nodes in the internal order)
and ``*SMAT,SOLV,D,IMPORT,FULL,job.full,NOD2BCS`` (rows of the matrices in that order), each by ``*EXPORT,...,MMF``; the
nodes by ``CDWRITE,DB,job,cdb`` (or ``NWRITE``: rows of label, x, y, z), with node components (CM) as groups. Numbers
may have decimal commas.

A superelement (.sub) of component mode synthesis is exported by ``*DMAT,K,D,IMPORT,SUB,job.sub,STIFF`` and
``*EXPORT,K,MMF,job_K.mtx``, the same for MASS; its rows are listed by ``SELIST,job,3`` and are given as rows
(node, number), with 0 for a generalised coordinate.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Unpack

import numpy as np
import scipy.sparse as sp

from kanefe.arguments import checked
from kanefe.errors import FileError, ModelError
from kanefe.fe_model.model import FiniteElementModel
from kanefe.imports import _mapdl
from kanefe.imports.harwell_boeing import read_harwell_boeing
from kanefe.imports.labelled import LabelledMatrix, given_freedoms, mirrored, model_of_labelled, with_generalised
from kanefe.imports.node_table import Nodes, NodeTable, given_nodes
from kanefe.imports.self_check import Expected
from kanefe.imports.text import read_market, read_text
from kanefe.imports.units import Units

FREEDOMS = {"UX": 1, "UY": 2, "UZ": 3, "ROTX": 4, "ROTY": 5, "ROTZ": 6}

_MAPPED = re.compile(r"^\s*(\d+)\s*,?\s+(\d+)\s*,?\s+([A-Za-z]\w*)\s*$")


@checked("stiffness", "mass", "damping", "expected_mass", "expected_center", "expected_inertia")
def read_ansys(
    nodes: Nodes,
    stiffness: str | Path,
    mass: str | Path,
    mapping: str | Path | Mapping[str, str | Path] | np.ndarray | Sequence[tuple[int, int]],
    *,
    damping: str | Path | None = None,
    generalised: Sequence[int] = (),
    groups: Mapping[str, int | Sequence[int]] | None = None,
    units: Units = "m, kg, s",
    **expected: Unpack[Expected],
) -> FiniteElementModel:
    """Return the model of matrices from Ansys.

    Parameters
    ----------
    nodes : path, dict of labels to coordinates, or ndarray (n, 4) of label, x, y, z
        Archive (.cdb) of CDWRITE, whose node components become groups and whose nodal axes are used; a text file
        with rows of label, x, y, z; or the nodes themselves.
    stiffness, mass, damping : path
        Matrix Market files (.mtx, .mmf) of ``*EXPORT``; any other suffix is read as Harwell-Boeing text of ``HBMAT``.
    mapping : path, dict of str to path, or rows of (node, number)
        The mapping file of ``HBMAT``: equation, node and name (UX ... ROTZ) of every row. Or the mappings of APDL Math
        in Matrix Market files, of nodes that all have the same degrees of freedom: "back" (labels of the nodes in the
        internal order) or "forward" (position in the internal order by label), and "solver" (NOD2BCS or NOD2SOLV, the
        rows of the matrices in the internal order; without it they are in the internal order). A single path to such a
        file is the "back" one. Or the rows themselves: node and number of its degree of freedom (1 to 6 for UX to
        ROTZ), 0 for a generalised coordinate of a superelement, under a label of its own.
    generalised : sequence of int, optional
        Nodes of the mapping that are not points of the body but carry generalised coordinates of a superelement.
    groups, units : optional
        See `read_abaqus`.
    **expected
        See `read_abaqus`.

    Returns
    -------
    FiniteElementModel
        In m, kg, s and global Cartesian components.

    Raises
    ------
    FileError
        If a file does not exist, is truncated, or in another format.
    ModelError
        If mapping, matrices and nodes do not belong together, or the self-check fails.
    MissingDependency
        For a .cdb without mapdl-archive.

    Examples
    --------
    >>> arm = kf.read_ansys(
    ...     "job.cdb", "job_K.matrix", "job_M.matrix", "job_K.mapping", units="mm, t, s"
    ... )  # doctest: +SKIP
    """
    files = {"stiffness": stiffness, "mass": mass, "damping": damping}
    found = {what: _matrix(path, f"{what} matrix") for what, path in files.items() if path is not None}
    freedoms = _freedoms(mapping, found["stiffness"].shape[0])
    matrices = {}
    for what, matrix in found.items():
        if matrix.shape[0] != len(freedoms):
            raise ModelError(
                f"the {what} matrix in {files[what]} has {matrix.shape[0]} rows, {_called(mapping)} has "
                f"{len(freedoms)}. Remedy: write both from the same .full file (a file without mass of some nodes: "
                "LUMPM,OFF)"
            )
        matrices[what] = LabelledMatrix(freedoms, matrix)
    return model_of_labelled(
        {what: with_generalised(matrix, generalised) for what, matrix in matrices.items()},
        _nodes(nodes),
        groups=groups,
        units=units,
        expected=expected,
        source=f"Ansys {Path(stiffness).name}",
    )


def _called(mapping: object) -> str:
    return f"the mapping {mapping}" if isinstance(mapping, (str, Path, Mapping)) else "mapping="


def _nodes(nodes: Nodes) -> NodeTable:
    if isinstance(nodes, (str, Path)) and Path(nodes).suffix.lower() == ".cdb":
        return _mapdl.nodes(Path(nodes))
    return given_nodes(nodes)


def _matrix(path: str | Path, what: str) -> sp.csr_matrix:
    if Path(path).suffix.lower() in (".sub", ".full"):
        raise FileError(
            f"{path} is a binary file. Remedy: *DMAT,K,D,IMPORT,SUB,job.sub,STIFF (a .full file: *SMAT) and "
            "*EXPORT,K,MMF,job_K.mtx, the same for MASS, with mapping= of its rows"
        )
    if Path(path).suffix.lower() in (".mtx", ".mmf", ".mm"):
        return mirrored(read_market(path, what))
    return read_harwell_boeing(path, what)


def _freedoms(
    given: str | Path | Mapping[str, str | Path] | np.ndarray | Sequence[tuple[int, int]], rows: int
) -> np.ndarray:
    """Return (label, number) of every row from a mapping file, from mappings of APDL Math, or as given."""
    if not isinstance(given, (str, Path, Mapping)):
        return given_freedoms(given, "mapping", "node")
    if not isinstance(given, Mapping):
        if not read_text(given, "mapping").lstrip().startswith("%%MatrixMarket"):
            return _mapping(given)
        given = {"back": given}
    if len({"back", "forward"} & set(given)) != 1 or set(given) - {"back", "forward", "solver"}:
        raise ModelError(
            f"mapping has {', '.join(map(repr, given)) or 'nothing'}. Remedy: 'back' or 'forward', and perhaps 'solver'"
        )
    labels = _labels(given)
    chosen = None if "solver" not in given else read_market(given["solver"], "mapping of the solver")
    total = rows if chosen is None else max(chosen.shape)
    width = total // len(labels)
    if width * len(labels) != total or width not in (2, 3, 6):
        raise ModelError(
            f"{len(labels)} nodes of the mapping do not make {total} rows of 2, 3 or 6 degrees of freedom each. "
            "Remedy: the mapping file of HBMAT, or 'solver' (NOD2BCS) beside 'back'"
        )
    internal = np.column_stack((np.repeat(labels, width), np.tile(np.arange(1, width + 1), len(labels))))
    if chosen is None:
        return internal
    chosen = chosen if chosen.shape[1] == total else chosen.T.tocsr()
    chosen.eliminate_zeros()
    if chosen.shape[0] != rows or np.any(np.diff(chosen.indptr) != 1) or len(np.unique(chosen.indices)) != rows:
        raise ModelError(
            f"{given['solver']} does not choose one degree of freedom for each of {rows} rows. Remedy: export NOD2BCS "
            "of the same .full file, of a model without constraint equations"
        )
    return internal[chosen.indices]


def _labels(given: Mapping[str, str | Path]) -> np.ndarray:
    """Return the labels of the nodes in the internal order."""
    name = "back" if "back" in given else "forward"
    values = np.asarray(read_market(given[name], "mapping of the nodes").todense()).ravel()
    whole = np.rint(values).astype(np.int64)
    used = whole[whole > 0]
    fits = np.array_equal(values, whole) and len(np.unique(used)) == len(used) > 0
    if name == "forward" and fits and used.max() == len(used):
        return (np.flatnonzero(whole > 0) + 1)[np.argsort(used)]
    if name == "forward" or not fits or len(used) < len(whole):
        raise FileError(
            f"{given[name]} is not a mapping of nodes: its numbers should be whole and different"
            f"{', from 1 on' if name == 'forward' else ''}. Remedy: *VEC,...,I,IMPORT,FULL,job.full,{name.upper()} and "
            "*EXPORT,...,MMF"
        )
    return whole


def _mapping(path: str | Path) -> np.ndarray:
    """Return (label, number) of every row from a mapping file."""
    found = [m.groups() for line in read_text(path, "mapping").splitlines() if (m := _MAPPED.match(line))]
    equations = np.array([int(e) for e, _, _ in found])
    if not len(found) or not np.array_equal(np.sort(equations), np.arange(1, len(found) + 1)):
        raise FileError(
            f"{path} is truncated or not a mapping file: its rows should name equations 1, 2, ... with node and "
            "freedom. Remedy: HBMAT with Mapping=YES"
        )
    unknown = sorted({name.upper() for _, _, name in found} - set(FREEDOMS))
    if unknown:
        raise ModelError(
            f"{path} has degrees of freedom {', '.join(unknown)}, which are not motions of a node. Remedy: export a "
            "structural model (UX, UY, UZ, ROTX, ROTY, ROTZ) without pressures and temperatures; of a superelement "
            "give mapping= as rows of (node, number), with 0 for its generalised coordinates"
        )
    rows = np.array([(int(label), FREEDOMS[name.upper()]) for _, label, name in found], dtype=np.int64)
    return rows[np.argsort(equations)]
