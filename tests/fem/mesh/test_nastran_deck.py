"""Nastran decks: fields of all widths, continuations, and what is refused, with its line."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from fem_meshes import box
from kanefe.errors import FileError, MeshError
from kanefe_fem.mesh.checks import MeshWarning
from kanefe_fem.mesh.mesh import Mesh, to_order
from kanefe_fem.mesh_files import read_mesh

CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))


def small(*fields: object) -> str:
    return "".join(str(field).ljust(8) for field in fields)


def large(name: str, *fields: object) -> str:
    return name.ljust(8) + "".join(str(field).rjust(16) for field in fields)


CUBE = [small("GRID", i, "", *map(float, xyz)) for i, xyz in enumerate(CORNERS, 1)]
MARKED = [small("CHEXA", 1, 1, 1, 2, 3, 4, 5, 6) + "+a", small("+a", 7, 8)]


def deck(folder: Path, *lines: str, end: str = "ENDDATA\n") -> Path:
    path = folder / "a.bdf"
    path.write_text("\n".join(["SOL 101", "CEND", "BEGIN BULK", *lines, end]))
    return path


def volume(mesh: Mesh) -> float:
    return float(str(mesh).split("m3)")[0].split()[-1])


WAYS = {
    "marked": MARKED,
    "not marked": [small("CHEXA", 1, 1, 1, 2, 3, 4, 5, 6), small("", 7, 8)],
    "only a plus": [small("CHEXA", 1, 1, 1, 2, 3, 4, 5, 6) + "+", small("+", 7, 8)],
    "a comment between": [MARKED[0], "$ 7 and 8 follow", MARKED[1]],
    "tabs": ["CHEXA\t1\t1\t1\t2\t3\t4\t5\t6", "\t7\t8"],
    "lower case, comment behind": [small("chexa", 1, 1, 1, 2, 3, 4, 5, 6) + "$", small("", 7, 8)],
    "free": ["CHEXA,1,1,1,2,3,4,5,6,+", "+,7,8"],
    "free, not marked": ["CHEXA,1,1,1,2,3,4,5,6", ",7,8"],
    "large": [large("CHEXA*", 1, 1, 1, 2), large("*", 3, 4, 5, 6), large("*", 7, 8)],
    "large, free": ["CHEXA*,1,1,1,2", "*,3,4,5,6", "*,7,8"],
    "large, then small": [large("CHEXA*", 1, 1, 1, 2), large("*", 3, 4, 5, 6), small("", 7, 8)],
}


@pytest.mark.parametrize("way", WAYS)
def test_an_element_is_read_in_whatever_fields_it_is_written(way: str, tmp_path: Path) -> None:
    mesh = read_mesh(deck(tmp_path, *CUBE, *WAYS[way], small("PSOLID", 1, 1)))
    assert {name: [b.nodes.tolist() for b in blocks] for name, blocks in mesh.cells.items()} == {"1": [[[*range(8)]]]}
    assert volume(mesh) == 1.0


def test_points_are_read_in_whatever_fields_they_are_written(tmp_path: Path) -> None:
    points = [
        "GRID,1",
        small("GRID", 2, "", "1.", "", "0.0"),
        large("GRID*", 3, "", "0.", "1.D+0") + "*b",
        large("*b", "0."),
        small("GRID", 4, 0, "-.0", "", "10.-1"),
    ]
    mesh = read_mesh(deck(tmp_path, *points, "CTETRA,7,3,1,2,3,4"), names={3: "wedge"})
    assert list(mesh.cells) == ["wedge"]
    np.testing.assert_array_equal(mesh.nodes, [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])


@pytest.mark.parametrize("kind", ["tetra", "hexahedron", "wedge"])
def test_mid_side_nodes_come_to_the_places_of_vtk(kind: str, tmp_path: Path) -> None:
    """As the figures of the Quick Reference Guide have them: each between two corners, here by their numbers."""
    corners = {
        "tetra": [CORNERS[i] for i in (0, 1, 3, 4)],
        "hexahedron": list(CORNERS),
        "wedge": [CORNERS[i] for i in (0, 1, 3, 4, 5, 7)],
    }[kind]
    mids = {
        "tetra": "12 23 13 14 24 34",
        "hexahedron": "12 23 34 14 15 26 37 48 56 67 78 58",
        "wedge": "12 23 13 14 25 36 45 56 46",
    }[kind]
    points = [
        *corners,
        *(np.mean([corners[int(ends[0]) - 1], corners[int(ends[1]) - 1]], axis=0) for ends in mids.split()),
    ]
    rows = [small("GRID", i, "", *(f"{x:.3f}" for x in p)) for i, p in enumerate(points, 1)]
    name = {"tetra": "CTETRA", "hexahedron": "CHEXA", "wedge": "CPENTA"}[kind]
    fields = [1, 1, *range(1, len(points) + 1)]
    card = [small(name if i == 0 else "", *fields[i : i + 8]) for i in range(0, len(fields), 8)]
    mesh = read_mesh(deck(tmp_path, *rows, *card))
    assert mesh.order == 2
    assert to_order(mesh, 1).kind == kind
    straight = to_order(to_order(mesh, 1), 2)
    if straight.kind == mesh.kind:  # a brick of 27 nodes has more
        np.testing.assert_allclose(straight.nodes[straight.connectivity], mesh.nodes[mesh.connectivity], atol=1e-12)
    assert volume(mesh) == pytest.approx({"tetra": 1 / 6, "hexahedron": 1, "wedge": 0.5}[kind], rel=1e-3)


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([*CUBE, small("CHEXA", 1, 1, 1, 2, 3, 4, 5, 6)], r"CHEXA 1 has 6 nodes \(line 12\), where 8 or 20 are read"),
        ([*CUBE, MARKED[0], small("+b", 7, 8)], r"goes on with '\+B' \(line 13\), which the line before does not name"),
        ([small("", 7, 8)], r"goes on with 'a blank field' \(line 4\)"),
        ([*CUBE, MARKED[0], small("+a", 7, 9)], r"no grid point 9, which an element has \(line 12\)"),
        ([*CUBE[:3], small("GRID", 1, "", "2.")], r"grid point 1 twice \(line 7\)"),
        ([small("GRID", "x")], r"field 2 of GRID \(line 4\) is 'x', and should be a whole number"),
        ([small("GRID", 1, "", "1..")], r"field 4 of GRID \(line 4\) is '1\.\.', and should be a number"),
        ([small("CTRIAX6", 1, 1, 1, 2, 3)], r"element CTRIAX6 \(line 4\), which is not read"),
        (["INCLUDE 'more.bdf'"], r"there is no file .*more\.bdf that a\.bdf reads"),
        ([*CUBE, small("GRID", 9, 5), *MARKED], r"GRID 9 \(line 12\) is in coordinate system 5, which is not there"),
        ([CUBE[0], small("", 7, 8)], r"GRID 1 \(line 4\) goes on behind its 8 fields"),
        ([*CUBE, *MARKED, small("", 1), small("", 7, 8)], r"CHEXA 1 \(line 12\) goes on behind its 22 fields"),
        (["BEGIN SUPER=1"], r"superelements, line 4"),
        (["GRID,1,,0.,0.,0.,0,0,0,+,1"], r"has 10 fields in line 4, where 8 and a continuation"),
    ],
)
def test_what_is_not_read_is_refused_with_its_line(lines: list[str], message: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=message):
        read_mesh(deck(tmp_path, *lines))


def test_a_deck_that_was_cut_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"a\.bdf has no ENDDATA"):
        read_mesh(deck(tmp_path, *CUBE, *MARKED, end=""))
    path = tmp_path / "a.bdf"
    path.write_text("\n".join([*CUBE, *MARKED]))  # bulk data alone have none
    assert read_mesh(path).cell_count == 1
    with pytest.raises(MeshError, match=r"a\.bdf has no cells"):
        read_mesh(deck(tmp_path, *CUBE))


def test_masses_and_connections_are_told(tmp_path: Path) -> None:
    path = deck(tmp_path, *CUBE, *MARKED, small("CONM2", 9, 1, "", 5.0), small("RBE2", 10, 1, 123456, 2))
    with pytest.warns(MeshWarning, match=r"left out: CONM2 \(line 14\), RBE2 \(line 15\)\. Remedy"):
        assert read_mesh(path).cell_count == 1


def test_cards_that_are_not_known_are_told(tmp_path: Path) -> None:
    with pytest.warns(MeshWarning, match=r"not known, and left out: CHEX \(line 14\), GRI \(line 15\)\. Remedy"):
        read_mesh(deck(tmp_path, *CUBE, *MARKED, small("CHEX", 9), small("GRI", 9), small("CHEX", 10)))


@pytest.mark.parametrize(
    "point", [("2", "", "1."), ("2", "", "+1", "0"), ("2", "0", "10.-1"), ("2", "", "1.D0", "-0."), (" 2 ", "", ".1E1")]
)
def test_points_of_many_cards_are_read_at_once_and_one_by_one(point: tuple[str, ...], tmp_path: Path) -> None:
    """Numbers of all kinds in small fields; a card in free fields makes all of them be read one by one."""
    card = small("GRID", *point)
    for last in (CUBE[7], "GRID,8,,0.,1.,1."):
        mesh = read_mesh(deck(tmp_path, CUBE[0], card, *CUBE[2:7], last, *MARKED))
        np.testing.assert_array_equal(mesh.nodes, CORNERS)


@pytest.mark.parametrize(
    "line", ["GRID,2,,1.", "GRID, 2 ,, +1 ,0,", "grid,2,0,10.-1", "GRID,2,,1.D0 , -0.", "GRID*,2,,.1E1"]
)
def test_free_fields_of_many_cards_are_read_at_once_and_one_by_one(line: str, tmp_path: Path) -> None:
    """A point in columns makes all of them be read one by one."""
    points = [f"GRID,{i},,{x},{y},{z}" for i, (x, y, z) in enumerate(CORNERS, 1)]
    for last in (points[7], CUBE[7]):
        mesh = read_mesh(deck(tmp_path, points[0], line, *points[2:7], last, "CHEXA, 1,,1,2,3,4,5 ,6,+", "+,7,8"))
        np.testing.assert_array_equal(mesh.nodes, CORNERS)
        assert list(mesh.cells) == ["1"]  # a property that is left out has the number of the element


@pytest.mark.parametrize("field", ["1.5", "x", "1 2"])
def test_a_free_field_that_is_no_whole_number_is_told(field: str, tmp_path: Path) -> None:
    lines = [*CUBE, "CHEXA,1,1,1,2,3,4,5,6,+", f"+,7,{field}"]
    with pytest.raises(FileError, match=rf"field 11 of CHEXA .* is '{re.escape(field)}', and should be a whole number"):
        read_mesh(deck(tmp_path, *lines))


def test_properties_of_shells_are_groups_of_facets(tmp_path: Path) -> None:
    bar = box("hexahedron", (1, 1, 1), (1, 1, 1))
    assert bar.cell_count == 1
    mesh = read_mesh(deck(tmp_path, *CUBE, *MARKED, small("CQUAD4", 2, 7, 1, 2, 3, 4, 30.0)), names={7: "bottom"})
    assert mesh.facets["bottom"][0].nodes.tolist() == [[0, 1, 2, 3]]
