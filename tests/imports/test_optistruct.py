"""OptiStruct's job.full.mat in the layout of its manual: pieces of columns, sparse or dense."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import import_writers as write
import kanefe as kf
from kanefe.errors import FileError, ModelError
from scenes import lattice_model

SOLID = lattice_model(0)
LABELS = np.array([3, 4, 10, 11, 17, 101, 102, 400, 9001])


def block(name: str, matrix: np.ndarray, kind: int, dense: bool, wide: str) -> str:
    """One matrix; of a sparse one pieces without zeros, in lines of four numbers."""
    rows, columns = matrix.shape
    text = f"{name} 0 {kind} {1 if dense else 3} {columns} {rows} {wide}\n"
    for j in range(columns):
        at = np.arange(rows) if dense else np.flatnonzero(matrix[:, j])
        for piece in np.split(at, np.flatnonzero(np.diff(at) > 1) + 1):
            if len(piece):
                text += f"{j + 1:8d}{piece[0] + 1:8d}{piece[-1] + 1:8d}\n"
                shown = [f"{matrix[i, j]:23.15E}" if kind == 2 else f"{int(matrix[i, j]):10d}" for i in piece]
                text += "".join("".join(shown[k : k + 4]) + "\n" for k in range(0, len(shown), 4))
    return text + "       0       0       0\n"


def job(folder: Path, dense: bool = False) -> list[Path]:
    """Deck and matrices; rows in another order than that of nodes, and of a sparse matrix one triangle."""
    order = np.random.default_rng(1).permutation(SOLID.size)
    named = np.array([(label, c) for label in LABELS for c in (1, 2, 3)])[order]
    text = ""
    for name, matrix in (("STIFFNESS", SOLID.stiffness), ("MASS", SOLID.mass)):
        A = matrix.toarray()[np.ix_(order, order)]
        text += block(name, A if dense else np.tril(A), 2, dense, "1P4E23.15")
    (folder / "job.full.mat").write_text(text + block("DOFS", named, 1, True, "8I10"))
    return [write.nastran_bulk(folder / "job.fem", SOLID.nodes, LABELS), folder / "job.full.mat"]


@pytest.mark.parametrize("dense", [False, True])
def test_full_matrices(dense: bool, tmp_path: Path) -> None:
    model = kf.read_nastran(*job(tmp_path, dense), groups={"tip": [400, 9001]})
    assert abs(model.stiffness - SOLID.stiffness).max() < 1e-14 * abs(SOLID.stiffness).max()  # 16 digits
    assert abs(model.mass - SOLID.mass).max() < 1e-14 * abs(SOLID.mass).max()
    assert model.groups["tip"].nodes.tolist() == [7, 8]


@pytest.mark.parametrize(
    ("old", "new", "error", "match"),
    [
        (
            "       0       0       0\nMASS",
            "MASS",
            FileError,
            r"MASS 0 2 .*line \d+\) where STIFFNESS should",
        ),
        ("STIFFNESS 0 2", "STIFFNESS 0 3", FileError, "is complex"),
        ("       1       1", "      99       1", FileError, r"\(line 2\) which is no place in STIFFNESS of 27 rows"),
        (
            "DOFS 0 1 1 2 27",
            "OTHER 0 1 1 2 27",
            ModelError,
            r"names no rows \(DOFS\): those of \.reduced",
        ),
        ("MASS 0 2 3 27 27", "MASS 0 2 3 28 28", FileError, r"MASS has shape \(28, 28\), DOFS \(27, 2\)"),
        ("E+", "E+ 1.0 ", FileError, r"numbers more than rows \d+ to \d+ of STIFFNESS"),
    ],
)
def test_what_is_wrong_is_named(old: str, new: str, error: type[Exception], match: str, tmp_path: Path) -> None:
    deck, path = job(tmp_path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(error, match=match):
        kf.read_nastran(deck, path)


def test_a_file_that_ends_early(tmp_path: Path) -> None:
    deck, path = job(tmp_path)
    lines = path.read_text().splitlines()
    path.write_text("\n".join(lines[:20]))
    with pytest.raises(FileError, match=r"ends within a matrix \(line 20\)"):
        kf.read_nastran(deck, path)
