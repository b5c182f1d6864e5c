"""Files of VTK 9 and dolfinx 0.11 that meshio does not read by itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from kanefe.errors import FileError
from kanefe.fe_model.shapes import measures, shape
from kanefe_fem import read_mesh

pytest.importorskip("meshio")

NUMBERS = {"tetra": 10, "wedge15": 26, "pyramid13": 27}


def vtu(path: Path, kind: str, version: str) -> Path:
    points = np.array(shape(kind).nodes, dtype=float)
    rows = " ".join(map(str, points.ravel().tolist()))
    path.write_text(
        f"""<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="{version}">
<UnstructuredGrid><Piece NumberOfPoints="{len(points)}" NumberOfCells="1">
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">{rows}</DataArray></Points>
<Cells><DataArray type="Int32" Name="connectivity" format="ascii">{" ".join(map(str, range(len(points))))}</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">{len(points)}</DataArray>
<DataArray type="Int8" Name="types" format="ascii">{NUMBERS[kind]}</DataArray></Cells>
</Piece></UnstructuredGrid></VTKFile>
"""
    )
    return path


def legacy(path: Path, kind: str, numbers: str) -> Path:
    """A binary file as VTK 9 writes it, with a group of integers."""
    points = np.array(shape(kind).nodes, dtype=">f8")
    n = len(points)
    parts: list[bytes | np.ndarray] = [
        f"# vtk DataFile Version 5.1\nvtk output\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS {n} double\n".encode(),
        points,
        f"\nCELLS 2 {n}\nOFFSETS vtktypeint64\n".encode(),
        np.array([0, n], dtype=">i8"),
        b"\nCONNECTIVITY vtktypeint64\n",
        np.arange(n, dtype=">i8"),
        b"\nCELL_TYPES 1\n",
        np.array([NUMBERS[kind]], dtype=">i4"),
        f"\n\nCELL_DATA 1\nSCALARS group {numbers} \nLOOKUP_TABLE default\n".encode(),
        np.array([5], dtype={"int": ">i4", "long": ">i8", "unsigned_char": ">u1", "vtktypeint64": ">i8"}[numbers]),
        b"\n",
    ]
    path.write_bytes(b"".join(p if isinstance(p, bytes) else p.tobytes() for p in parts))
    return path


def volume(path: Path) -> float:
    mesh = read_mesh(path)
    return float(sum(measures(block.kind, mesh.nodes[block.nodes])[0].sum() for block in mesh.cell_blocks))


@pytest.mark.parametrize("kind", NUMBERS)
def test_vtu_of_all_versions(kind: str, tmp_path: Path) -> None:
    right = {"tetra": 1 / 6, "wedge15": 1 / 2, "pyramid13": 4 / 3}[kind]  # of the reference cells
    for version in ("0.1", "1.0", "2.0", "2.2"):
        assert volume(vtu(tmp_path / "t.vtu", kind, version)) == pytest.approx(right, rel=1e-12)
    with pytest.raises(FileError, match=r"Unknown VTU file version '3\.0'.*Remedy"):
        volume(vtu(tmp_path / "t.vtu", kind, "3.0"))


@pytest.mark.parametrize("numbers", ["int", "long", "unsigned_char", "vtktypeint64"])
@pytest.mark.parametrize("kind", ["tetra", "wedge15"])
def test_binary_legacy_files_with_groups(kind: str, numbers: str, tmp_path: Path) -> None:
    path = legacy(tmp_path / "t.vtk", kind, numbers)
    assert volume(path) == pytest.approx({"tetra": 1 / 6, "wedge15": 1 / 2}[kind], rel=1e-12)
    assert list(read_mesh(path).cells) == ["5"]
