"""Decks whose lines are lost, doubled or cut, or whose fields are swapped: an error, or what the deck says, never less.

What a deck says is found by plain readers of their own, which know nothing of included files or systems.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

import numpy as np
import pytest

from kanefe.errors import FileError, KanefeError, MeshError
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh_files import read_mesh

BRICK = np.array(((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)))
EDGES = (0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)
TETRAHEDRA = (0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)
INP = {"C3D8": 8, "C3D8R": 8, "C3D4": 4, "C3D20": 20, "C3D20R": 20, "S4": 4, "S4R": 4, "MASS": 1}
BDF = {"CHEXA": (8, 20), "CTETRA": (4, 10), "CQUAD4": (4,)}
KNOWN = "HEADING", "NODE", "ELEMENT", "NSET", "ELSET", "MATERIAL", "ELASTIC", "DENSITY", "SOLIDSECTION", "MASS"
LEFT = "PSOLID", "PSHELL", "MAT1", "PARAM", "SPC1", "CONM2"


class Wrong(Exception):
    """A deck says nothing that can be read."""


@dataclass
class Said:
    """What a deck says: cells as rows of points, sets of nodes, and words that something is to be told of."""

    cells: list[np.ndarray] = field(default_factory=list)
    sets: dict[str, np.ndarray] = field(default_factory=dict)
    unknown: list[str] = field(default_factory=list)


def wrong() -> NoReturn:
    raise Wrong


def number(text: str) -> float:
    """A number of either program; blank is 0."""
    if not text.strip():
        return 0.0
    found = re.fullmatch(r"([-+]?(?:\d+\.?\d*|\.\d+))(?:[ED]?([-+]?\d+))?", text.strip().upper())
    return float(f"{found[1]}e{found[2] or 0}") if found else wrong()


def label(text: str) -> int:
    value = number(text)
    return int(value) if value == int(value) and value > 0 else wrong()


def said_by_inp(text: str) -> Said:
    said, nodes, members, rows = Said(), {}, {}, {}
    name, options, width = "", {}, 0
    open_row: list[int] = []
    for line in text.splitlines():
        if line.startswith("**") or not line.strip():
            continue
        if line.startswith("*"):
            if open_row:
                wrong()
            first, *rest = line[1:].split(",")
            name = "".join(first.split()).upper()
            options = {part.partition("=")[0].strip().upper(): part.partition("=")[2].strip() for part in rest}
            if not name or (name == "ELEMENT" and options.get("ELSET") == ""):
                wrong()
            if name not in KNOWN:
                said.unknown.append(f"*{name}")
            if name == "ELEMENT":
                width = INP.get(options.get("TYPE", "").upper(), 0) or wrong()
            if "NSET" in options or name == "NSET":
                members.setdefault(options.get("NSET", "").upper() or wrong(), [])
            continue
        fields = line.rstrip(", ").split(",")
        if not name:
            wrong()
        if name == "NODE":
            if len(fields) > 7:
                wrong()
            nodes[label(fields[0])] = ([number(x) for x in fields[1:]] + [0.0] * 3)[:3]
        if name in ("NODE", "NSET") and "NSET" in options:
            members[options["NSET"].upper()] += [label(x) for x in (fields[:1] if name == "NODE" else fields)]
        if name == "ELEMENT":
            open_row += [label(x) for x in fields]
            if len(open_row) > 1 + width:
                wrong()
            if len(open_row) == 1 + width:
                if open_row[0] in rows:
                    wrong()
                rows[open_row[0]] = open_row[1:] if options["TYPE"].upper() != "MASS" else []
                open_row = []
    if open_row or any(x not in nodes for row in [*rows.values(), *members.values()] for x in row):
        wrong()
    said.cells = [np.array([nodes[x] for x in row]) for row in rows.values() if row]
    said.sets = {key: np.array([nodes[x] for x in sorted(set(ids))]) for key, ids in members.items() if ids}
    return said


def said_by_bdf(text: str) -> Said:
    said, nodes, cards = Said(), {}, []
    mark = ""
    lines = text.splitlines()
    if lines.count("BEGIN BULK") > 1:
        wrong()
    if "BEGIN BULK" in lines:
        lines = lines[lines.index("BEGIN BULK") + 1 :]
        if not any(line.strip().startswith("ENDDATA") for line in lines):
            wrong()
    for line in lines:
        line = line.partition("$")[0].rstrip()
        if line.strip().startswith("ENDDATA"):
            break
        if not line:
            continue
        if "," in line:
            name, *fields = (x.strip() for x in line.rstrip(", ").split(","))
            most = 4 if "*" in name else 8
            if len(fields) > most + 1:
                wrong()
            own, fields = "".join(fields[most:]), [*fields[:most], *[""] * (most - len(fields))]
        else:
            name, width = line[:8].strip(), 16 if "*" in line[:8] else 8
            fields, own = [line[i : i + width].strip() for i in range(8, 72, width)], line[72:].strip()
        if name == "" or name[0] in "+*":
            if not cards or (name.strip("+*") and mark.strip("+*") and name.strip("+*") != mark.strip("+*")):
                wrong()
            cards[-1][1].extend(fields)
        elif name[0] == "=":
            wrong()
        else:
            cards.append((name.rstrip("*").upper(), fields))
        mark = own
    for name, fields in cards:
        fields += [""] * 8
        if name == "GRID":
            if any(fields[8:]) or any("." in fields[i] for i in (0, 1, 5)):
                wrong()
            if any(fields[i] not in ("", "0") for i in (1, 5)):
                wrong()  # no systems are in these decks
            key, place = label(fields[0]), [number(x) for x in fields[2:5]]
            if nodes.setdefault(key, place) != place:
                wrong()
        elif name in BDF:
            pass
        elif name not in LEFT:
            said.unknown.append(name)
    for name, fields in cards:
        if name in BDF:
            most = max(BDF[name])
            given = fields[2 : 2 + most]
            while given and given[-1] in ("", "0"):
                given.pop()
            if len(given) not in BDF[name] or (name != "CQUAD4" and any(fields[2 + most :])):
                wrong()
            if any("." in x for x in fields[:2]):
                wrong()
            labels = [label(x) if "." not in x else wrong() for x in given]
            if any(x not in nodes for x in labels):
                wrong()
            said.cells.append(np.array([nodes[x] for x in labels]))
    return said


def box(rng: np.random.Generator) -> tuple[np.ndarray, list[np.ndarray], str]:
    """Points, cells and the kind of cells of a few bricks in a row."""
    count, kind = int(rng.integers(1, 5)), str(rng.choice(["brick", "tetrahedron", "brick20"]))
    points = np.array([(i, j, k) for i in range(count + 1) for j in (0, 1) for k in (0, 1)], float)
    points = (points + rng.uniform(-0.1, 0.1, points.shape)).round(4)
    bricks = [BRICK @ (4, 2, 1) + 4 * i for i in range(count)]
    if kind == "tetrahedron":
        return points, [brick[list(some)] for brick in bricks for some in TETRAHEDRA], kind
    if kind == "brick":
        return points, bricks, kind
    edges = sorted({tuple(sorted((int(b[i]), int(b[j])))) for b in bricks for i, j in EDGES})
    mids = np.array([points[list(edge)].mean(axis=0) for edge in edges])
    row = {edge: len(points) + i for i, edge in enumerate(edges)}
    full = [np.array([*b, *(row[tuple(sorted((int(b[i]), int(b[j]))))] for i, j in EDGES)]) for b in bricks]
    return np.vstack((points, mids.round(5))), full, kind


def inp(rng: np.random.Generator) -> str:
    points, cells, kind = box(rng)
    labels = rng.permutation(np.arange(1, 2 * len(points)))[: len(points)]
    name = rng.choice({"brick": ["C3D8", "C3D8R"], "tetrahedron": ["C3D4"], "brick20": ["C3D20", "C3D20R"]}[kind])
    cut = int(rng.integers(1, 1 + len(points)))
    node = [f"{labels[i]}, " + ", ".join(repr(x) for x in points[i].tolist()) for i in range(len(points))]
    lines = ["*HEADING", "a deck", "*NODE, NSET=LOW", *node[:cut], "** the rest", "*NODE", *node[cut:]]
    half = int(rng.integers(1, 1 + len(cells)))
    for key, some, first in (("ONE", cells[:half], 1), ("TWO", cells[half:], 1 + half)):
        lines += [f"*ELEMENT, TYPE={name}, ELSET={key}"] if len(some) else []
        for i, cell in enumerate(some, first):
            row = [i, *labels[cell].tolist()]
            lines += [
                ", ".join(map(str, row[j : j + 10])) + ("," if row[j + 10 :] else "") for j in range(0, len(row), 10)
            ]
    lines += ["*ELEMENT, TYPE=S4, ELSET=SKIN", "1001, " + ", ".join(str(labels[i]) for i in cells[0][:4])]
    lines = lines if kind == "brick" else lines[:-2]
    for key in ("TIP", "ROOT"):
        lines += [f"*NSET, NSET={key}", ", ".join(map(str, rng.choice(labels, 4).tolist()))]
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", "2.1E11, 0.3", "*DENSITY", "7850."]
    lines += ["*SOLID SECTION, ELSET=ONE, MATERIAL=M"] + (
        ["*SOLID SECTION, ELSET=TWO, MATERIAL=M"] * (half < len(cells))
    )
    return "\n".join(lines) + "\n"


def bdf(rng: np.random.Generator) -> str:
    points, cells, kind = box(rng)
    labels = rng.permutation(np.arange(1, 2 * len(points)))[: len(points)]
    way = int(rng.integers(0, 4))

    def card(name: str, *fields: object) -> list[str]:
        texts = [repr(x) if isinstance(x, float) else str(x) for x in fields]
        most = 4 if way == 1 else 8
        rows = [texts[i : i + most] for i in range(0, len(texts), most)]
        if way == 2:  # free
            return [",".join([name if i == 0 else "", *row]) for i, row in enumerate(rows)]
        wide = 16 if way == 1 else 8
        begins = [(f"{name}*" if way == 1 else name), *(["*" if way == 1 else "+" * (way == 3)] * (len(rows) - 1))]
        lines = [begin.ljust(8) + "".join(x.rjust(wide) for x in row) for begin, row in zip(begins, rows, strict=True)]
        return [f"{line:72}+" if way == 3 and line is not lines[-1] else line for line in lines]

    lines = ["SOL 101", "CEND", "BEGIN BULK", "PARAM,POST,-1"]
    for i, point in zip(labels.tolist(), points.tolist(), strict=True):
        lines += card("GRID", i, "", *point)
    order = [*range(12), *range(16, 20), *range(12, 16)] if kind == "brick20" else range(8)
    for i, cell in enumerate(cells, 1):
        row = cell if kind == "tetrahedron" else cell[[order.index(j) for j in range(len(cell))]]
        lines += card("CTETRA" if kind == "tetrahedron" else "CHEXA", i, 1, *labels[row].tolist())
    if kind == "brick":
        lines += card("CQUAD4", 1001, 2, *labels[cells[0][:4]].tolist())
    lines += ["$ properties", *card("PSOLID", 1, 1), *card("MAT1", 1, 2.1e5, "", 0.3), "ENDDATA"]
    return "\n".join(lines) + "\n"


def mutated(text: str, rng: np.random.Generator) -> str:
    """A line lost, doubled, cut, or with two fields swapped."""
    lines = text.split("\n")[:-1]
    at = int(rng.integers(0, len(lines)))
    what = rng.integers(0, 4)
    if what == 0:
        del lines[at]
    elif what == 1:
        lines.insert(at, lines[at])
    elif what == 2:
        lines[at] = lines[at][: int(rng.integers(0, len(lines[at]) + 1))]
    else:
        parts = lines[at].split(",") if "," in lines[at] else re.findall(r".{1,8}", lines[at])
        i, j = rng.integers(0, max(len(parts), 1), 2)
        if parts:
            parts[i], parts[j] = parts[j], parts[i]
            lines[at] = ("," if "," in lines[at] else "").join(parts)
    return "\n".join(lines) + "\n"


def cells_of(mesh: Mesh) -> list[np.ndarray]:
    blocks = [*mesh.cell_blocks, *(b for some in [*mesh.facets.values(), *mesh.lines.values()] for b in some)]
    return [np.asarray(mesh.nodes)[row] for block in blocks for row in block.nodes]


def sorted_rows(cells: list[np.ndarray]) -> list[tuple[float, ...]]:
    """Cells in any order, of each its points in any order."""
    return sorted(tuple(sorted(map(tuple, cell.tolist()))) for cell in cells)


def check(seed: int, make: Callable[..., str], said_by: Callable[[str], Said], suffix: str, folder: Path) -> str:
    """Read a mutated deck: return "read", "told" or "refused"; fail where it is none, or other than what it says."""
    rng = np.random.default_rng(seed)
    whole = make(rng)
    text = mutated(whole, rng)
    path = folder / f"a{suffix}"
    path.write_text(text)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            mesh = read_mesh(path)
        except FileError as error:
            if not re.search(r"line \d+|has no ENDDATA", str(error)):
                pytest.fail(f"{seed}: no line in {error}")
            try:
                is_same = sorted_rows(said_by(text).cells) == sorted_rows(said_by(whole).cells)
            except Wrong:
                is_same = False
            if is_same:
                pytest.fail(f"{seed}: the deck says the same as before: {error}")
            return "refused"
        except MeshError:  # what is read is no body: folded cells, pieces, cells twice, none
            return "refused"
        except KanefeError as error:
            pytest.fail(f"{seed}: {error!r}")
    told = " ".join(str(warning.message) for warning in caught)
    said = said_by(text)
    for name in said.unknown:
        assert name in told, f"{seed}: {name} is not told"
    ours, theirs = sorted_rows(cells_of(mesh)), sorted_rows(said.cells)
    if len(ours) < len(theirs):
        assert re.search("cells belong to no group|is not known", told), (
            f"{seed}: {len(theirs)} cells, {len(ours)} read"
        )
        assert set(ours) <= set(theirs), f"{seed}: other cells"
    else:
        assert ours == theirs, f"{seed}: other cells"
    sets = {
        name.upper(): sorted(map(tuple, np.asarray(mesh.nodes)[rows].tolist())) for name, rows in mesh.points.items()
    }
    assert sets == {name: sorted(map(tuple, points.tolist())) for name, points in said.sets.items()}, f"{seed}: sets"
    return "told" if caught else "read"


WAYS = {".inp": (inp, said_by_inp), ".bdf": (bdf, said_by_bdf)}


@pytest.mark.parametrize("suffix", WAYS)
@pytest.mark.parametrize(
    "seeds", [range(60), pytest.param(range(60, 2000), marks=pytest.mark.slow)], ids=["few", "all"]
)
def test_mutated_decks_are_refused_or_read_as_they_are(seeds: range, suffix: str, tmp_path: Path) -> None:
    make, said_by = WAYS[suffix]
    found = [check(seed, make, said_by, suffix, tmp_path) for seed in seeds]
    assert {"read", "refused"} <= set(found)


@pytest.mark.parametrize("suffix", WAYS)
def test_decks_are_whole_before(suffix: str, tmp_path: Path) -> None:
    make, said_by = WAYS[suffix]
    for seed in range(20):
        path = tmp_path / f"a{suffix}"
        path.write_text(make(np.random.default_rng(seed)))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            mesh = read_mesh(path)
        said = said_by(path.read_text())
        assert not said.unknown
        assert sorted_rows(cells_of(mesh)) == sorted_rows(said.cells)
