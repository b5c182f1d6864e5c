"""Input files of Abaqus and CalculiX as meshes: nodes, elements, sets, surfaces, instances, and what is refused."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

from kanefe.errors import FileError, MeshError
from kanefe_fem.mesh.checks import MeshWarning
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh_files import read_mesh

LOWER = "*NODE, NSET=LOW\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n"
UPPER = "*NODE\n15,0,0,1\n16,1,0,1\n17,1,1,1\n18,0,1,1\n"
CUBE = "*ELEMENT, TYPE=C3D8R, ELSET=E\n 7, 1,2,3,4,\n 15,16,17,18\n"
BODY = LOWER + UPPER + CUBE
PART = f"*PART, NAME=P\n{BODY}*SOLID SECTION, ELSET=E, MATERIAL=M\n*END PART\n*ASSEMBLY, NAME=A\n{{}}*END ASSEMBLY\n"


def deck(folder: Path, text: str) -> Path:
    path = folder / "a.inp"
    path.write_text(text)
    return path


def read(folder: Path, text: str) -> Mesh:
    """Return the mesh of a deck of which nothing is told."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", MeshWarning)
        return read_mesh(deck(folder, text))


def volume(mesh: Mesh) -> float:
    return float(str(mesh).split("m3)")[0].split()[-1])


def test_several_blocks_of_nodes_are_one_table(tmp_path: Path) -> None:
    mesh = read(tmp_path, BODY)
    assert mesh.cells["E"][0].nodes.tolist() == [[0, 1, 2, 3, 4, 5, 6, 7]]
    np.testing.assert_array_equal(mesh.nodes[4:, 2], 1.0)
    assert mesh.points["LOW"].tolist() == [0, 1, 2, 3]
    later = read(tmp_path, CUBE + LOWER + UPPER)  # nodes may come after elements
    assert later.cells["E"][0].nodes.tolist() == mesh.cells["E"][0].nodes.tolist()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("2,1,0,0", "2,1"),  # coordinates left out are 0
        ("2,1,0,0", "2,1.D0,,"),
        ("2,1,0,0", "2,10.-1,0,0"),
        ("2,1,0,0", "2,1,0,0,0,0,1"),  # a normal
        ("2,1,0,0", "+2, .1e+1 ,-0.,0"),
        ("4,0,1,0\n", "\n4,0,1,0\n ** between\n"),
        ("*NODE, NSET=LOW", "  *Node ,Nset = Low"),
        ("*NODE, NSET=LOW", "*NODE,\nNSET=LOW"),  # Abaqus
        ("*NODE, NSET=LOW", "*NODE, NSET=LOW,"),  # CalculiX
        (" 7, 1,2,3,4,\n", " 7, 1,2,3,4\n"),  # CalculiX
        (" 7, 1,2,3,4,\n 15,16,17,18", "7,1,2,3,4,15,16,17,18,"),
        (" 7, 1,2,3,4,\n 15", " 7, 1,2,3,\n4, 15"),
    ],
)
def test_lines_are_read_in_whatever_way_they_are_written(old: str, new: str, tmp_path: Path) -> None:
    mesh = read(tmp_path, BODY.replace(old, new))
    plain = read(tmp_path, BODY)
    np.testing.assert_array_equal(mesh.nodes, plain.nodes)
    np.testing.assert_array_equal(mesh.cells["E"][0].nodes, plain.cells["E"][0].nodes)
    assert next(iter(mesh.points.values())).tolist() == [0, 1, 2, 3]


def test_data_may_be_in_files_that_are_included(tmp_path: Path) -> None:
    """As CalculiX 2.20 takes them: the lines of a file are where it is included, whatever they are."""
    (tmp_path / "nodes.txt").write_text("** some\n3,1,1,0\n")
    whole = read(tmp_path, BODY.replace("3,1,1,0\n", "*INCLUDE, INPUT=nodes.txt\n"))
    np.testing.assert_array_equal(whole.nodes, read(tmp_path, BODY).nodes)
    assert whole.points["LOW"].tolist() == [0, 1, 2, 3]
    (tmp_path / "nodes.txt").write_text("\n3,1,x,0\n")
    with pytest.raises(FileError, match=r"nodes\.txt: \*NODE \(line 2\) has 'x', which is not a number"):
        read(tmp_path, BODY.replace("3,1,1,0\n", "*INCLUDE, INPUT=nodes.txt\n"))
    with pytest.raises(
        FileError, match=r"nodes\.txt has data that are those of \*SYSTEM, which is in one file \(line 2"
    ):
        read(tmp_path, "*SYSTEM\n1,1,1,2,2,2\n*INCLUDE, INPUT=nodes.txt\n" + BODY)


def test_of_a_node_that_is_given_twice_the_last_holds(tmp_path: Path) -> None:
    """As in CalculiX 2.20, and in Abaqus by its manual."""
    with pytest.warns(MeshWarning, match=r"node 18 is given twice, at different places: the last holds \(line 11\)"):
        mesh = read_mesh(deck(tmp_path, BODY.replace("1,0,0,0", "18,5,5,5\n1,0,0,0", 1)))
    assert volume(mesh) == 1.0
    assert read(tmp_path, BODY + "*NODE\n1,0,0,0\n").cell_count == 1  # at the same place


def test_wedges_of_fifteen_nodes_are_read(tmp_path: Path) -> None:
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)]
    mids = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]
    points = np.array([*corners, *(np.mean([corners[a], corners[b]], axis=0) for a, b in mids)])
    rows = "".join(f"{i},{x},{y},{z}\n" for i, (x, y, z) in enumerate(points.tolist(), 1))
    labels = ",".join(map(str, range(1, 16)))
    mesh = read(tmp_path, f"*NODE\n{rows}*ELEMENT, TYPE=C3D15, ELSET=E\n1,{labels}\n")
    assert list(mesh.kinds) == ["wedge15"]
    assert "(1, 0.5 m3)" in str(mesh)


@pytest.mark.parametrize(("name", "kind"), [("CPS6", "triangle6"), ("CPE6", "triangle6"), ("CPS8R", "quad8")])
def test_plane_elements_of_second_order(name: str, kind: str, tmp_path: Path) -> None:
    corners = [(0, 0), (1, 0), (1, 1), (0, 1)] if kind == "quad8" else [(0, 0), (1, 0), (0, 1)]
    mids = [np.add(corners[i], corners[i - len(corners) + 1]) / 2 for i in range(len(corners))]
    points = [*map(tuple, corners), *map(tuple, mids)]
    rows = "".join(f"{i},{x},{y}\n" for i, (x, y) in enumerate(points, 1))
    labels = ",".join(map(str, range(1, 1 + len(points))))
    mesh = read(tmp_path, f"*NODE\n{rows}*ELEMENT, TYPE={name}, ELSET=E\n1,{labels}\n")
    assert (list(mesh.kinds), mesh.dimension) == ([kind], 2)


def test_sets_of_sets_ranges_and_elements(tmp_path: Path) -> None:
    sets = (
        "*NSET, NSET=TOP, GENERATE\n15,18,1\n*NSET, NSET=MIX\nLOW, 15\n16\n*NSET, NSET=EVEN, GENERATE\n2,4,2\n16,18,2\n"
        "*ELSET, ELSET=F\nE\n*NSET, NSET=ALL, ELSET=F\n*SOLID SECTION, ELSET=F, MATERIAL=M\n*Nset, nset=Tip\n1\n"
        "*NSET, NSET=TIP\n2\n*NSET, NSET=BOTH\ntip, top\n"
    )
    mesh = read(tmp_path, BODY + sets)
    assert list(mesh.cells) == ["F"]
    assert {name: ids.tolist() for name, ids in mesh.points.items()} == {
        "LOW": [0, 1, 2, 3],
        "TOP": [4, 5, 6, 7],
        "MIX": [0, 1, 2, 3, 4, 5],
        "EVEN": [1, 3, 5, 7],
        "ALL": [*range(8)],
        "Tip": [0, 1],
        "BOTH": [0, 1, 4, 5, 6, 7],
    }


def test_nodes_of_an_assembly_have_labels_of_their_own(tmp_path: Path) -> None:
    text = PART.format(
        "*INSTANCE, NAME=I, PART=P\n*END INSTANCE\n"
        "*NODE\n1, 5., 5., 5.\n*NSET, NSET=REF\n1\n*NSET, NSET=FOOT, INSTANCE=I\n1, 2\n*NSET, NSET=TIP\nI.15\n"
        "*ELSET, ELSET=S1, INSTANCE=I\n7\n*SURFACE, NAME=BOTTOM\nS1, S1\n*NSET, NSET=Low\nI.low, 1\n"
    )
    mesh = read(tmp_path, text)
    np.testing.assert_array_equal(mesh.nodes[0], 0.0)
    assert mesh.points["FOOT"].tolist() == [0, 1]
    assert mesh.points["TIP"].tolist() == [4]
    assert mesh.nodes[mesh.points["REF"]].tolist() == [[5, 5, 5]]
    assert sorted(mesh.facets["BOTTOM"][0].nodes[0].tolist()) == [0, 1, 2, 3]
    assert mesh.points["Low"].tolist() == [0, 1, 2, 3, 8]
    assert mesh.points["I.LOW"].tolist() == [0, 1, 2, 3]
    assert str(mesh).startswith("mesh a.inp: 8 nodes (1 more in no cell), 1 hexahedron\n  extent  1 x 1 x 1 m")


def test_an_instance_is_moved_and_then_turned(tmp_path: Path) -> None:
    mesh = read(tmp_path, PART.format("*INSTANCE, NAME=I, PART=P\n10.,0,0\n0,0,0, 0,0,1, 90.\n*END INSTANCE\n"))
    np.testing.assert_allclose(mesh.nodes[1], (0, 11, 0), atol=1e-14)  # round-off of a turn of 11 m
    assert volume(mesh) == pytest.approx(1.0, rel=1e-12)


def test_instances_of_one_part_have_names_of_their_own(tmp_path: Path) -> None:
    text = PART.format(
        "*INSTANCE, NAME=I, PART=P\n*END INSTANCE\n*INSTANCE, NAME=J, PART=P\n0,0,3\n*END INSTANCE\n"
        "*NSET, NSET=ENDS\nI.1, J.15\n*SURFACE, NAME=ON\nJ.E, S2\nI.7, S1\n"
    )
    with pytest.raises(MeshError, match="2 parts that are not connected"):
        read_mesh(deck(tmp_path, text))
    mesh = read_mesh(deck(tmp_path, text), cells="J.E")
    np.testing.assert_array_equal(mesh.nodes[mesh.body_nodes][:, 2], [3] * 4 + [4] * 4)
    assert mesh.points["J.LOW"].tolist() == mesh.body_nodes[:4].tolist()


def test_elements_of_an_independent_instance_are_its_own(tmp_path: Path) -> None:
    """A part without a mesh, and the mesh in its instance, as Abaqus/CAE writes it."""
    mesh = read(
        tmp_path,
        f"*PART, NAME=P\n*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I, PART=P\n0,1,0\n{BODY}*END INSTANCE\n"
        "*END ASSEMBLY\n",
    )
    assert (volume(mesh), mesh.nodes[:, 1].max()) == (1.0, 2.0)


def test_surfaces_of_labels_are_read_and_others_told(tmp_path: Path) -> None:
    mesh = read(tmp_path, BODY + "*SURFACE, NAME=TOP\n7, S2\n")
    assert sorted(mesh.facets["TOP"][0].nodes[0].tolist()) == [4, 5, 6, 7]
    with pytest.warns(MeshWarning, match=r"surface 'FREE' \(line 14\) is not of faces"):
        read_mesh(deck(tmp_path, BODY + "*SURFACE, NAME=FREE\nE,\n"))


def test_what_is_no_part_of_a_mesh_or_in_no_group_is_told(tmp_path: Path) -> None:
    more = "*TIE, NAME=T\nA, B\n*ELEMENT, TYPE=MASS, ELSET=M\n90,8\n*MASS, ELSET=M\n3.\n"
    with pytest.warns(MeshWarning, match=r"\*TIE \(line 14\), \*MASS \(line 18\), \*ELEMENT of type MASS \(line 16\)"):
        read_mesh(deck(tmp_path, BODY + more))
    more = "*ELEMENT, TYPE=C3D8\n8,1,2,3,4,15,16,17,18\n"
    with pytest.warns(MeshWarning, match="1 of 2 cells belong to no group and are left out"):
        read_mesh(deck(tmp_path, BODY + more))
    with pytest.warns(MeshWarning, match="1 of 9 nodes are in no cell and no group"):
        read_mesh(deck(tmp_path, BODY + "*NODE\n100,5,5,5\n"))
    with pytest.warns(MeshWarning, match=r"\*NDOE \(line 14\) is not known, .*; ELSTE of \*NSET \(line 16\) is not"):
        read_mesh(deck(tmp_path, BODY + "*NDOE\n9,1,1,1\n*NSET, NSET=F, ELSTE=G\n1\n"))
    with pytest.warns(MeshWarning, match=r"set 'R' \(line 15\) has a range with 10 labels of no node"):
        read_mesh(deck(tmp_path, BODY + "*NSET, NSET=R, GENERATE\n4,15\n"))


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("*ELEMENT, TYPE=CAX4\n8,1,2,3,4\n", r"\*ELEMENT \(line 14\) has elements of type CAX4, which are not read"),
        ("*ELEMENT, TYPE=C3D27\n8,1\n", r"\*ELEMENT \(line 14\) has elements of type C3D27"),
        ("*ELEMENT, TYPE=B32\n8,1,2,3\n", r"\*ELEMENT \(line 14\) has elements of type B32"),
        ("*ELEMENT\n8,1,2,3\n", r"\*ELEMENT \(line 14\) has no TYPE="),
        ("*ELEMENT, TYPE=C3D4\n8,1,2,3\n", r"\*ELEMENT \(line 15\) has element 8 with 3 nodes, where 4 are needed"),
        ("*ELEMENT, TYPE=C3D4\n8,1,2,3,4,15\n", r"\(line 15\) has 6 numbers of element 8"),
        (
            "*ELEMENT, TYPE=C3D4\n8,1,2,3\n9,1,2,3,4\n",
            r"\(line 16\) has 9 numbers of element 8, which begins in line 15",
        ),
        ("*ELEMENT, TYPE=C3D4\n8,1,2,3,9\n", r"a\.inp has no node 9, which element 8 has \(line 15\)"),
        ("*ELEMENT, TYPE=C3D4\n7,1,2,3,15\n", r"\*ELEMENT \(line 15\) has element 7 again"),
        ("*ELEMENT, TYPE=C3D4\n8,1,2,3,1.5\n", r"\*ELEMENT \(line 15\) has '1.5' where a label should be"),
        ("*ELEMENT, TYPE=C3D4, INPUT=more.txt\n", r"\*ELEMENT \(line 14\) has its data in the file more\.txt"),
        ("*NODE, INPUT=more.txt\n", r"\*NODE \(line 14\) has its data in the file more\.txt"),
        ("*NODE\n0.5,1,0,0\n", r"\*NODE \(line 15\) has '0\.5' where a label should be"),
        ("*NODE\n9,0,1,2,3,4,5,6\n", r"\*NODE \(line 15\) has 8 fields"),
        ("*NODE\n9,0,0,5\n10,0,zero,5\n", r"\*NODE \(line 16\) has 'zero', which is not a number"),
        ("*NODE\n9,0,nan,5\n", r"\*NODE \(line 15\) has 'nan', which is not a number"),
        ("*NODE\n9,0,1 2,5\n", r"\*NODE \(line 15\) has '1 2', which is not a number"),
        ("*NODE, SYSTEM=S\n9,0,1,5\n", r"\*NODE \(line 14\) is in the system 'S', which is not read"),
        ("*NSET\n1\n", r"\*NSET \(line 14\) has no NSET="),
        ("*NSET, NSET=A\n1\nB\n", r"\*NSET \(line 16\) has 'B', which is no label and no set before it"),
        ("*NSET, NSET=A\n1\n2,9\n", r"\*NSET \(line 16\) has node 9 in set 'A', which is not there"),
        ("*NSET, NSET=A, ELSET=B\n", r"\*NSET \(line 14\) has no element set 'B'"),
        ("*NSET, NSET=A, GENERATE\n4,1\n", r"\*NSET \(line 15\) has a range from 4 down to 1"),
        ("*ELSET, ELSET=A\n9\n", r"\*ELSET \(line 15\) has element 9 in set 'A'"),
        ("*SURFACE, NAME=A\nB, S1\n", r"\*SURFACE \(line 15\) has no element set 'B'"),
        ("*SURFACE, NAME=A\nE, S7\n", r"\*SURFACE \(line 15\) has face S7 of a hexahedron, which has 6"),
        ("*NFILL\n1,5,1\n", r"\*NFILL \(line 14\) generates nodes, which is not read"),
        ("*ELGEN\n7,2\n", r"\*ELGEN \(line 14\) generates elements"),
        ("*ELCOPY\n7,2\n", r"\*ELCOPY \(line 14\) generates elements"),
        ("*NGEN, LINE=C\n1,3,1\n", r"\*NGEN \(line 14\) is of a curved line"),
        ("*NGEN\n1,9,1\n", r"\*NGEN \(line 15\) is of node 9, which is not there before"),
        ("*NGEN\n1,4,2\n", r"\*NGEN \(line 15\) has no nodes from 1 to 4 in steps of 2"),
        ("*NCOPY, CHANGE NUMBER=9, OLD SET=LOW, POLE\n1\n", r"\*NCOPY \(line 14\) copies otherwise than by SHIFT"),
        ("*NCOPY, CHANGE NUMBER=9, OLD SET=NO, SHIFT\n1\n", r"\*NCOPY \(line 14\) copies the set NO"),
        ("*SYSTEM\n0,0,0,1,0,0\n2,0,0\n*NODE\n9,0,0,0\n", r"\*SYSTEM \(line 14\) has three points on one line"),
        ("*INCLUDE\n", r"\*INCLUDE \(line 14\) has no INPUT="),
        ("*INCLUDE, INPUT=no.inc\n", r"there is no file .*no\.inc that a\.inp reads \(line 14\)"),
        ("*INSTANCE, NAME=I, PART=P\n", r"\*INSTANCE \(line 14\) is of part P, which is not there before it"),
    ],
)
def test_what_is_not_read_is_refused_with_its_line(more: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=message):
        read_mesh(deck(tmp_path, BODY + more))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (BODY + "*\n", r"a keyword without a name \(line 14\)"),
        ("1,0,0,0\n" + BODY, r"has data that are before its first keyword \(line 1\)"),
        (
            PART.format("*INSTANCE, NAME=I, PART=P\n"),
            r"\*ENDASSEMBLY \(line 19\) is where \*INSTANCE of line 18 is open",
        ),
        (
            PART.format("*INSTANCE, NAME=I, PART=P\n*END INSTANCE\n").replace("*END PART\n", ""),
            r"\*ASSEMBLY \(line 16\) is within \*PART, which begins in line 1",
        ),
        (
            PART.format("*INSTANCE, NAME=I, PART=P\n*END INSTANCE\n").replace("*END ASSEMBLY\n", ""),
            r"\*ASSEMBLY \(line 17\) has no \*ENDASSEMBLY",
        ),
        (PART.format(2 * "*INSTANCE, NAME=I, PART=P\n*END INSTANCE\n"), r"\*INSTANCE \(line 20\) has the name I again"),
        (
            PART.format("*INSTANCE, NAME=I, PART=P\n1,2,3,4\n*END INSTANCE\n"),
            r"\*INSTANCE \(line 19\) has other data than a translation",
        ),
        (
            PART.format("*INSTANCE, NAME=I, PART=P\n0\n1,2,3,1,2,3,90\n*END INSTANCE\n"),
            r"\*INSTANCE \(line 20\) has an axis of two equal points",
        ),
        (PART.format("*INSTANCE, NAME=I, LIBRARY=o, INSTANCE=K\n*END INSTANCE\n"), r"line 18\) is taken from another"),
    ],
)
def test_parts_and_instances_that_are_not_whole(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=message):
        read_mesh(deck(tmp_path, text))
