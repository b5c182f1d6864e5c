#!/usr/bin/env bash
# meshio 5.3.5 reads arrays of `int` in binary legacy files of VTK 5.1 with the size of the machine's own integers, 8 bytes for
# 4: the file that VTK 9 writes of a mesh with groups ends in ReadError without a reason, and `long`, `short` and `unsigned_char`
# in KeyError. Text is read right, and so are arrays of float64. Its table of shapes has no wedge15 and pyramid13 (KeyError), which
# its own table of VTK's cells maps to.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv own
own/bin/pip install -q --disable-pip-version-check meshio==5.3.5 numpy==1.26.4
own/bin/python - <<'PYTHON'
import contextlib, io
import meshio
import numpy as np

HEAD = b"# vtk DataFile Version 5.1\nvtk output\nBINARY\nDATASET UNSTRUCTURED_GRID\n"


def read(cell: int, points: np.ndarray, numbers: str | None, size: str) -> str:
    n = len(points)
    content = HEAD + b"POINTS %d double\n" % n + points.astype(">f8").tobytes()
    content += b"\nCELLS 2 %d\nOFFSETS vtktypeint64\n" % n + np.array([0, n], ">i8").tobytes()
    content += b"\nCONNECTIVITY vtktypeint64\n" + np.arange(n).astype(">i8").tobytes()
    content += b"\nCELL_TYPES 1\n" + np.array([cell], ">i4").tobytes() + b"\n"
    if numbers is not None:
        content += f"\nCELL_DATA 1\nSCALARS group {numbers} \nLOOKUP_TABLE default\n".encode() + np.array([5], size).tobytes() + b"\n"
    with open("t.vtk", "wb") as file:
        file.write(content)
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            meshio.vtk.read("t.vtk")
    except Exception as error:
        return type(error).__name__
    return "read"


tetra = np.vstack((np.zeros(3), np.eye(3)))
for cell, points, numbers, size, expected in (
    (10, tetra, None, "", "read"),
    (10, tetra, "double", ">f8", "read"),
    (10, tetra, "int", ">i4", "ReadError"),
    (10, tetra, "long", ">i8", "KeyError"),
    (10, tetra, "unsigned_char", ">u1", "KeyError"),
    (26, np.random.default_rng(0).random((15, 3)), None, "", "KeyError"),
    (27, np.random.default_rng(0).random((13, 3)), None, "", "KeyError"),
):
    found = read(cell, points, numbers, size)
    print(f"cell {cell}, array {numbers}: {found}")
    assert found == expected, "this has changed"
PYTHON
