"""Input files drawn at random, written in all ways that CalculiX knows, and what it says of their nodes and masses."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

TYPES = {
    "C3D8": 8,
    "C3D8R": 8,
    "C3D8I": 8,
    "C3D20": 20,
    "C3D20R": 20,
    "C3D6": 6,
    "C3D15": 15,
    "C3D4": 4,
    "C3D10": 10,
}
"""Types that are drawn, and their numbers of nodes."""

EDGES = {
    4: ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
    6: ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
    8: ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
}
"""Ends of the edges with mid-side nodes, by the number of corners, in the order of CalculiX."""

PARTS = {
    8: ((0, 1, 2, 3, 4, 5, 6, 7),),
    6: ((0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7)),
    4: ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)),
}
"""Cells of a brick by their number of corners."""

DENSITIES = {"ONE": 7850.0, "TWO": 2700.0}
"""Of the two element sets, kg/m3."""

REFERENCE = (9.0, 9.0, 0.0)
"""Where nodes of no element are."""

MOST = 16
"""Number of fields of a line, at most."""


@dataclass
class Deck:
    """A deck.

    Attributes
    ----------
    files : dict of str to str
        Texts by name; the main one is "a.inp".
    sets : list of str
        Names of its sets of nodes.
    held : list of int
        Three nodes that a run holds.
    point_mass : float
        Of its elements MASS, kg.
    """

    files: dict[str, str] = field(default_factory=dict)
    sets: list[str] = field(default_factory=list)
    held: list[int] = field(default_factory=list)
    point_mass: float = 0.0


def deck_of(seed: int) -> Deck:
    """Return a box of up to 27 bricks, or of the cells in them, with moved corners and labels in any order."""
    rng = np.random.default_rng(seed)
    name = str(rng.choice(list(TYPES)))
    points, cells = _mesh(TYPES[name], rng)
    labels = rng.permutation(np.arange(1, 3 * len(points)))[: len(points)] * int(rng.choice((1, 7)))
    deck = Deck(held=[int(x) for x in labels[cells[0, :3]]])
    nodes, reference = _nodes(points, labels, rng, deck)
    rows = [[10 * (i + 1), *labels[cell].tolist()] for i, cell in enumerate(cells)]
    is_one = rng.random(len(rows)) < 0.6
    is_one[0], is_one[-1] = True, False
    text = [*nodes]
    for key, wanted in (("ONE", is_one), ("TWO", ~is_one)):
        some = [row for row, own in zip(rows, wanted, strict=True) if own]
        cut = int(rng.integers(0, len(some)))
        for part in (some[:cut], some[cut:]):
            if part:
                text += [f"*{_cased('ELEMENT', rng)}, TYPE={_cased(name, rng)}, ELSET={_cased(key, rng)}"]
                text += [line for row in part for line in _wrapped(row, rng)]
    text += _sets(labels, reference, deck, rng)
    for key, density in DENSITIES.items():
        text += [f"*MATERIAL, NAME=M{key}", "*ELASTIC", "2.1D11, .3", "*DENSITY", f"{density}"]
        text += [f"*SOLID SECTION, ELSET={_cased(key, rng)}, MATERIAL=M{key}"]
    if rng.random() < 0.3:
        text += ["*ELEMENT, TYPE=MASS, ELSET=HEAVY", f"9000, {labels[0]}", "*MASS, ELSET=HEAVY", "3."]
        deck.point_mass = 3.0
    if rng.random() < 0.3:
        text += [f"*TRANSFORM, NSET={_cased(deck.sets[0], rng)}, TYPE=R", "1., 1., 0., -1., 1., 0."]
    deck.files["a.inp"] = "\n".join(["*HEADING", f"drawn by {seed}", *_disturbed(text, rng)]) + "\n"
    return deck


def _mesh(count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return points and cells of a box; mid-side nodes are means of corners."""
    corners = {20: 8, 15: 6, 10: 4}.get(count, count)
    shape = rng.integers((2, 1, 1), (5, 4, 4))
    grid = np.indices(shape + 1).reshape(3, -1).T
    points = (grid + rng.uniform(-0.1, 0.1, grid.shape)) * rng.uniform(0.1, 2.0, 3)
    points[(grid == 0) & (rng.random(points.shape) < 0.3)] = 0.0
    strides = np.array((shape[1:].prod() + shape[1] + shape[2] + 1, shape[2] + 1, 1))
    brick = np.array(((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))) @ strides
    starts = np.indices(shape).reshape(3, -1).T @ strides
    cells = np.array([start + brick[list(part)] for start in starts for part in PARTS[corners]])
    if count == corners:
        return points, cells
    ends = np.sort(cells[:, np.array(EDGES[corners])].reshape(-1, 2), axis=1)
    edges, where = np.unique(ends, axis=0, return_inverse=True)
    mids = len(points) + where.reshape(len(cells), -1)
    return np.vstack((points, points[edges].mean(axis=1))), np.hstack((cells, mids))


def _nodes(points: np.ndarray, labels: np.ndarray, rng: np.random.Generator, deck: Deck) -> tuple[list[str], list[int]]:
    """Return lines of nodes: in several blocks, some twice, some in other files; and the labels of reference nodes."""
    order = rng.permutation(len(labels))
    text: list[str] = []
    for number, rows in enumerate(np.array_split(order, int(rng.integers(1, 4)))):
        some = [f"*{_cased('NODE', rng)}" + (f", NSET={_cased('BLOCK', rng)}" if rng.random() < 0.5 else "")]
        if "NSET" in some[0] and "BLOCK" not in deck.sets:
            deck.sets.append("BLOCK")
        for row in rows:
            if rng.random() < 0.05:
                some.append(f"{labels[row]}, 5., 5., 5.")  # what holds comes later
            some.append(_node(int(labels[row]), points[row], rng))
        if rng.random() < 0.3:
            inner, outer = f"inner{number}.inc", f"sub{number}/outer.inc"
            cut = int(rng.integers(0, 2)) * int(rng.integers(1, len(some)))  # data alone may be in a file
            deck.files[inner] = "\n".join(some[cut:]) + "\n"
            deck.files[outer] = f"*INCLUDE, INPUT={inner}\n"  # in the folder of the deck
            some = [*some[:cut], f"*INCLUDE, INPUT={outer}"]
        text += some
    reference = [int(labels.max()) + 5] if rng.random() < 0.5 else []
    return text + [line for label in reference for line in ("*NODE", f"{label}, 9., 9.")], reference


def _node(label: int, point: np.ndarray, rng: np.random.Generator) -> str:
    """Return a line of a node, its numbers of ten digits in any form, zeros at the end left out."""
    fields = []
    for x in point:
        form = str(rng.choice(("g", "e", "D", "no letter", "blank")))
        if x == 0.0 and form == "blank":
            fields.append("")
        elif form in ("D", "no letter"):
            fields.append(f"{x:.10e}".replace("e", "D" if form == "D" else ""))
        else:
            fields.append(f"{x:.10e}" if form == "e" else f"{x:.10g}")
    blank = " " * int(rng.integers(0, 3))
    line = f",{blank}".join([f"{blank}{label}", *fields])
    return line.rstrip(", ") if rng.random() < 0.5 else line


def _wrapped(row: list[int], rng: np.random.Generator) -> list[str]:
    """Return an element on one or several lines, with or without commas at their ends."""
    lines, rest = [], list(row)
    while rest:
        width = int(rng.integers(2, MOST)) if rng.random() < 0.3 or len(rest) > MOST - 1 else len(rest)
        lines.append(", ".join(map(str, rest[:width])) + ("," if rest[width:] and rng.random() < 0.5 else ""))
        rest = rest[width:]
    return lines


def _sets(labels: np.ndarray, reference: list[int], deck: Deck, rng: np.random.Generator) -> list[str]:
    """Return lines of sets: of labels, of ranges, of sets, in several keywords."""
    known, text = set(labels.tolist()), []
    for number in range(int(rng.integers(1, 4))):
        name = f"Set{number}"
        for _ in range(int(rng.integers(1, 3))):
            some = rng.choice(labels, int(rng.integers(1, 6))).tolist() + reference
            line = ", ".join(map(str, some)) + ("," if rng.random() < 0.3 else "")
            text += [f"*{_cased('NSET', rng)}, NSET={_cased(name, rng)}", line]
        deck.sets.append(name)
    runs = [label for label in sorted(known) if label + 1 in known]
    if runs:
        first = int(rng.choice(runs))
        text += ["*NSET, NSET=Range, GENERATE", f"{first}, {first + 1}" + (", 1" if rng.random() < 0.5 else "")]
        deck.sets.append("Range")
    text += ["*NSET, NSET=Of Sets", f"{_cased(deck.sets[0], rng)}, {_cased(deck.sets[-1], rng)}"]
    deck.sets.append("Of Sets")
    return text


def _cased(word: str, rng: np.random.Generator) -> str:
    return str(rng.choice((word, word.lower(), word.upper(), word.title())))


def _disturbed(lines: list[str], rng: np.random.Generator) -> list[str]:
    """Return the lines with comments, blank lines and blanks among them; not in the first, behind *HEADING.

    CalculiX 2.20 takes a keyword with blanks before it as a line of the heading.
    """
    found = lines[:1]
    for line in lines[1:]:
        if rng.random() < 0.03:
            found.append(str(rng.choice(("** a comment, 1, 2", "", "   "))))
        found.append(("  " if rng.random() < 0.05 else "") + line)
    return found


@dataclass
class Answer:
    """What CalculiX says: points of nodes of elements by label, labels of each set, and the mass of all cells, kg."""

    points: dict[int, np.ndarray]
    sets: dict[str, set[int]]
    mass: float


def answer_of(deck: Deck, folder: Path) -> Answer:
    """Run a deck, which is written to a folder, and return what CalculiX read of it.

    Points come from binary results in double precision, sets from printed displacements, the mass from the stored
    matrix.
    """
    for name, text in deck.files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="latin-1")
    held = "".join(f"{label}, 1, 3\n" for label in deck.held)
    prints = "".join(f"*NODE PRINT, NSET={name}\nU\n" for name in deck.sets)
    _run(folder, f"*STEP\n*STATIC\n*BOUNDARY\n{held}*NODE OUTPUT\nU\n{prints}*END STEP\n")
    points, sets = _points(folder / "run.frd"), _printed(folder / "run.dat")
    _run(folder, "*STEP\n*FREQUENCY, SOLVER=MATRIXSTORAGE\n*END STEP\n")
    rows = [line.split() for line in (folder / "run.mas").read_text(encoding="ascii").splitlines()]
    names = (folder / "run.dof").read_text(encoding="ascii").split()
    own = {f"{label}.1" for label in points}  # others are of incompatible modes, which no motion of the body moves
    is_x = [name in own for name in names]
    mass = sum(
        float(value) * (1 if i == j else 2)
        for i, j, value in ((int(a) - 1, int(b) - 1, value) for a, b, value in rows)
        if is_x[i] and is_x[j]
    )
    return Answer(points, {key: sets["".join(key.split()).upper()] for key in deck.sets}, mass - deck.point_mass)


def _run(folder: Path, step: str) -> None:
    (folder / "run.inp").write_text((folder / "a.inp").read_text(encoding="latin-1") + step, encoding="latin-1")
    done = subprocess.run(
        ["ccx", "run"], cwd=folder, capture_output=True, text=True, timeout=120, stdin=subprocess.DEVNULL, check=False
    )
    if done.returncode or "*ERROR" in done.stdout:
        raise RuntimeError(f"CalculiX stopped: {done.stdout[-1500:]}")


def _points(path: Path) -> dict[int, np.ndarray]:
    """Return the points of a binary file .frd: label and three numbers of double precision each."""
    content = path.read_bytes()
    head = re.search(rb"^    2C +(\d+) +3 *\n", content, re.MULTILINE)
    if head is None:
        raise RuntimeError(f"{path} has no nodes in double precision")
    rows = np.frombuffer(content, np.dtype([("label", "<i4"), ("at", "<f8", 3)]), int(head[1]), head.end())
    return {int(row["label"]): np.array(row["at"]) for row in rows}


def _printed(path: Path) -> dict[str, set[int]]:
    """Return the nodes of each set whose displacements are printed."""
    found: dict[str, set[int]] = {}
    name = ""
    for line in path.read_text(encoding="ascii").splitlines():
        head = re.search(r"for set (\S+)", line)
        if head is not None:
            name = head[1]
            found[name] = set()
        elif line.strip():
            found[name].add(int(line.split()[0]))
    return found
