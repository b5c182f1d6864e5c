"""What other programs lose or rename on the way through a file is told, or found again."""

from __future__ import annotations

from pathlib import Path

import pytest

from kanefe.errors import FileError, MeshError
from kanefe_fem import Material, read_mesh, solid_model
from kanefe_fem.mesh.checks import MeshWarning

pytest.importorskip("meshio")

TETRA = "NDIME= 3\nNELEM= 1\n10 0 1 2 3 0\nNPOIN= 4\n0 0 0 0\n1 0 0 1\n0 1 0 2\n0 0 1 3\n"


def markers(*found: tuple[str, str], count: int | None = None) -> str:
    stated = len(found) if count is None else count
    return f"NMARK= {stated}\n" + "".join(f"MARKER_TAG= {n}\nMARKER_ELEMS= 1\n{e}\n" for n, e in found)


@pytest.mark.filterwarnings("ignore:meshio does not support")
def test_markers_of_su2_are_groups_of_facets(tmp_path: Path) -> None:
    path = tmp_path / "t.su2"
    path.write_text(TETRA + markers(("held", "5 0 1 2"), ("tip", "5 0 1 3"), ("7", "5 0 2 3")))
    mesh = read_mesh(path)
    found = {name: [block.nodes.tolist() for block in blocks] for name, blocks in mesh.facets.items()}
    assert found == {"held": [[[0, 1, 2]]], "tip": [[[0, 1, 3]]], "7": [[[0, 2, 3]]]}
    assert list(mesh.cells) == ["body"]
    path.write_text(TETRA + markers(("1", "5 0 1 2"), ("tip", "5 0 1 3"), ("2", "5 0 2 3")))
    with pytest.raises(FileError, match=r"markers 'tip' and '2' \(line 16\) cannot be told apart\. Remedy"):
        read_mesh(path)
    path.write_text(TETRA + markers(("held", "5 0 1 2"), count=2))
    with pytest.raises(FileError, match=r"says that it has 2 markers, and has 1\. Remedy"):
        read_mesh(path)


def test_nodes_in_no_cell_are_told(tmp_path: Path) -> None:
    path = tmp_path / "t.mesh"
    points = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (2, 2, 2))
    listed = "".join(f"{x} {y} {z} 1\n" for x, y, z in points)
    path.write_text(f"MeshVersionFormatted 2\nDimension 3\nVertices\n5\n{listed}Tetrahedra\n1\n1 2 3 4 1\nEnd\n")
    with pytest.warns(MeshWarning, match=r"1 of 5 nodes are in no cell and no group, first node 4 \(from 0\)\. Remedy"):
        read_mesh(path)


MSH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
3
2 5 "held"
2 6 "held"
3 1 "body"
$EndPhysicalNames
$Nodes
4
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
$EndNodes
$Elements
3
1 2 2 5 1 1 2 3
2 2 2 6 2 1 2 4
3 4 2 1 1 1 2 3 4
$EndElements
"""


@pytest.mark.gmsh
def test_two_groups_of_one_name_are_one(tmp_path: Path) -> None:
    path = tmp_path / "t.msh"
    path.write_text(MSH)
    mesh = read_mesh(path)
    assert {name: sum(len(block.nodes) for block in blocks) for name, blocks in mesh.facets.items()} == {"held": 2}


def test_an_import_without_a_solid_says_so(tmp_path: Path) -> None:
    path = tmp_path / "shell.mesh"
    listed = "0 0 0 1\n1 0 0 1\n0 1 0 1\n0 0 1 1\n"
    path.write_text(f"MeshVersionFormatted 2\nDimension 3\nVertices\n4\n{listed}Triangles\n2\n1 2 3 1\n1 2 4 1\nEnd\n")
    with pytest.raises(MeshError, match="surfaces do not close has no volume: heal or sew it"):
        solid_model(path, Material(E=1e9, nu=0.3, rho=1000.0))
