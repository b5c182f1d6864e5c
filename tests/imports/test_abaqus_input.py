"""Input files of Abaqus and CalculiX: where nodes are, what sets have, and which rows matrices without labels have."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import import_writers as write
import kanefe as kf
from kanefe.errors import FileError, ModelError
from kanefe.imports.abaqus_input import keywords
from kanefe.imports.abaqus_job import Job, job_of
from kanefe.imports.included import DeckWarning

CUBE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)], float)
NODES = "*NODE, NSET=ALL\n" + "".join(f"{i},{x},{y},{z}\n" for i, (x, y, z) in enumerate(CUBE.tolist(), 1))
CELL = "*ELEMENT, TYPE=C3D8, ELSET=E\n1,1,2,3,4,5,6,7,8\n"
TRANSFORM = "*NSET, NSET=T\n2, 7\n*TRANSFORM, NSET=T, TYPE={}\n"


def job(folder: Path, text: str) -> Job:
    path = folder / "a.inp"
    path.write_text(text)
    return job_of(path, trusted=False)


def test_nodes_in_systems(tmp_path: Path) -> None:
    found = job(
        tmp_path,
        "*NODE, SYSTEM=C\n1,2.,90.,1.\n"
        "*SYSTEM\n10,0,0\n*NODE\n2,1,2,3\n"  # moved
        "*SYSTEM\n0,0,0, 0,2,7\n*NODE\n3,1,2,3\n"  # turned about z, the first axis along y
        "*SYSTEM\n1,0,0, 1,0,1\n1,1,0\n*NODE\n4,1,2,3\n"  # axes along z, y and -x
        "*NODE, SYSTEM=C\n5,2,90,3\n*SYSTEM\n*NODE\n6,1,2,3\n",
    )
    expected = [(0, 2, 1), (11, 2, 3), (-2, 1, 3), (-2, 2, 1), (-2, 2, 0), (1, 2, 3)]
    np.testing.assert_allclose(found.nodes.points, expected, atol=1e-15)  # sines of 90 degrees, times 2 m


def test_nodes_that_are_generated_and_copied(tmp_path: Path) -> None:
    """A copy is moved once, then turned as often as MULTIPLE says; NGEN takes the ends into its set (manual)."""
    found = job(
        tmp_path,
        "*NODE\n1,0,0,0\n7,3,0,0\n*NGEN, NSET=LINE\n1,7,2\n7,1,3\n"
        "*NCOPY, CHANGE NUMBER=10, OLD SET=LINE, NEW SET=NEXT, SHIFT, MULTIPLE=3\n0,0,1\n1,0,0, 1,0,5, 30.\n",
    )
    assert found.nodes.labels.tolist() == [1, 3, 4, 5, 7, 11, 13, 14, 15, 17]
    np.testing.assert_allclose(found.nodes.points[:5], [(x, 0, 0) for x in (0, 1, 1.5, 2, 3)], atol=1e-15)
    np.testing.assert_allclose(found.nodes.points[5:], [(1, x - 1, 1) for x in (0, 1, 1.5, 2, 3)], atol=1e-14)
    assert {name: ids.tolist() for name, ids in found.nodes.sets.items()} == {
        "LINE": [1, 3, 4, 5, 7],
        "NEXT": [11, 13, 14, 15, 17],
    }


def test_a_node_that_is_given_twice_is_told(tmp_path: Path) -> None:
    with pytest.warns(DeckWarning, match=r"a\.inp: node 2 is given twice, at different places: the last .*\(line 4\)"):
        assert job(tmp_path, "*NODE\n1,0\n2,1\n2,5\n").nodes.points[1, 0] == 5.0
    with pytest.warns(DeckWarning, match="node 1 and 1 more are given twice"):
        job(tmp_path, "*NODE\n1,0\n2,1\n*NODE\n2,5\n1,7\n")


def test_sets_by_elements_of_any_type(tmp_path: Path) -> None:
    found = job(
        tmp_path, NODES + "*ELEMENT, TYPE=U7, ELSET=E\n1,1,\n2\n2,5\n*NSET, NSET=S, ELSET=e\n*NSET, NSET=R\n s, 8\n"
    )
    assert found.nodes.sets["S"].tolist() == [1, 2, 5]
    assert found.nodes.sets["R"].tolist() == [1, 2, 5, 8]
    assert found.used.tolist() == [1, 2, 5]


def test_axes_of_nodes(tmp_path: Path) -> None:
    found = job(tmp_path, NODES + TRANSFORM.format("R") + "1.,1.,0.,-1.,1.,0.\n")
    assert found.nodes.axes is None
    assert found.turned.axes is not None
    s = np.sqrt(0.5)
    np.testing.assert_allclose(found.turned.axes[1], [(s, -s, 0), (s, s, 0), (0, 0, 1)], atol=1e-15)
    np.testing.assert_array_equal(found.turned.axes[0], np.eye(3))
    around = job(tmp_path, NODES + TRANSFORM.format("C") + "0,0,0,0,1,0\n").turned  # about y: node 7 is at 1, 1, 1
    assert around.axes is not None
    np.testing.assert_allclose(around.axes[6], [(s, s, 0), (0, 0, 1), (s, -s, 0)], atol=1e-15)
    for bad in ("S\n0,0,0,0,1,0\n", "R\n1,0,0\n", "R\n1,0,0,2,0,0\n"):
        with pytest.raises(FileError, match=r"\*TRANSFORM \(line 12\)"):
            job(tmp_path, NODES + TRANSFORM.format("")[:-1] + bad)


def springs() -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and mass of a free body: springs between all corners of a cube, and equal masses."""
    K = np.zeros((24, 24))
    for a in range(8):
        for b in range(a):
            n = (CUBE[a] - CUBE[b]) / np.linalg.norm(CUBE[a] - CUBE[b])
            end = np.zeros(24)
            end[3 * a : 3 * a + 3], end[3 * b : 3 * b + 3] = n, -n
            K += 1e3 * np.outer(end, end)
    return K, np.eye(24)


def by_rows(folder: Path, deck: str) -> kf.FiniteElementModel:
    """Return the model of matrices in coordinate style: row, column, value of the upper triangle."""
    paths = [folder / f"part_{name}1.mtx" for name in ("STIF", "MASS")]
    for path, matrix in zip(paths, springs(), strict=True):
        path.write_text("".join(f"{i + 1} {j + 1} {matrix[i, j]:20.13e}\n" for j in range(24) for i in range(j + 1)))
    (folder / "part.inp").write_text(deck)
    return kf.read_abaqus(folder / "part.inp", *paths)


def test_nodes_of_no_element_have_no_rows(tmp_path: Path) -> None:
    more = NODES + "*NODE\n100,5.,5.,5.\n"
    assert by_rows(tmp_path, more + CELL).groups["ALL"].position == pytest.approx([0.5] * 3)
    with pytest.raises(ModelError, match=r"24 rows for 9 nodes and no labels .*Remedy: FORMAT=MATRIX INPUT, or"):
        by_rows(tmp_path, more)


def test_rows_that_two_counts_of_nodes_would_make_are_refused(tmp_path: Path) -> None:
    """24 rows are three of the 8 nodes of elements, or two of all 12."""
    with pytest.raises(ModelError, match="24 rows for 12 nodes, 8 of them of elements"):
        by_rows(tmp_path, NODES + "*NODE\n9\n10\n11\n12\n" + CELL)


@pytest.mark.parametrize("kind", ["R", "C"])
def test_matrices_of_abaqus_are_in_the_axes_of_nodes(kind: str, tmp_path: Path) -> None:
    """A body turned node by node comes back as it was; written in global axes with these nodes it is refused."""
    K, M = springs()
    data = "1.,1.,0.,-1.,1.,0.\n" if kind == "R" else "0.,0.,-1.,0.,0.,1.\n"
    found = job(tmp_path, NODES + CELL + TRANSFORM.format(kind) + data).turned
    assert found.axes is not None
    A = np.zeros((24, 24))
    for i, axes in enumerate(found.axes):
        A[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = axes
    paths = [tmp_path / "k.mtx", tmp_path / "m.mtx"]
    for turn, is_read in ((A, True), (np.eye(24), False)):
        for path, matrix in zip(paths, (K, M), strict=True):
            local = turn.T @ matrix @ turn
            path.write_text(
                "".join(
                    f"{i // 3 + 1},{i % 3 + 1},{j // 3 + 1},{j % 3 + 1},{local[i, j]:.16e}\n"
                    for i in range(24)
                    for j in range(i + 1)
                )
            )
        if not is_read:
            with pytest.raises(ModelError):
                kf.read_abaqus(tmp_path / "a.inp", *paths)
            continue
        model = kf.read_abaqus(tmp_path / "a.inp", *paths)
        np.testing.assert_allclose(model.stiffness.toarray(), K, atol=1e-9)  # 1e-12 of 1e3 N/m


def test_nodes_of_several_instances_are_refused(tmp_path: Path) -> None:
    instance = "*INSTANCE, NAME={}, PART=P\n*END INSTANCE\n"
    text = f"*PART, NAME=P\n{NODES}*END PART\n*ASSEMBLY\n{instance.format('I')}{{}}*END ASSEMBLY\n"
    assert job(tmp_path, text.format("")).nodes.sets["ALL"].tolist() == [*range(1, 9)]
    with pytest.raises(ModelError, match=r"of 2 instances that share labels \(lines 13, 15\)"):
        job(tmp_path, text.format(instance.format("J")))


def test_tables_of_lines_are_those_of_single_lines() -> None:
    """Blocks are read at once where they are plain, else line by line; both give the same."""
    rng = np.random.default_rng(20261129)
    for _ in range(200):
        rows = [[str(rng.integers(1, 99)), *map(repr, rng.normal(size=3).tolist())] for _ in range(rng.integers(1, 6))]
        text = "*NODE\n" + "".join(
            ("  " if rng.random() < 0.2 else "") + (", " if rng.random() < 0.5 else ",").join(row)
            + (rng.choice([",", ", ", " "]) if rng.random() < 0.3 else "") + "\n"
            for row in rows
        )  # fmt: skip
        table = keywords(text, "a.inp")[0].table()
        assert table is not None
        assert table.counts.tolist() == [4] * len(rows)
        np.testing.assert_array_equal(table.values, np.array(rows, float).ravel())
    for line in ("1,2,,3", "1,2 3", "1,2.D0", "1,nan", "1,1_0", "1,0x1"):
        assert keywords(f"*NODE\n{line}\n", "a.inp")[0].table() is None


@pytest.mark.parametrize("name", ["a bar", write.__name__])
def test_a_keyword_goes_on_where_parameters_follow(name: str) -> None:
    text = f"*HEADING\n{name}\n*ELEMENT, TYPE=C3D8,\n ELSET=E,\n solid element numbering=ISO\n1,2\n*NSET,NSET=A,\nB,C\n"
    head, element, nodes = keywords(text, "a.inp")
    assert head.lines == [name]
    assert element.options == {"TYPE": "C3D8", "ELSET": "E", "SOLID ELEMENT NUMBERING": "ISO"}
    assert element.numbered == [(6, "1,2")]
    assert nodes.numbered == [(8, "B,C")]
