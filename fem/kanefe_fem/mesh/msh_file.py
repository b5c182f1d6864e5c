"""Check that a .msh file is complete, because gmsh may crash on a damaged one.

gmsh trusts the counts of blocks, nodes and elements in a file of format 4.1, and uses the numbers of nodes and elements
as memory indices without a check. In a file of format 2.2 it trusts the numbers of the nodes.
"""

from __future__ import annotations

import mmap
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from kanefe.errors import FileError

REMEDY = "Remedy: write the file again (gmsh: File > Save Mesh, format 2.2 or 4.1)"

NODES_OF = dict(zip(range(1, 20), (2, 3, 4, 4, 8, 6, 5, 3, 6, 9, 10, 27, 18, 14, 1, 8, 20, 15, 13), strict=True))
"""Number of nodes of the supported elements, by gmsh's type. Others are refused after gmsh has read them."""


class Head(NamedTuple):
    """Values in the first line of a section of format 4.1."""

    blocks: int
    size: int
    least: int
    most: int


class Numbers(Protocol):
    """Sequential reader of the integers of a section; raises a ValueError if they are missing."""

    def numbers(self, signed: int, unsigned: int) -> list[int]:
        """Return the integers of one line."""
        ...

    def table(self, rows: int, columns: int) -> np.ndarray:
        """Return the unsigned integers of several lines."""
        ...

    def skip(self, rows: int, columns: int) -> None:
        """Skip lines of floating-point numbers."""
        ...


class _Text:
    """A section in text."""

    def __init__(self, content: bytes) -> None:
        self._lines, self._at = content.strip().split(b"\n"), 0

    def _next(self, rows: int) -> list[bytes]:
        self._at += rows
        if rows < 0 or self._at > len(self._lines):
            raise ValueError
        return self._lines[self._at - rows : self._at]

    def numbers(self, signed: int, unsigned: int) -> list[int]:
        found = [int(word) for word in self._next(1)[0].split()]
        if len(found) != signed + unsigned:
            raise ValueError
        return found

    def table(self, rows: int, columns: int) -> np.ndarray:
        words = b" ".join(self._next(rows)).split()
        return np.array(words, dtype=np.int64).reshape(rows, columns)

    def skip(self, rows: int, columns: int) -> None:
        self._next(rows)


class _Binary:
    """A section in binary."""

    def __init__(self, content: bytes, order: str) -> None:
        self._content, self._order, self._at = content, order, 0

    def _next(self, kind: str, count: int) -> np.ndarray:
        found = np.frombuffer(self._content, f"{self._order}{kind}", count, self._at) if count else np.zeros(0)
        self._at += found.nbytes
        return found

    def numbers(self, signed: int, unsigned: int) -> list[int]:
        return [*self._next("i4", signed).tolist(), *self._next("i8", unsigned).tolist()]

    def table(self, rows: int, columns: int) -> np.ndarray:
        return self._next("i8", rows * columns).reshape(rows, columns)

    def skip(self, rows: int, columns: int) -> None:
        self._next("f8", rows * columns)


def check_complete(path: Path) -> None:
    """Refuse a .msh file that is truncated or damaged: gmsh may crash on it, or read a part of it without a message.

    Raises
    ------
    FileError
        If the file is truncated or damaged; the message names the fault.
    """
    if path.stat().st_size == 0:
        raise FileError(f"{path.name} is empty. {REMEDY}")
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        version = msh_version(path)
        if not version:
            raise FileError(f"{path.name} is not a gmsh mesh: it does not begin with $MeshFormat. {REMEDY}")
        if version not in ("2", "2.0", "2.1", "2.2", "4.1"):
            raise FileError(f"{path.name} has the mesh format {version}; 2.2 and 4.1 are supported. {REMEDY}")
        contents, position = [], 0
        nodes_as = b"ParametricNodes" if data.find(b"$ParametricNodes") >= 0 else b"Nodes"  # of Mesh.SaveParametric
        for section in (b"MeshFormat", nodes_as, b"Elements"):
            position = data.find(b"$" + section, position)
            end = data.find(b"$End" + section, max(position, 0))
            if position < 0 or end < 0:
                raise FileError(f"{path.name} is truncated: its section ${section.decode()} has no end. {REMEDY}")
            contents.append(slice(data.find(b"\n", position) + 1, end))
            position = end
        tail = data[max(0, len(data) - 200) :]
        if re.search(rb"\$End\w+\s*\Z", tail) is None:
            raise FileError(f"{path.name} is truncated: it ends inside a section. {REMEDY}")
        _check_names(path, data)
        order = _byte_order(data[:200])
        if version != "4.1" and order and nodes_as != b"Nodes":
            raise FileError(f"{path.name} has parametric nodes in binary. {REMEDY}, without Mesh.SaveParametric")
        if version != "4.1":
            _check_references(path, data[contents[1]], data[contents[2]], order)
        else:
            nodes, elements = (_Binary(data[at], order) if order else _Text(data[at]) for at in contents[1:])
            _check_numbers(path, nodes, elements)


def _byte_order(head: bytes) -> str:
    """Return the order of bytes of a binary file by its beginning, "" of a text."""
    one = re.match(rb"\$MeshFormat\s+[0-9.]+\s+1[^\n]*\n(.{4})", head, re.DOTALL)
    return "" if one is None else "<" if one[1] == b"\1\0\0\0" else ">"


def msh_version(path: Path) -> str:
    """Return the version in the head of a .msh file, "" if it has none."""
    with path.open("rb") as stream:
        # gmsh runs a file that does not begin with exactly these letters as a script
        head = re.match(rb"\$MeshFormat\s+([0-9.]+)\s+[01]\s", stream.read(200))
    return head.group(1).decode() if head else ""


def stated_counts(path: Path) -> tuple[int, int]:
    """Return the numbers of nodes and elements that a complete file states."""
    content = path.read_bytes()
    is_parametric = content.find(b"$ParametricNodes") >= 0
    is_4, order, found = msh_version(path) == "4.1", _byte_order(content[:200]), []
    for name in (b"$ParametricNodes" if is_parametric else b"$Nodes", b"$Elements"):
        section = content[content.find(name) :].partition(b"\n")[2]
        if is_4 and order:
            found.append(Head(*_Binary(section[:32], order).numbers(0, 4)).size)
        else:
            found.append(int(section.split(None, 4)[1 if is_4 else 0]))
    return found[0], found[1]


_IN_A_PART = re.compile(rb"^[ \t]*\d+[ \t]+\d+[ \t]+0*(?:[3-9]|[1-9]\d+)(?:[ \t]+\S+){2}[ \t]+(?!0\s)\S", re.MULTILINE)
"""A row of an element of format 2 with a third tag that is not 0."""


def has_parts(path: Path) -> bool:
    """Return whether elements of a complete file of format 2 are in parts of a partitioned mesh: their third tag."""
    content = path.read_bytes()
    head, _, rows = content[content.find(b"$Elements") :].partition(b"\n")[2].partition(b"\n")
    order, at, count = _byte_order(content[:200]), 0, int(head)
    if not order:
        return _IN_A_PART.search(rows.partition(b"$EndElements")[0]) is not None
    while count > 0:
        kind, size, tags = np.frombuffer(rows, f"{order}i4", 3, at).tolist()
        if tags > 2:
            return True
        at += 12 + 4 * size * (1 + tags + NODES_OF.get(kind, 0))
        count -= size if kind in NODES_OF else count
    return False


def named_groups(path: Path) -> dict[tuple[int, int], str]:
    """Return the names, by dimension and number, of groups that a .msh file lists, also of those without elements."""
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        rows = [re.match(r'\s*([0-3])\s+(-?\d+)\s+"(.*)"\s*$', row.decode("utf-8", "replace")) for row in _names(data)]
    return {(int(row[1]), int(row[2])): row[3] for row in rows if row}


def _names(data: mmap.mmap) -> list[bytes]:
    """Return the lines of dimension, number and name of each group."""
    start = data.find(b"$PhysicalNames")
    return data[start : data.find(b"$EndPhysicalNames", start)].split(b"\n")[2:] if start >= 0 else []


def _check_names(path: Path, data: mmap.mmap) -> None:
    for line in _names(data):
        if line.strip() and re.match(rb'\s*[0-3]\s+-?\d{1,10}\s+"', line) is None:
            raise FileError(
                f"{path.name}: a line of $PhysicalNames is not of dimension, number and name: {line[:80]!r}. {REMEDY}"
            )


def _check_references(path: Path, nodes: bytes, elements: bytes, order: str) -> None:
    """Check a file of format 2: numbers of nodes must be positive and different, and those in elements must exist."""
    what = "nodes"
    try:
        head, _, rows = nodes.partition(b"\n")
        count = int(head)
        if order:
            record = np.dtype([("number", f"{order}i4"), ("at", f"{order}f8", 3)])
            numbers = np.frombuffer(rows, record, count)["number"]
        else:
            numbers = np.array([row.split(None, 1)[0] for row in rows.split(b"\n", count)[:count]], dtype=np.int64)
        known = np.unique(numbers)
        _demand(len(known) == count and (not count or known[0] > 0))
        what = "elements"
        head, _, rows = elements.partition(b"\n")
        for named in _named_in_binary(rows, int(head), order) if order else _named_in_text(rows, int(head)):
            _demand(bool(np.isin(named, known).all()))
    except (ValueError, OverflowError, IndexError) as problem:
        raise _damaged(path, what) from problem


def _named_in_binary(rows: bytes, count: int, order: str) -> Iterator[np.ndarray]:
    """Yield the numbers of the nodes of the blocks of elements, up to the first unknown type."""
    at = 0
    while count > 0:
        kind, size, tags = np.frombuffer(rows, f"{order}i4", 3, at).tolist()
        if kind not in NODES_OF:
            return
        _demand(size > 0 and tags >= 0)
        columns = 1 + tags + NODES_OF[kind]
        yield np.frombuffer(rows, f"{order}i4", size * columns, at + 12).reshape(size, columns)[:, 1 + tags :]
        at += 12 + 4 * size * columns
        count -= size


def _named_in_text(rows: bytes, count: int) -> Iterator[np.ndarray]:
    """Yield the numbers of the nodes of the rows of elements."""
    named = []
    for row in rows.split(b"\n", count)[:count]:
        words = row.split()
        named += words[3 + int(words[2]) :]
    yield np.array(named, dtype=np.int64)


def _check_numbers(path: Path, nodes: Numbers, elements: Numbers) -> None:
    """Compare the counts at the heads of sections and blocks with their content."""
    what = "nodes"
    try:
        head = Head(*nodes.numbers(0, 4))
        counted = 0
        for dimension, parametric, count in _blocks(nodes, head):
            _demand(0 <= dimension <= 3 and parametric in (0, 1))
            tags = nodes.table(count, 1)
            _demand(not count or head.least <= tags.min() <= tags.max() <= head.most)
            nodes.skip(count, 3 + (dimension if parametric else 0))
            counted += count
        _demand(counted == head.size)
        what = "elements"
        of_elements, counted = Head(*elements.numbers(0, 4)), 0
        for dimension, kind, count in _blocks(elements, of_elements):
            if kind not in NODES_OF:
                return
            rows = elements.table(count, 1 + NODES_OF[kind])
            _demand(0 <= dimension <= 3 and (not count or rows.min() > 0))
            _demand(not count or rows[:, 1:].max() <= head.most)
            counted += count
        _demand(counted == of_elements.size)
    except (ValueError, OverflowError, TypeError) as problem:
        raise _damaged(path, what) from problem


def _blocks(section: Numbers, head: Head) -> Iterator[tuple[int, int, int]]:
    """Yield dimension, kind and size of the blocks of a section; the caller reads their content."""
    _demand(min(head) >= 0)
    for _ in range(head.blocks):
        dimension, _, kind, count = section.numbers(3, 1)
        _demand(count >= 0)
        yield dimension, kind, count


def _damaged(path: Path, what: str) -> FileError:
    return FileError(
        f"{path.name} is damaged: the count or the numbers of its {what} do not agree with its header. {REMEDY}"
    )


def _demand(is_so: bool) -> None:
    if not is_so:
        raise ValueError
