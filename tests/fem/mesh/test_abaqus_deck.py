"""Input files of Abaqus: blocks of nodes, sets, surfaces, and what is refused, with its line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from kanefe.errors import FileError, ModelError
from kanefe_fem.mesh.checks import MeshWarning
from kanefe_fem.mesh_files import read_mesh

LOWER = "*NODE, NSET=LOW\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n"
UPPER = "*NODE\n15,0,0,1\n16,1,0,1\n17,1,1,1\n18,0,1,1\n"
CUBE = "*ELEMENT, TYPE=C3D8R, ELSET=E\n 7, 1,2,3,4,\n 15,16,17,18\n"


def deck(folder: Path, text: str) -> Path:
    path = folder / "a.inp"
    path.write_text(text)
    return path


def test_several_blocks_of_nodes_are_one_table(tmp_path: Path) -> None:
    mesh = read_mesh(deck(tmp_path, LOWER + UPPER + CUBE))
    assert mesh.cells["E"][0].nodes.tolist() == [[0, 1, 2, 3, 4, 5, 6, 7]]
    np.testing.assert_array_equal(mesh.nodes[4:, 2], 1.0)
    assert mesh.points["LOW"].tolist() == [0, 1, 2, 3]
    later = read_mesh(deck(tmp_path, CUBE + LOWER + UPPER))  # nodes may come after elements
    assert later.cells["E"][0].nodes.tolist() == mesh.cells["E"][0].nodes.tolist()


def test_wedges_of_fifteen_nodes_are_read(tmp_path: Path) -> None:
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)]
    mids = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]
    points = np.array([*corners, *(np.mean([corners[a], corners[b]], axis=0) for a, b in mids)])
    rows = "".join(f"{i},{x},{y},{z}\n" for i, (x, y, z) in enumerate(points.tolist(), 1))
    labels = ",".join(map(str, range(1, 16)))
    mesh = read_mesh(deck(tmp_path, f"*NODE\n{rows}*ELEMENT, TYPE=C3D15, ELSET=E\n1,{labels}\n"))
    assert list(mesh.kinds) == ["wedge15"]
    assert "(1, 0.5 m3)" in str(mesh)


def test_sets_of_sets_ranges_and_elements(tmp_path: Path) -> None:
    sets = (
        "*NSET, NSET=TOP, GENERATE\n15,18,1\n*NSET, NSET=MIX\nLOW, 15\n16\n*NSET, NSET=EVEN, GENERATE\n2,4,2\n16,18,2\n"
        "*ELSET, ELSET=F\nE\n*NSET, NSET=ALL, ELSET=F\n*SOLID SECTION, ELSET=F, MATERIAL=M\n"
    )
    mesh = read_mesh(deck(tmp_path, LOWER + UPPER + CUBE + sets))
    assert list(mesh.cells) == ["F"]
    assert {name: ids.tolist() for name, ids in mesh.points.items()} == {
        "LOW": [0, 1, 2, 3],
        "TOP": [4, 5, 6, 7],
        "MIX": [0, 1, 2, 3, 4, 5],
        "EVEN": [1, 3, 5, 7],
        "ALL": [*range(8)],
    }


def test_nodes_of_an_assembly_have_labels_of_their_own(tmp_path: Path) -> None:
    text = (
        f"*PART, NAME=P\n{LOWER}{UPPER}{CUBE}*SOLID SECTION, ELSET=E, MATERIAL=M\n*END PART\n"
        "*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I, PART=P\n*END INSTANCE\n"
        "*NODE\n1, 5., 5., 5.\n*NSET, NSET=REF\n1\n*NSET, NSET=FOOT, INSTANCE=I\n1, 2\n*NSET, NSET=TIP\nI.15\n"
        "*ELSET, ELSET=S1, INSTANCE=I\n7\n*SURFACE, NAME=BOTTOM\nS1, S1\n*END ASSEMBLY\n"
    )
    mesh = read_mesh(deck(tmp_path, text))
    np.testing.assert_array_equal(mesh.nodes[0], 0.0)
    assert mesh.points["FOOT"].tolist() == [0, 1]
    assert mesh.points["TIP"].tolist() == [4]
    assert mesh.nodes[mesh.points["REF"]].tolist() == [[5, 5, 5]]
    assert sorted(mesh.facets["BOTTOM"][0].nodes[0].tolist()) == [0, 1, 2, 3]


def test_surfaces_of_labels_are_read_and_others_told(tmp_path: Path) -> None:
    mesh = read_mesh(deck(tmp_path, LOWER + UPPER + CUBE + "*SURFACE, NAME=TOP\n7, S2\n"))
    assert sorted(mesh.facets["TOP"][0].nodes[0].tolist()) == [4, 5, 6, 7]
    with pytest.warns(MeshWarning, match=r"left out: 'FREE' \(line 14\)"):
        read_mesh(deck(tmp_path, LOWER + UPPER + CUBE + "*SURFACE, NAME=FREE\nE,\n"))


def test_what_is_no_part_of_a_mesh_or_in_no_group_is_told(tmp_path: Path) -> None:
    with pytest.warns(MeshWarning, match=r"left out: \*TIE \(line 14\), \*MASS \(line 16\)"):
        read_mesh(deck(tmp_path, LOWER + UPPER + CUBE + "*TIE, NAME=T\nA, B\n*MASS, ELSET=M\n3.\n"))
    more = "*ELEMENT, TYPE=C3D8\n8,1,2,3,4,15,16,17,18\n"
    with pytest.warns(MeshWarning, match="1 of 2 cells belong to no group and are left out"):
        read_mesh(deck(tmp_path, LOWER + UPPER + CUBE + more))


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("*ELEMENT, TYPE=CAX4\n8,1,2,3,4\n", r"elements of type CAX4 \(\*ELEMENT, line 14\), which are not read"),
        ("*ELEMENT, TYPE=C3D27\n8,1\n", r"elements of type C3D27 \(\*ELEMENT, line 14\)"),
        ("*ELEMENT, TYPE=B32\n8,1,2,3\n", r"elements of type B32 \(\*ELEMENT, line 14\)"),
        ("*ELEMENT, TYPE=C3D4\n8,1,2,3\n", r"elements of 4 nodes \(\*ELEMENT, line 14\), and 4 numbers"),
        ("*ELEMENT, TYPE=C3D4\n8,1,2,3,9\n", r"no node 9, which an element of kind tetra has"),
        ("*ELEMENT, TYPE=C3D4\n7,1,2,3,15\n", r"has element 7 twice"),
        ("*ELEMENT, TYPE=C3D4, INPUT=more.txt\n", r"data of \*ELEMENT \(line 14\) in the file more\.txt"),
        ("*NODE\n1,0,0,5\n", r"node 1 twice \(\*NODE, line 14\)"),
        ("*NODE\n9,0,zero,5\n", r"\(\*NODE, line 14\) holds something that is not a number"),
        ("*NSET, NSET=A\nB\n", r"a set of 'B' \(\*NSET, line 14\), which is no set before it"),
        ("*NSET, NSET=A, ELSET=B\n", r"no element set 'B' \(\*NSET, line 14\)"),
    ],
)
def test_what_is_not_read_is_refused_with_its_line(more: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=message):
        read_mesh(deck(tmp_path, LOWER + UPPER + CUBE + more))


@pytest.mark.parametrize("keyword", ["NGEN", "ELGEN", "ELCOPY", "NFILL"])
def test_what_is_generated_is_refused_with_its_line(keyword: str, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=rf"has \*{keyword} \(line 14\): generated"):
        read_mesh(deck(tmp_path, LOWER + UPPER + CUBE + f"*{keyword}\n1,5,1\n"))


@pytest.mark.parametrize("suffix", [".unv", ".UFF"])
def test_universal_files_are_refused_with_the_way(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"a{suffix}"
    path.write_text("    -1\n  2411\n")
    with pytest.raises(FileError, match=r"universal files .* are not read. Remedy: .*gmsh\.write\('a\.msh'\)"):
        read_mesh(path)
