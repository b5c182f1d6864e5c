"""Universal files of I-DEAS (.unv), which Salome and others write too: nodes, elements and groups as a mesh.

Data sets stand between lines of -1, first their number. Read are 2411 (nodes), 2412 (elements), 2435, 2452, 2467 and
2477 (groups), 164 (units: lengths are divided by its factor) and 2420 (coordinate systems). Nodes of elements of second
order alternate along edges: corner, middle, corner, ...; those of upright edges are between those of bottom and top.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from kanefe.errors import FileError, outside
from kanefe.fe_model.shapes import node_count
from kanefe.imports.node_table import Labels
from kanefe.imports.text import number, read_text
from kanefe_fem.mesh.checks import MeshWarning
from kanefe_fem.mesh.grouped import Group, grouped_mesh
from kanefe_fem.mesh.mesh import Mesh

KINDS = {
    **dict.fromkeys((11, 21, 23), "line"),
    **dict.fromkeys((22, 24), "line3"),
    **dict.fromkeys((41, 51, 61, 74, 81, 91), "triangle"),
    **dict.fromkeys((42, 52, 62, 72, 82, 92), "triangle6"),
    **dict.fromkeys((44, 54, 64, 71, 84, 94), "quad"),
    **dict.fromkeys((45, 55, 65, 75, 85, 95), "quad8"),
    111: "tetra",
    112: "wedge",
    113: "wedge15",
    115: "hexahedron",
    116: "hexahedron20",
    118: "tetra10",
}
"""Cells of the descriptors of finite elements that are read."""

_BEAMS = (11, 21, 22, 23, 24)
"""Numbers of the descriptors of elements with a line of their orientation before that of their nodes."""

_ORDERS = {
    "line3": (0, 2, 1),
    "triangle6": (0, 2, 4, 1, 3, 5),
    "quad8": (0, 2, 4, 6, 1, 3, 5, 7),
    "tetra10": (0, 2, 4, 9, 1, 3, 5, 6, 7, 8),
    "wedge15": (0, 2, 4, 9, 11, 13, 1, 3, 5, 10, 12, 14, 6, 7, 8),
    "hexahedron20": (0, 2, 4, 6, 12, 14, 16, 18, 1, 3, 5, 7, 13, 15, 17, 19, 8, 9, 10, 11),
}
"""Place of each node of a cell among those of the file."""

_GROUPS = (2435, 2452, 2467, 2477)
"""Data sets of groups: a line of eight numbers, the last that of members; a name; two members a line of four each."""

_NOT_READ = {15: "nodes", 781: "nodes", 71: "elements", 780: "elements", 2417: "groups", 2429: "groups", 2430: "groups"}
_NOT_READ |= {2432: "groups", 752: "groups"}
"""Older data sets of a mesh."""

_NODE, _ELEMENT = 7, 8
"""Numbers of the kinds of members of groups."""


@dataclass
class _Found:
    """What a file has."""

    points: dict[int, list[float]] = field(default_factory=dict)
    systems: dict[int, int] = field(default_factory=dict)  # of nodes, the line where the first is
    cells: dict[str, list[list[int]]] = field(default_factory=dict)
    elements: dict[str, list[int]] = field(default_factory=dict)
    lines: dict[str, list[int]] = field(default_factory=dict)
    groups: list[tuple[str, list[int], list[int]]] = field(default_factory=list)
    others: int = 0  # members of groups of other kinds
    turned: set[int] = field(default_factory=set)
    factor: float = 1.0


class _Lines:
    """Lines of a file, with the number of the last one."""

    def __init__(self, path: Path) -> None:
        self.path, self.at = path, 0
        self._lines = read_text(path, "universal file").splitlines()

    def datasets(self) -> Iterator[int]:
        """Yield the number of each data set, whose lines `next` then gives; what is left of it is passed over."""
        while self.at < len(self._lines):
            if self.next().strip() != "-1":
                continue
            head = self.next().split()
            if not head or not head[0].rstrip("b").isdigit():
                raise self.refused("where the number of a data set should be")
            yield int(head[0].rstrip("b"))
            while not self.is_end():
                self.next()
            self.at += 1

    def is_end(self) -> bool:
        """Return whether the next line that is not blank ends the data set; a FileError if the file ends before."""
        while self.at < len(self._lines) and not self._lines[self.at].strip():
            self.at += 1  # behind groups without members
        if self.at >= len(self._lines):
            raise FileError(f"{self.path.name} ends within a data set (line {self.at}). Remedy: export it again")
        return self._lines[self.at].strip() == "-1"

    def next(self) -> str:
        """Return the next line."""
        if self.at >= len(self._lines):
            raise FileError(f"{self.path.name} ends within a data set (line {self.at}). Remedy: export it again")
        self.at += 1
        return self._lines[self.at - 1]

    def wholes(self, least: int) -> list[int]:
        """Return the whole numbers of the next line."""
        try:
            found = [int(text) for text in self.next().split()]
        except ValueError:
            raise self.refused("where whole numbers should be") from None
        if len(found) < least:
            raise self.refused(f"where {least} numbers should be")
        return found

    def numbers(self) -> list[float]:
        """Return the three numbers of the next line."""
        try:
            found = [number(text) for text in self.next().split()]
        except ValueError:
            raise self.refused("where numbers should be") from None
        if len(found) != 3:
            raise self.refused("where three numbers should be")
        return found

    def refused(self, reason: str) -> FileError:
        """Return the error of the last line."""
        text = self._lines[self.at - 1].strip()[:40]
        return FileError(f"{self.path.name} has {text!r} (line {self.at}) {reason}. Remedy: export it again")


def read_universal_mesh(path: Path) -> Mesh:
    """Return the mesh of a universal file, in m by the units that it states.

    Raises
    ------
    FileError
        If something is not as it should be, or of a kind that is not read; the message has the line.
    MeshError
        If it has no cells.

    Warns
    -----
    MeshWarning
        If lengths are not in m, or members of groups are neither nodes nor elements of the file.
    """
    lines, found = _Lines(path), _Found()
    for dataset in lines.datasets():
        if dataset in _NOT_READ:
            raise lines.refused(f"which are {_NOT_READ[dataset]} of an old kind, not read: write 2411, 2412 and 2467")
        if dataset == 164:
            lines.next()
            found.factor = lines.numbers()[0]
        elif dataset == 2420:
            _read_systems(lines, found)
        elif dataset == 2411:
            _read_nodes(lines, found)
        elif dataset == 2412:
            _read_elements(lines, found)
        elif dataset in _GROUPS:
            _read_groups(lines, found)
    _check_systems(path, found)
    return _mesh(path, found)


def _read_systems(lines: _Lines, found: _Found) -> None:
    """Add the coordinate systems that are not those of the mesh."""
    lines.next()
    lines.next()
    while not lines.is_end():
        label, kind = lines.wholes(2)[:2]
        lines.next()
        rows = np.array([lines.numbers() for _ in range(4)])
        if kind != 0 or (rows != np.eye(4, 3)).any():
            found.turned.add(label)


def _read_nodes(lines: _Lines, found: _Found) -> None:
    while not lines.is_end():
        label, system = lines.wholes(4)[:2]
        if label in found.points:
            raise lines.refused("which is a node again")
        found.systems.setdefault(system, lines.at)
        found.points[label] = lines.numbers()


def _read_elements(lines: _Lines, found: _Found) -> None:
    while not lines.is_end():
        label, descriptor, _, _, _, count = lines.wholes(6)[:6]
        at = lines.at
        kind = KINDS.get(descriptor)
        if kind is None or count != node_count(kind):
            raise lines.refused(f"an element of kind {descriptor} with {count} nodes, which is not read")
        if descriptor in _BEAMS:
            lines.next()
        nodes: list[int] = []
        while len(nodes) < count:
            if lines.is_end():
                raise lines.refused(f"and element {label} ends with {len(nodes)} nodes of {count}")
            nodes += lines.wholes(1)
        if len(nodes) > count:
            raise lines.refused(f"with {len(nodes)} nodes of element {label}, which says that it has {count}")
        found.cells.setdefault(kind, []).append([nodes[i] for i in _ORDERS.get(kind, range(count))])
        found.elements.setdefault(kind, []).append(label)
        found.lines.setdefault(kind, []).append(at)


def _read_groups(lines: _Lines, found: _Found) -> None:
    while not lines.is_end():
        count = lines.wholes(8)[7]
        name = lines.next().strip()
        members: list[int] = []
        while len(members) < 4 * count:
            if lines.is_end():
                raise lines.refused(f"and group {name!r} ends with {len(members) // 4} members of {count}")
            members += lines.wholes(4)
        if len(members) > 4 * count:
            raise lines.refused(f"with more members of group {name!r} than {count}")
        pairs = list(zip(members[::4], members[1::4], strict=True))
        nodes, elements = ([n for kind, n in pairs if kind == own] for own in (_NODE, _ELEMENT))
        found.others += count - len(nodes) - len(elements)
        found.groups.append((name, nodes, elements))


def _check_systems(path: Path, found: _Found) -> None:
    for system, at in found.systems.items():
        if system in found.turned:
            raise FileError(
                f"{path.name} has nodes in the coordinate system {system} (line {at}), which is not that of the mesh "
                "and not read. Remedy: export it in global Cartesian coordinates"
            )


def _mesh(path: Path, found: _Found) -> Mesh:
    table = Labels(np.array(list(found.points), dtype=np.int64))
    blocks = []
    for kind, rows in found.cells.items():
        ids = table.rows(np.array(rows, dtype=np.int64))
        if (ids < 0).any():
            row, column = np.argwhere(ids < 0)[0]
            raise FileError(
                f"{path.name} has no node {rows[row][column]}, which element {found.elements[kind][row]} has (line "
                f"{found.lines[kind][row]}). Remedy: export it again"
            )
        blocks.append((kind, ids))
    points: dict[str, np.ndarray] = {}
    groups: list[Group] = []
    lost = found.others
    for name, nodes, elements in found.groups:
        rows_of_nodes = table.rows(np.array(nodes, dtype=np.int64))
        if (rows_of_nodes >= 0).any():
            points[name] = np.unique(rows_of_nodes[rows_of_nodes >= 0])
        own = [np.flatnonzero(np.isin(found.elements[kind], elements)) for kind, _ in blocks]
        groups.append((name, own))
        lost += int((rows_of_nodes < 0).sum()) + len(elements) - sum(len(rows) for rows in own)
    empty = [name for name, nodes, elements in found.groups if not nodes and not elements]
    told = [f"groups without members: {', '.join(empty)}"] if empty else []
    told += [f"{lost} members of groups are neither nodes nor elements of the file"] if lost else []
    if found.factor != 1.0:
        told.append(f"its lengths are in units of 1/{found.factor:g} m (data set 164), and converted")
    if told:
        warnings.warn(f"{path.name}: {'; '.join(told)}", MeshWarning, stacklevel=outside())
    places = np.array(list(found.points.values())).reshape(-1, 3) / found.factor
    return grouped_mesh(path, places, blocks, groups, points, reader="kanefe, universal file")
