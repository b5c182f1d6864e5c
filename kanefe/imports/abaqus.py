"""Matrices of Abaqus: ``*MATRIX OUTPUT`` (job_STIF1.mtx, job_MASS1.mtx) and ``*SUBSTRUCTURE MATRIX OUTPUT``.

These files are written by a separate step without boundary conditions::

    *STEP
    *MATRIX GENERATE, STIFFNESS, MASS
    *MATRIX OUTPUT, STIFFNESS, MASS, FORMAT=MATRIX INPUT
    *END STEP

or, for a body condensed to retained nodes (without eigenmodes), ``*SUBSTRUCTURE MATRIX OUTPUT, STIFFNESS=YES, MASS=YES,
OUTPUT FILE=USER DEFINED, FILE NAME=...``. The nodes come from the input file (.inp) of the job.
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
from kanefe.imports.abaqus_input import Keyword, keywords
from kanefe.imports.abaqus_job import Job, job_of
from kanefe.imports.labelled import LabelledMatrix, mirrored, model_of_labelled, repeated_entry
from kanefe.imports.node_table import Nodes, given_nodes
from kanefe.imports.self_check import Expected
from kanefe.imports.text import numbers, read_text
from kanefe.imports.units import Units

CALCULIX = (".sti", ".mas")
"""Suffixes of the matrices that CalculiX stores."""


@checked(
    "stiffness", "mass", "damping", "substructure", "expected_mass", "expected_center", "expected_inertia", "trusted"
)
def read_abaqus(
    nodes: Nodes,
    stiffness: str | Path | None = None,
    mass: str | Path | None = None,
    *,
    damping: str | Path | None = None,
    substructure: str | Path | None = None,
    groups: Mapping[str, int | Sequence[int]] | None = None,
    units: Units = "m, kg, s",
    trusted: bool = False,
    **expected: Unpack[Expected],
) -> FiniteElementModel:
    """Return the model of matrices from Abaqus.

    Parameters
    ----------
    nodes : path, dict of labels to coordinates, or ndarray (n, 4) of label, x, y, z
        The input file (.inp) of the job, whose node sets become groups; or the nodes themselves.
    stiffness, mass, damping : path
        Files of ``*MATRIX OUTPUT`` with FORMAT=MATRIX INPUT, LABELS, or COORDINATE (then in ascending labels of the
        nodes of elements), in axes of nodes where there are such.
    substructure : path, instead of them
        File of ``*SUBSTRUCTURE MATRIX OUTPUT``.
    groups : dict of str to node labels, optional
        Candidates for interfaces in addition to the sets of the input file.
    units : str or (metres per unit of length, kilograms per unit of mass)
        Units of the job: "m, kg, s", "mm, t, s", "in, lbf, s", ...
    trusted : bool
        Whether the input file may include files outside its folder.
    **expected
        The other parameters below, as `kanefe.imports.self_check.self_check` takes it.

    Other Parameters
    ----------------
    expected_mass, expected_center, expected_inertia : optional
        Required mass properties of M, in kg, m and kg m2 (inertia about the centre of mass).
    factorise : callable, optional
        Factorises large matrices for the count of zero modes.

    Returns
    -------
    FiniteElementModel
        In m, kg, s.

    Raises
    ------
    FileError
        If a file does not exist, is truncated, in another format, or included from elsewhere without being trusted.
    ModelError
        If the matrices do not belong to these nodes, are supported, have degrees of freedom that are not motions, or
        fail the self-check of `kanefe.model_from_matrices`.

    Examples
    --------
    >>> arm = kf.read_abaqus("job.inp", "job_STIF1.mtx", "job_MASS1.mtx", units="mm, t, s")  # doctest: +SKIP
    >>> body = kf.flexible_body(arm, {"ROOT": "clamped", "TIP": "rigid"})  # doctest: +SKIP
    """
    job = _job(nodes, trusted)
    if substructure is not None:
        if stiffness is not None or mass is not None or damping is not None:
            raise ModelError("give either substructure=, or stiffness= and mass=, not both")
        matrices, source = _substructure(substructure), Path(substructure).name
    else:
        if stiffness is None or mass is None:
            raise ModelError("give stiffness= and mass=, the .mtx files of *MATRIX OUTPUT, or substructure=")
        files = {"stiffness": stiffness, "mass": mass, "damping": damping}
        if Path(stiffness).suffix.lower() in CALCULIX:
            raise FileError(
                f"{stiffness} is of CalculiX. Remedy: kf.read_calculix, which knows the rows of its matrices"
            )
        matrices = {what: _matrix(path, what, job) for what, path in files.items() if path is not None}
        source = Path(stiffness).name
    return model_of_labelled(
        matrices, job.turned, groups=groups, units=units, expected=expected, source=f"Abaqus {source}"
    )


def _job(nodes: Nodes, trusted: bool) -> Job:
    if isinstance(nodes, (str, Path)) and Path(nodes).suffix.lower() == ".inp":
        return job_of(Path(nodes), trusted)
    table = given_nodes(nodes)
    return Job(table, table, table.labels)


def _matrix(path: str | Path, what: str, job: Job) -> LabelledMatrix:
    """Return a matrix of ``*MATRIX OUTPUT``: lines of node, number, node, number, value, or of row, column, value."""
    lines = [line for line in read_text(path, f"{what} matrix").splitlines() if line.strip() and line[0] != "*"]
    widths = {len(line.translate({44: " "}).split()) for line in (lines[:1] + lines[-1:])}
    values = numbers("\n".join(lines), path)
    if widths not in ({5}, {3}) or len(values) % widths.copy().pop():
        raise FileError(
            f"{path} is truncated or no {what} matrix of *MATRIX OUTPUT: its lines should hold node, freedom, node, "
            "freedom, value (or row, column, value). Remedy: export it again with FORMAT=MATRIX INPUT"
        )
    if widths == {5}:
        rows = values.reshape(-1, 5)
        return LabelledMatrix.of_entries(rows[:, :2], rows[:, 2:4], rows[:, 4])
    return _coordinates(values.reshape(-1, 3), Path(path), what, job)


def _coordinates(rows: np.ndarray, path: Path, what: str, job: Job) -> LabelledMatrix:
    """Return a matrix by row numbers, whose rows are those of `_rows`."""
    size = int(rows[:, :2].max())
    if rows[:, :2].min() < 1:
        raise ModelError(f"the {what} matrix in {path} has row {int(rows[:, :2].min())}. Remedy: export it again")
    entries = (rows[:, :2] - 1).astype(np.int64)
    twice = repeated_entry(*entries.T)
    if twice is not None:
        raise FileError(
            f"{path} has the entry of rows {(entries[twice] + 1).tolist()} twice, again as entry {twice + 1}. Remedy: "
            "export it again"
        )
    return LabelledMatrix(_rows(size, path, what, job), mirrored(sp.csr_matrix((rows[:, 2], entries.T), (size, size))))


def _rows(size: int, path: Path, what: str, job: Job) -> np.ndarray:
    """Return (label, number) of rows without labels: of nodes in ascending labels. Nodes of no element have no rows."""
    fits = [
        (labels, size // len(labels))
        for labels in ((job.used, job.nodes.labels) if len(job.used) < len(job.nodes.labels) else (job.nodes.labels,))
        if len(labels) and size % len(labels) == 0 and size // len(labels) in (2, 3, 6)
    ]
    if len(fits) != 1:
        of_elements = f", {len(job.used)} of them of elements," if len(job.used) < len(job.nodes.labels) else ""
        raise ModelError(
            f"the {what} matrix in {path} has {size} rows for {len(job.nodes.labels)} nodes{of_elements} and no labels "
            "that would identify them. Remedy: FORMAT=MATRIX INPUT, or the input file with its elements, whose nodes "
            "have rows"
        )
    labels, width = fits[0]
    return np.array([(label, number) for label in labels for number in range(1, width + 1)])


def _substructure(path: str | Path) -> dict[str, LabelledMatrix]:
    """Return the matrices of a substructure: nodes and freedoms of ``*USER ELEMENT``, lower triangles by rows."""
    text = read_text(path, "substructure")
    if "GENERATION OF SUBSTRUCTURE" in text[:1000]:
        raise FileError(
            f"{path} is of CalculiX, whose *SUBSTRUCTURE GENERATE writes the matrix of the retained freedoms with all "
            "others held (2.20), not the condensed one. Remedy: *FREQUENCY, SOLVER=MATRIXSTORAGE and kf.read_calculix"
        )
    blocks = keywords(text, Path(path).name)
    element = next((block for block in blocks if block.name == "USERELEMENT"), None)
    if element is None:
        raise FileError(
            f"{path} is not a file of *SUBSTRUCTURE MATRIX OUTPUT: it has no *USER ELEMENT. Remedy: export it with "
            "OUTPUT FILE=USER DEFINED"
        )
    freedoms = _freedoms(element, path)
    matrices = {}
    for block in blocks:
        what = {"STIFFNESS": "stiffness", "MASS": "mass", "VISCOUS DAMPING": "damping"}.get(
            block.options.get("TYPE", "").upper()
        )
        if block.name != "MATRIX" or what is None:
            continue
        values = numbers("\n".join(block.lines), path)
        n = len(freedoms)
        if len(values) == n * (n + 1) // 2:
            lower = np.zeros((n, n))
            lower[np.tril_indices(n)] = values
            matrix = lower + np.tril(lower, -1).T
        elif len(values) == n * n:
            matrix = values.reshape(n, n)
        else:
            raise FileError(
                f"the {what} matrix in {path} has {len(values)} entries for {n} degrees of freedom, where a triangle "
                f"has {n * (n + 1) // 2}: the file is truncated. Remedy: export it again"
            )
        matrices[what] = LabelledMatrix(freedoms, sp.csr_matrix(matrix))
    return matrices


def _freedoms(element: Keyword, path: str | Path) -> np.ndarray:
    """Return (label, number) of the rows: nodes in comments, numbers in lines "first node, numbers"."""
    listed = " ".join(c for c in element.comments if "NODE" not in c.upper() and c.replace(",", " ").split())
    labels = numbers(listed, path).astype(np.int64)
    count = int(element.options.get("NODES", len(labels)))
    if len(labels) != count:
        raise FileError(
            f"{path} names {len(labels)} of its {count} retained nodes: the file is truncated. Remedy: export it again"
        )
    freedoms: list[tuple[int, int]] = []
    starts: dict[int, np.ndarray] = {}
    for i, line in enumerate(element.lines):
        row = numbers(line, path).astype(np.int64)
        starts[0 if i == 0 else int(row[0]) - 1] = row if i == 0 else row[1:]
    current = np.zeros(0, dtype=np.int64)
    for i, label in enumerate(labels):
        current = starts.get(i, current)
        freedoms += [(int(label), int(number)) for number in current]
    return np.array(freedoms, dtype=np.int64)
