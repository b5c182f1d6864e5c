"""Nodes of an input file of Abaqus: written, generated along lines, copied, and in local systems."""

from __future__ import annotations

import numpy as np

from kanefe.frames import axis_rotation
from kanefe.imports.abaqus_input import Keyword
from kanefe.imports.coordinate_systems import BASIC, CoordinateSystem, in_basic, right_handed
from kanefe.imports.node_table import rows_of

MOST_FIELDS = 7
"""Number of fields of a node: label, coordinates, and a normal, which is left out."""


class NodeBlocks:
    """The nodes of a part, in the order in which its keywords give them: of one that is given twice the last holds.

    Attributes
    ----------
    system : CoordinateSystem
        In which nodes are given now.
    """

    def __init__(self) -> None:
        self.system = BASIC
        self._labels = [np.zeros(0, dtype=np.int64)]
        self._points = [np.zeros((0, 3))]
        self._blocks: list[Keyword] = []

    def read(self, block: Keyword) -> np.ndarray:
        """Add the nodes of a block, and return their labels."""
        kind = block.options.get("SYSTEM", "R").strip().upper()
        if kind not in ("R", "C"):
            raise block.refused(f"is in the system {kind!r}, which is not read. Remedy: SYSTEM=R or C")
        rows = _rows(block)
        local = in_basic(CoordinateSystem(kind, np.zeros(3), np.eye(3)), rows[:, 1:])
        return self._add(rows[:, 0].astype(np.int64), in_basic(self.system, local), block)

    def place_system(self, block: Keyword) -> None:
        """Take the system in which nodes are given from now on."""
        self.system = _system(block)

    def generate(self, block: Keyword) -> np.ndarray:
        """Add nodes on straight lines between two each, and return their labels, with those of the ends."""
        if "LINE" in block.options:
            raise block.refused("is of a curved line, which is not read. Remedy: write its nodes out")
        made: list[np.ndarray] = []
        for at, fields in block.rows():
            first, last = (block.label(text, at) for text in (*fields, "", "")[:2])
            step = block.label(fields[2], at) if len(fields) > 2 and fields[2] else 1
            count, rest = divmod(abs(last - first), step)
            if rest or not count:
                raise block.refused(f"has no nodes from {first} to {last} in steps of {step}. Remedy: its numbers", at)
            ends = self._of(np.array([first, last]), block, at)
            share = np.linspace(0.0, 1.0, count + 1)[:, None]
            labels = np.linspace(first, last, count + 1).round().astype(np.int64)
            self._add(labels[1:-1], (ends[0] + share * (ends[1] - ends[0]))[1:-1], block)
            made.append(labels)
        return np.concatenate(made) if made else np.zeros(0, dtype=np.int64)

    def copy(self, block: Keyword, old: np.ndarray) -> np.ndarray:
        """Add copies of nodes, moved and then turned, and return their labels."""
        if "SHIFT" not in block.options:
            raise block.refused("copies otherwise than by SHIFT, which is not read. Remedy: write its nodes out")
        change = block.label(block.option("CHANGE NUMBER"), block.at)
        times = block.label(block.options.get("MULTIPLE", "1"), block.at)
        points = moved(self._of(old, block, block.at), block, times)
        return self._add(old + change, points, block)

    def table(self) -> tuple[np.ndarray, np.ndarray, list[str]]:
        """Return labels (n,) in their order, points (n, 3), and what is to be told of nodes that are given twice."""
        every, points = np.concatenate(self._labels), np.concatenate(self._points)
        labels, first, where = np.unique(every, return_index=True, return_inverse=True)
        if len(labels) == len(every):
            return every, points, []
        last = len(every) - 1 - np.unique(every[::-1], return_index=True)[1]
        order = np.argsort(first, kind="stable")
        is_elsewhere = (points != points[last][where]).any(axis=1)
        told = []
        if is_elsewhere.any():
            twice = np.unique(every[is_elsewhere])
            more = f" and {len(twice) - 1} more are" if len(twice) > 1 else " is"
            row = last[np.searchsorted(labels, twice[0])]
            ends = np.cumsum([len(some) for some in self._labels[1:]])
            at = line_of(int(twice[0]), self._blocks[int(np.searchsorted(ends, row, side="right"))])
            told.append(f"node {twice[0]}{more} given twice, at different places: the last holds (line {at})")
        return labels[order], points[last[order]], told

    def _add(self, labels: np.ndarray, points: np.ndarray, block: Keyword) -> np.ndarray:
        self._labels.append(labels)
        self._points.append(points)
        self._blocks.append(block)
        return labels

    def _of(self, labels: np.ndarray, block: Keyword, at: int) -> np.ndarray:
        """Return the points of nodes that were given before."""
        known, points = np.concatenate(self._labels), np.concatenate(self._points)
        rows = len(known) - 1 - rows_of(labels, known[::-1])  # the last of each
        if (rows == len(known)).any():
            missing = labels[rows == len(known)][0]
            raise block.refused(f"is of node {missing}, which is not there before. Remedy: its order", at)
        return np.asarray(points[rows])


def refuse_elsewhere(block: Keyword) -> None:
    """Refuse a block whose data are in another file."""
    if "INPUT" in block.options:
        raise block.refused(
            f"has its data in the file {block.options['INPUT']}, which is not read. Remedy: write them to the deck, or "
            "*INCLUDE it"
        )


def line_of(label: int, block: Keyword) -> int:
    """Return the number of the last line of a block that begins with a label, else that of the block."""
    found = [at for at, fields in block.rows() if fields[0].lstrip("+0").partition(".")[0] == str(label)]
    return found[-1] if found else block.at


def moved(points: np.ndarray, block: Keyword, times: int = 1) -> np.ndarray:
    """Return points that the data of a block translate and then turn: a vector; two points of an axis, and an angle.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    block : Keyword
    times : int
        How often they are turned.
    """
    rows = list(block.rows())
    if len(rows) > 2 or (rows and len(rows[0][1]) > 3) or (len(rows) > 1 and len(rows[1][1]) != 7):
        at = rows[-1][0]
        raise block.refused("has other data than a translation, and an axis with an angle. Remedy: two lines", at)
    numbers = [np.array([block.number(text, at) for text in fields]) for at, fields in rows]
    shifted = points + np.pad(numbers[0], (0, 3 - len(numbers[0]))) if numbers else points
    if len(numbers) < 2:
        return shifted
    start, along, angle = numbers[1][:3], numbers[1][3:6] - numbers[1][:3], numbers[1][6]
    if not np.linalg.norm(along) > 0.0:
        raise block.refused("has an axis of two equal points. Remedy: two points that differ", rows[1][0])
    R = axis_rotation(along / np.linalg.norm(along), np.radians(angle * times))
    return np.asarray(start + (shifted - start) @ R.T)


def _rows(block: Keyword) -> np.ndarray:
    """Return rows of label, x, y, z of a block; coordinates that are left out are zero."""
    table = block.table()
    if table is not None and (table.counts == 4).all():
        rows = table.values.reshape(-1, 4)
        if (rows[:, 0] == np.floor(rows[:, 0])).all() and (rows[:, 0] > 0).all():
            return rows
    rows = np.zeros((len(block.numbered), 4))
    for i, (at, fields) in enumerate(block.rows()):
        if len(fields) > MOST_FIELDS:
            raise block.refused(
                f"has {len(fields)} fields, where a node has {MOST_FIELDS} at most. Remedy: check it", at
            )
        rows[i, 0] = block.label(fields[0], at)
        values = [block.number(text, at) for text in fields[1:]]
        rows[i, 1 : 1 + len(values[:3])] = values[:3]
    return rows


def _system(block: Keyword) -> CoordinateSystem:
    """Return the system of an origin, a point on its first axis, and one in the plane of the first two."""
    values = [np.array([block.number(text, at) for text in fields]) for at, fields in block.rows()]
    if not values:
        return BASIC
    counts = [len(row) for row in values]
    if counts[0] > 6 or len(values) > 2 or (len(values) == 2 and (counts[0] < 4 or counts[1] > 3)):
        raise block.refused("has other data than three points. Remedy: six numbers, and three in the next line")
    first = np.pad(values[0], (0, 6 - counts[0]))
    origin, along = first[:3], first[3:] - first[:3]
    if counts[0] < 4:
        return CoordinateSystem("R", origin, np.eye(3))
    if len(values) == 2:
        axes = right_handed(along, np.pad(values[1], (0, 3 - counts[1])) - origin)
    else:
        flat = along * (1.0, 1.0, 0.0)
        axes = right_handed(flat, np.array((-flat[1], flat[0], 0.0)))
    if axes is None:
        raise block.refused("has three points on one line. Remedy: a third point beside its axis")
    return CoordinateSystem("R", origin, axes)
