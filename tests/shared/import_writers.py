"""Writers of other programs' text formats, made for the tests: they know nothing of the readers."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

import kanefe as kf
from repository import ROOT

SCALAR = 20001
NUMBER = {"x": 1, "y": 2, "z": 3, "rx": 4, "ry": 5, "rz": 6}


def freedoms(model: kf.FiniteElementModel, labels: np.ndarray) -> list[tuple[int, int]]:
    """Label and number of every row; generalised coordinates are scalar points from `SCALAR` on."""
    nodal = [(int(label), NUMBER[c]) for label in labels for c in model.components]
    return nodal + [(SCALAR + i, 0) for i in range(model.generalised)]


def lower(matrix: Any) -> list[tuple[int, int, float]]:
    entries = sp.tril(matrix).tocoo()
    return [(int(i), int(j), float(v)) for i, j, v in zip(entries.row, entries.col, entries.data, strict=True)]


def abaqus_matrix(
    path: Path, model: kf.FiniteElementModel, matrix: Any, labels: np.ndarray, style: str = "input"
) -> Path:
    """Write `*MATRIX OUTPUT`: the lower triangle by labels, or by row and column numbers."""
    names = freedoms(model, labels)
    rows = lower(matrix)
    if style == "coordinate":
        lines = [f"{i + 1}\t{j + 1}\t{v: .15e}" for i, j, v in rows]
    else:
        lines = [f"{names[i][0]},{names[i][1]}, {names[j][0]},{names[j][1]}, {v: .15e}" for i, j, v in rows]
    path.write_text("\n".join(["** made for a test", *lines, ""]))
    return path


def abaqus_input(path: Path, nodes: np.ndarray, labels: np.ndarray, sets: dict[str, list[int]]) -> Path:
    """Write an input file with nodes in any order, blank coordinates, and node sets of all three forms."""
    lines = ["*HEADING", "a bar", "** nodes", "*NODE, NSET=ALL"]
    order = np.random.default_rng(0).permutation(len(nodes))
    for i in order:
        x = ["" if v == 0 else repr(float(v)) for v in nodes[i]]
        lines.append(f"{labels[i]}, " + ", ".join(x))
    for name, members in sets.items():
        lines += [f"*Nset, nset={name}", ", ".join(str(m) for m in members) + ","]
    lines += [
        "*NSET, NSET=FIRST, GENERATE",
        f"{labels[0]}, {labels[0] + 1}, 1",
        "*NSET, NSET=BOTH",
        "first, " + next(iter(sets)),
    ]
    path.write_text("\n".join([*lines, "*STEP", "*MATRIX GENERATE, STIFFNESS, MASS", "*END STEP", ""]))
    return path


def abaqus_substructure(path: Path, model: kf.FiniteElementModel, labels: np.ndarray) -> Path:
    """Write `*SUBSTRUCTURE MATRIX OUTPUT`: element header, node list as comments, lower triangles by rows."""
    n = len(labels)
    numbers = ", ".join(str(NUMBER[c]) for c in model.components)
    lines = [f"*USER ELEMENT,NODES={n:8d},LINEAR", "** ELEMENT NODES"]
    lines += ["** " + ", ".join(str(x) for x in labels[i : i + 5]) for i in range(0, n, 5)]
    lines += [numbers]
    for name, matrix in (("STIFFNESS", model.stiffness), ("MASS", model.mass)):
        lines.append(f"*MATRIX,TYPE={name}")
        values = matrix.toarray()[np.tril_indices(model.size)]
        lines += [", ".join(f"{v:.15e}" for v in values[i : i + 4]) + "," for i in range(0, len(values), 4)]
    path.write_text("\n".join([*lines, ""]))
    return path


def harwell_boeing(path: Path, matrix: Any, rhs: bool = False) -> Path:
    """Write a symmetric matrix (RSA, lower triangle by columns) in fixed widths, so that numbers touch."""
    low = sp.tril(matrix).tocsc()
    low.sort_indices()

    def block(values: list[str], per_line: int) -> list[str]:
        return ["".join(values[i : i + per_line]) for i in range(0, len(values), per_line)]

    pointers = block([f"{p + 1:14d}" for p in low.indptr], 5)
    rows = block([f"{r + 1:14d}" for r in low.indices], 5)
    numbers = block([f"{v:25.16E}".replace("E", "D") for v in low.data], 3)
    loads = block([f"{0.0:25.16E}"] * low.shape[0], 3) if rhs else []
    counts = [len(pointers), len(rows), len(numbers), len(loads)]
    header = [f"{'a test':72s}{'KEY':8s}", "".join(f"{c:14d}" for c in (sum(counts), *counts))]
    header += [f"RSA{'':11s}{low.shape[0]:14d}{low.shape[1]:14d}{low.nnz:14d}{0:14d}"]
    header += [f"{'(5I14)':16s}{'(5I14)':16s}{'(1P,3D25.16)':20s}{'(3D25.16)':20s}"]
    header += [f"F{'':13s}{1:14d}{0:14d}"] if rhs else []
    path.write_text("\n".join([*header, *pointers, *rows, *numbers, *loads, ""]))
    return path


def ansys_mapping(path: Path, model: kf.FiniteElementModel, labels: np.ndarray, order: np.ndarray) -> Path:
    names = {1: "UX", 2: "UY", 3: "UZ", 4: "ROTX", 5: "ROTY", 6: "ROTZ"}
    rows = freedoms(model, labels)
    lines = ["  Matrix Eqn     Node       DOF"]
    lines += [f"{i + 1:12d}{rows[at][0]:12d}    {names[rows[at][1]]}" for i, at in enumerate(order)]
    path.write_text("\n".join([*lines, ""]))
    return path


def nastran_bulk(path: Path, nodes: np.ndarray, labels: np.ndarray, coordinates: str = "", system: int = 0) -> Path:
    """Write GRID cards in 16-column fields; displacements in a coordinate system, if it is not 0."""
    lines = [coordinates] if coordinates else []
    for label, (x, y, z) in zip(labels, nodes, strict=True):
        lines.append(f"{'GRID*':8s}{label:16d}{0:16d}{x:16.9E}{y:16.9E}")
        lines.append(f"{'*':8s}{z:16.9E}{system:16d}")
    path.write_text("\n".join(["BEGIN BULK", *lines, "ENDDATA", ""]))
    return path


def dmig(path: Path, model: kf.FiniteElementModel, labels: np.ndarray, matrices: dict[str, Any]) -> Path:
    """Write DMIG cards of symmetric matrices with exponents D+05, column by column."""
    names = freedoms(model, labels)
    lines = []
    for name, matrix in matrices.items():
        lines.append(f"{'DMIG':8s}{name:8s}{0:8d}{6:8d}{2:8d}{0:8d}")
        columns: dict[int, list[tuple[int, float]]] = {}
        for i, j, v in lower(matrix):
            columns.setdefault(j, []).append((i, v))
        for j, entries in sorted(columns.items()):
            lines.append(f"{'DMIG*':8s}{name:16s}{names[j][0]:16d}{names[j][1]:16d}")
            lines += [f"{'*':8s}{names[i][0]:16d}{names[i][1]:16d}{v:16.9E}".replace("E", "D") for i, v in entries]
    path.write_text("\n".join([*lines, ""]))
    return path


def node_rows(path: Path, nodes: np.ndarray, labels: np.ndarray) -> Path:
    """Write rows of label, x, y, z."""
    rows = [f"{label} {x!r} {y!r} {z!r}" for label, (x, y, z) in zip(labels, nodes.tolist(), strict=True)]
    path.write_text("\n".join(["# label x y z", *rows, ""]))
    return path


def calculix_job(folder: Path, *_: object) -> list[Path]:
    """Two elements with incompatible modes, as CalculiX 2.20 stored their matrices."""
    with zipfile.ZipFile(ROOT / "tests" / "imports" / "calculix_2_20.zip") as archive:
        archive.extractall(folder, [name for name in archive.namelist() if name.startswith("inner/")])
    return [folder / "inner" / "job.inp", folder / "inner" / "job.sti"]


def abaqus_job(tmp_path: Path, model: kf.FiniteElementModel, labels: np.ndarray, style: str = "input") -> list[Path]:
    """Input file (with the last two nodes as set TIP), stiffness and mass of a job."""
    return [
        abaqus_input(tmp_path / "job.inp", model.nodes, labels, {"TIP": [int(x) for x in labels[-2:]]}),
        abaqus_matrix(tmp_path / "job_STIF1.mtx", model, model.stiffness, labels, style),
        abaqus_matrix(tmp_path / "job_MASS1.mtx", model, model.mass, labels, style),
    ]


def ansys_job(tmp_path: Path, model: kf.FiniteElementModel, labels: np.ndarray, rhs: bool = False) -> list[Path]:
    """Nodes, stiffness, mass and mapping of a job, in the order of a solver that is not that of the nodes."""
    order = np.random.default_rng(2).permutation(model.size)
    K, M = (m.tocsr()[order][:, order] for m in (model.stiffness, model.mass))
    return [
        node_rows(tmp_path / "nodes.txt", model.nodes, labels),
        harwell_boeing(tmp_path / "K.matrix", K, rhs),
        harwell_boeing(tmp_path / "M.matrix", M),
        ansys_mapping(tmp_path / "K.mapping", model, labels, order),
    ]


def nastran_job(tmp_path: Path, model: kf.FiniteElementModel, labels: np.ndarray) -> list[Path]:
    """Bulk data and punch file of a run."""
    return [
        nastran_bulk(tmp_path / "arm.bdf", model.nodes, labels),
        dmig(tmp_path / "arm.pch", model, labels, {"KAAX": model.stiffness, "MAAX": model.mass}),
    ]


def output4(path: Path, matrices: dict[str, np.ndarray], style: str = "mystran") -> Path:
    """Write an op4 file: binary as MYSTRAN does, or "big", "wide" (words of 8), "strings", "bigmat", or as "text"."""
    order = ">" if style == "big" else "<"
    word = 8 if style == "wide" else 4
    content = b""
    lines: list[str] = []

    def record(*parts: bytes) -> bytes:
        length = np.array(sum(map(len, parts)), f"{order}i4").tobytes()
        return b"".join((length, *parts, length))

    def wholes(*values: int) -> bytes:
        return np.array(values, f"{order}i{word}").tobytes()

    for name, A in matrices.items():
        rows, columns = A.shape
        head = -rows if style == "bigmat" else rows
        content += record(wholes(columns, head, 1, 2), name.ljust(2 * word).encode())
        lines.append(f"{columns:8d}{rows:8d}{1:8d}{2:8d}{name:8s}1P,3E23.16")
        for j in range(columns):
            used = np.flatnonzero(A[:, j])
            if style == "mystran":
                used = np.arange(rows)
            if not len(used):
                continue
            parts, words = [], 0
            if style in ("strings", "bigmat"):
                for run in np.split(used, np.flatnonzero(np.diff(used) > 1) + 1):
                    L = 2 * len(run)
                    marks = (L + 1, run[0] + 1) if style == "bigmat" else (65536 * (L + 1) + run[0] + 1,)
                    parts += [wholes(*marks), A[run, j].astype(f"{order}f8").tobytes()]
                    words += len(marks) + L
                first = 0
            else:
                column = A[used[0] : used[-1] + 1, j]
                parts, words, first = [column.astype(f"{order}f8").tobytes()], len(column) * 8 // word, used[0] + 1
                numbers = [f"{v:23.16E}".replace("E", "D" if j % 2 else "E") for v in column]
                lines += [f"{j + 1:8d}{first:8d}{len(column):8d}"]
                lines += ["".join(numbers[i : i + 3]) for i in range(0, len(numbers), 3)]
            content += record(wholes(j + 1, first, words), *parts)
        content += record(
            wholes(columns + 1, 1, 2 if style == "mystran" else 8 // word), bytes(16 if style == "mystran" else 8)
        )
        lines += [f"{columns + 1:8d}{1:8d}{1:8d}", f"{1.0:23.16E}"]
    if style == "text":
        path.write_text("\n".join([*lines, ""]))
    else:
        path.write_bytes(content)
    return path
