"""Places of Nastran's grid points: systems in systems, fields of all widths, what is repeated and what is included."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from kanefe.errors import FileError
from kanefe.frames import rotation_matrix
from kanefe.imports.bulk_data import bulk_cards
from kanefe.imports.grid_points import GridPoints, grid_points


def read(folder: Path, *lines: str) -> GridPoints:
    path = folder / "a.bdf"
    path.write_text("\n".join(lines))
    return grid_points(bulk_cards(path))


def free(name: str, *fields: object) -> list[str]:
    """A card with its fields, which continue after eight."""
    rows = [fields[i : i + 8] for i in range(0, len(fields), 8)]
    return [",".join([name if i == 0 else "", *map(str, row)]) for i, row in enumerate(rows)]


def large(name: str, *fields: object) -> list[str]:
    rows = [fields[i : i + 4] for i in range(0, len(fields), 4)]
    return [
        (f"{name}*" if i == 0 else "*").ljust(8) + "".join(str(f).rjust(16) for f in row) for i, row in enumerate(rows)
    ]


def seen_from(kind: str, local: np.ndarray) -> np.ndarray:
    """The coordinates that a system of some kind has of a point in its own rectangular axes."""
    x, y, z = local
    if kind == "R":
        return local
    if kind == "C":
        return np.array((np.hypot(x, y), np.degrees(np.arctan2(y, x)), z))
    return np.array(
        (np.linalg.norm(local), np.degrees(np.arccos(z / np.linalg.norm(local))), np.degrees(np.arctan2(y, x)))
    )


def test_points_in_systems_in_systems(tmp_path: Path) -> None:
    """Each system is drawn in basic, and written as its parent sees it; so are the points."""
    rng = np.random.default_rng(20261129)
    placed = {0: ("R", np.zeros(3), np.eye(3))}

    def within(number: int, point: np.ndarray, digits: int = 15) -> list[str]:
        kind, origin, A = placed[number]
        return [f"{x:.{digits}E}" for x in seen_from(kind, A.T @ (point - origin))]

    lines: list[str] = []
    for number in rng.permutation(np.arange(1, 31)):
        parent, kind = int(rng.choice(list(placed))), str(rng.choice(list("RCS")))
        A, origin = rotation_matrix(rng.normal(size=4)), rng.uniform(-3, 3, 3)
        corners = origin, origin + rng.uniform(0.5, 2) * A[:, 2], origin + A @ (rng.uniform(0.5, 2), 0, rng.normal())
        fields = [int(number), parent, *(x for corner in corners for x in within(parent, corner))]
        placed[int(number)] = kind, origin, A
        lines[:0] = free(f"CORD2{kind}", *fields)  # a system before that which it is given in
    points, numbers = rng.uniform(-5, 5, (200, 3)), rng.integers(0, 31, (200, 2))
    for i, (point, (number, turned)) in enumerate(zip(points, numbers, strict=True)):
        write, digits = (free, 15) if i % 2 else (large, 9)
        lines += write("GRID", i + 1, number, *within(int(number), point, digits), turned)
    found = read(tmp_path, *lines)
    # angles in degrees and three systems within each other: some 100 times round-off of 5 m
    np.testing.assert_allclose(found.points[1::2], points[1::2], atol=1e-12)
    np.testing.assert_allclose(found.points, points, atol=2e-8)  # angles of 180 degrees with nine digits, 10 m away
    assert found.axes is not None
    for A, point, turned in zip(found.axes, found.points, numbers[:, 1], strict=True):
        kind, origin, axes = placed[int(turned)]
        h = 1e-6
        if kind == "R":
            np.testing.assert_allclose(A, axes, atol=1e-13)
            continue
        first = A[:, 0]  # radial: it keeps both angles (of C the height too), and r grows by h
        grown = seen_from(kind, axes.T @ (point + h * first - origin)) - seen_from(kind, axes.T @ (point - origin))
        np.testing.assert_allclose(grown, (h, 0, 0), atol=1e-12)  # angles in degrees, of 1e-16 / 0.1 m
        middle = np.cross(axes[:, 2], point - origin)
        np.testing.assert_allclose(A[:, 1 if kind == "C" else 2], middle / np.linalg.norm(middle), atol=1e-12)
        np.testing.assert_allclose(A.T @ A, np.eye(3), atol=1e-14)
        assert np.linalg.det(A) > 0


def test_a_system_of_three_grid_points(tmp_path: Path) -> None:
    """Two on one card, the second of them by points in the first."""
    found = read(
        tmp_path,
        "CORD1R,7,101,102,103,8,201,202,203",
        "GRID,101,,1.,0.,0.",
        "GRID,102,,1.,0.,1.",
        "GRID,103,,1.,1.,0.",
        "GRID,201,7,1.,0.,0.",
        "GRID,202,7,1.,0.,1.",
        "GRID,203,7,2.,0.,0.",
        "GRID,1,7,2.,0.,0.5",
        "GRID,2,8,2.,0.,0.5",
    )
    np.testing.assert_allclose(found.points[-2:], [(1, 2, 0.5), (1, 3, 0.5)], atol=1e-15)


def test_what_grdset_says_holds_where_a_point_says_nothing(tmp_path: Path) -> None:
    system = "CORD2R,7,,10.,0.,0.,10.,0.,1.\n,10.,1.,0."
    found = read(tmp_path, "GRDSET,,7,,,,7", system, "GRID,1,,1.", "GRID,2,0,1.,,,0")
    np.testing.assert_allclose(found.points, [(10, 1, 0), (1, 0, 0)], atol=1e-15)
    assert found.axes is not None
    np.testing.assert_allclose(found.axes[0], [(0, -1, 0), (1, 0, 0), (0, 0, 1)], atol=1e-15)
    np.testing.assert_array_equal(found.axes[1], np.eye(3))


def test_on_the_axis_of_a_system_its_first_axis_is_radial(tmp_path: Path) -> None:
    for kind in "CS":
        found = read(
            tmp_path, f"CORD2{kind},7,,0.,0.,0.,0.,0.,1.", ",0.,1.,0.", "GRID,1,,0.,0.,2.,7", "GRID,2,,3.,0.,0."
        )
        assert found.axes is not None
        radial = found.axes[0][:, 0 if kind == "C" else 1]
        np.testing.assert_allclose(radial, (0, 1, 0), atol=1e-15)


@pytest.mark.parametrize(
    "repeated",
    [
        ["=,*1,=,*1.,=,*2."] * 3,
        ["=,*1,=,*1.,=,*2.", "=2"],
        ["=,*(1),=,*(1.),=,*(2.)", "=(2)"],
        ["=       *1      =       *1.     =       *2.", "=(2)"],
        ["=(3),*1,=,*1.,=,*2."],
        ["=,*1,=,*1.,=,2.", "GRID,3,,2.,,4.", "GRID,4,,3.,,6."],
    ],
)
def test_cards_that_repeat_the_one_before(repeated: list[str], tmp_path: Path) -> None:
    found = read(tmp_path, "GRID,1,,0.,,0.", *repeated, "GRID,9")
    assert found.labels.tolist() == [1, 2, 3, 4, 9]
    np.testing.assert_allclose(found.points[:4], np.outer(np.arange(4), (1, 0, 2)))


def test_the_rest_of_a_card_is_repeated(tmp_path: Path) -> None:
    np.testing.assert_allclose(read(tmp_path, "GRID,1,,1.,2.,3.", "=,*1,==").points, [(1, 2, 3)] * 2)


def test_included_files_are_found_beside_the_deck_and_beside_their_own(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub/outer.bdf").write_text("INCLUDE 'inner.bdf'\nGRID,2,,2.")
    (tmp_path / "sub/inner.bdf").write_text("GRID,1,,1.")
    lines = "INCLUDE 'sub/", "outer.bdf'", "GRID,3,,3."  # a long name goes on in the next line
    assert read(tmp_path, *lines).labels.tolist() == [1, 2, 3]
    (tmp_path / "inner.bdf").write_text("GRID,1,,1.")
    assert read(tmp_path, *lines).labels.tolist() == [1, 2, 3]
    (tmp_path / "inner.bdf").write_text("GRID,1,,4.")
    with pytest.raises(FileError, match=r"outer\.bdf includes inner\.bdf \(line 1\), which is both .* and they differ"):
        read(tmp_path, *lines)


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (["GRID,1,5"], r"GRID 1 \(line 1\) is in coordinate system 5, which is not there"),
        (["GRID,1,,,,,5"], r"GRID 1 \(line 1\) is in coordinate system 5, which is not there"),
        (
            ["CORD2R,5,6,0.,0.,0.,0.,0.,1.", ",1.,0.,0.", "CORD2R,6,5,0.,0.,0.,0.,0.,1.", ",1.,0.,0.", "GRID,1,5"],
            "itself",
        ),
        (["CORD2R,5,,0.,0.,0.,0.,0.,1.", ",0.,0.,2.", "GRID,1,5"], r"CORD2R 5 \(line 1\) has three points on one line"),
        (["CORD1R,5,1,2,3", "GRID,1", "GRID,4,5"], r"placed by grid point 2, which is not there"),
        (["GRDSET,,5", "GRDSET,,6"], r"GRDSET twice \(line 2\)"),
        (["CORD3G,5,4", "GRID,1,5"], r"CORD3G 5 \(line 1\) places nodes in a way that is not read"),
        (["GRID,1", "SEMPLN,5,PLANE,1,2,3"], r"SEMPLN 5 \(line 2\) places nodes in a way that is not read"),
        (["GRID,1", "GRID,1,,1."], r"grid point 1 twice \(line 2\)"),
        (["=,*1"], r"begins line 1 with '=', and no card is before it that is repeated"),
        (["GRID,1,,1.", "=4"], r"repeats what was not raised before \(line 2\)"),
        (["INCLUDE 'a.bdf'"], r"includes itself"),
        (["INCLUDE 'more"], r"INCLUDE \(line 1\) has no end"),
        (["INCLUDE '../more.bdf'"], r"there is no file"),
    ],
)
def test_what_places_no_point_is_refused_with_its_line(lines: list[str], message: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=message):
        read(tmp_path, *lines)


def test_a_file_outside_the_folder_needs_trust(tmp_path: Path) -> None:
    (tmp_path / "more.bdf").write_text("GRID,1")
    (tmp_path / "own").mkdir()
    with pytest.raises(FileError, match=r"does not lie below .* read_nastran\(\.\.\., trusted=True\)"):
        read(tmp_path / "own", "INCLUDE '../more.bdf'")
    assert len(bulk_cards(tmp_path / "own/a.bdf", trusted=True)) == 1
