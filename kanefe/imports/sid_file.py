"""The text of Standard Input Data: named Taylor expansions ``A(q) = M0 + sum_l M1_l q_l`` in nested blocks.

Wallrapp, "Standardization of flexible body modeling in multibody system codes, Part I: Definition of Standard Input
Data", Mech. Struct. Mach. 22 (1994) 283-304. Entries are ``m0(row, column)`` and ``m1(row, mode, column)``; some
writers put the column before the mode, which shows where a column vector has a third index above one.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from kanefe.errors import FileError, outside
from kanefe.imports.text import read_text

BODY_TERMS = ("mdCM", "J", "Ct", "Cr", "Me", "Gr", "Ge", "Oe", "ksigma", "Ke", "De")
NODE_TERMS = ("origin", "phi", "psi", "AP", "sigma")
ZERO, DIAGONAL, SYMMETRIC, FULL, IDENTITY = range(5)
"""Values of `structure` of a matrix."""

_ENTRY = re.compile(r"^(m0|m1|mn)\s*\(([\d\s,]+)\)\s*=\s*(\S+)", re.IGNORECASE)
_VALUE = re.compile(r"^(\w+)\s*(?:\(\s*(\d+)\s*\))?\s*=\s*(.*)$")


class SidWarning(UserWarning):
    """A file whose terms do not determine all of the inertia."""


@dataclass(eq=False)
class Taylor:
    """One expansion in the modal coordinates.

    Attributes
    ----------
    m0 : ndarray, shape (rows, columns)
    m1 : ndarray, shape (rows, columns, modes), or None
        None: of order 0.
    structure : int
        `ZERO` ... `IDENTITY`.
    """

    m0: np.ndarray
    m1: np.ndarray | None = None
    structure: int = FULL


@dataclass(eq=False)
class SidFile:
    """Content of a SID file.

    Attributes
    ----------
    mass : float
    modes : list of str
        Name of every modal coordinate.
    nodes : dict of str to (dict of str to Taylor)
        Expansions of each node frame by its identifier.
    terms : dict of str to Taylor
        Expansions of the body.
    """

    mass: float = float("nan")
    modes: list[str] = field(default_factory=list)
    nodes: dict[str, dict[str, Taylor]] = field(default_factory=dict)
    terms: dict[str, Taylor] = field(default_factory=dict)


def sid_text(data: SidFile) -> str:
    """Return the text of a SID file, without zero entries."""
    lines = ["part", " new modal", "  refmod", f"   mass = {data.mass:.17e}", f"   nelastq = {len(data.modes)}"]
    lines += [f"   ielastq({i}) = {name}" for i, name in enumerate(data.modes, 1)]
    lines += ["  end refmod", "  frame"]
    for identifier, terms in data.nodes.items():
        lines += [f"   new node = {identifier}", "    rframe = body ref"]
        for name, term in terms.items():
            lines += _term_lines(name, term, len(data.modes), "    ")
        lines.append("   end node")
    lines.append("  end frame")
    for name, term in data.terms.items():
        lines += _term_lines(name, term, len(data.modes), "  ")
    return "\n".join([*lines, " end modal", "end part", ""])


def _term_lines(name: str, term: Taylor, count: int, indent: str) -> list[str]:
    rows, columns = term.m0.shape
    inner = indent + " "
    values = (0 if term.m1 is None else 1, rows, columns, count, 0, term.structure)
    keys = ("order", "nrow", "ncol", "nq", "nqn", "structure")
    lines = [indent + name, *(f"{inner}{key} = {value}" for key, value in zip(keys, values, strict=True))]
    lines += [f"{inner}m0({i + 1}, {j + 1}) = {term.m0[i, j]:.17e}" for i, j in _written(term.m0, term.structure)]
    if term.m1 is not None:
        for mode in range(count):
            slab = term.m1[:, :, mode]
            lines += [
                f"{inner}m1({i + 1}, {mode + 1}, {j + 1}) = {slab[i, j]:.17e}"
                for i, j in _written(slab, term.structure)
            ]
    return [*lines, f"{indent}end {name}"]


def _written(matrix: np.ndarray, structure: int) -> Iterator[tuple[int, int]]:
    for i, j in zip(*np.nonzero(matrix), strict=True):
        if structure != SYMMETRIC or i >= j:
            yield int(i), int(j)


def parse_sid(path: str | Path) -> SidFile:
    """Return the content of a SID file.

    Raises
    ------
    FileError
        If the file does not exist, is truncated, or has a line or index that its header does not allow.
    """
    data = SidFile()
    lines = [(number, line.partition("!")[0].strip()) for number, line in _numbered(read_text(path, "SID"))]
    terms = {name.lower(): name for name in (*BODY_TERMS, *NODE_TERMS)}
    node: dict[str, Taylor] | None = None
    raw: dict[int, _Raw] = {}
    at = 0
    while at < len(lines):
        number, line = lines[at]
        at += 1
        if line.lower() in terms:
            name = terms[line.lower()]
            end = next((i for i in range(at, len(lines)) if lines[i][1].lower().startswith("end")), None)
            if end is None:
                raise FileError(f"{path} is truncated in {name} (line {number}). Remedy: export it again")
            taylor = Taylor(np.zeros((0, 0)))
            raw[id(taylor)] = _Raw(taylor, name, _parsed(lines[at:end], path))
            (node if node is not None and name in NODE_TERMS else data.terms)[name] = taylor
            at = end + 1
        elif line.lower().startswith("new node"):
            identifier = line.partition("=")[2].strip().strip("'\"") or str(len(data.nodes) + 1)
            if identifier in data.nodes:
                raise FileError(f"{path} has two nodes {identifier!r} (line {number}). Remedy: number them apart")
            node = data.nodes[identifier] = {}
        elif line.lower().startswith("end node"):
            node = None
        elif (value := _VALUE.match(line)) is not None:
            _refmod(data, value, path, number)
    if not lines or not any(line.lower().startswith(("end part", "end modal")) for _, line in lines[-5:]):
        raise FileError(
            f"{path} is truncated or not a SID file: it does not end in 'end part'. Remedy: export it again"
        )
    missing = [name for name in BODY_TERMS if name not in data.terms and name not in ("ksigma", "De")]
    if missing or not data.modes or not np.isfinite(data.mass):
        what = ", ".join(missing) or "mass or nelastq in refmod"
        raise FileError(f"{path} lacks {what}. Remedy: export the whole modal block")
    _count_of_terms(data, raw[id(data.terms["Me"])].parsed.header.get("nrow", 0), path)
    column_first = any(entry.column_first() for entry in raw.values())
    for entry in raw.values():
        entry.fill(column_first, len(data.modes), path)
    return data


def _count_of_terms(data: SidFile, count: int, path: str | Path) -> None:
    """Keep the coordinates of the terms: some writers list all modes of the finite-element model in refmod."""
    listed = len(data.modes)
    if not 0 < count <= listed:
        raise FileError(
            f"{path} has {listed} coordinates in refmod (nelastq), and an Me of {count} rows. Remedy: export it again"
        )
    if count < listed:
        warnings.warn(
            f"refmod of {path} lists nelastq = {listed} coordinates, the terms have {count}: these are used, with the "
            "names of the first ones listed",
            SidWarning,
            stacklevel=outside(),
        )
        del data.modes[count:]


def _numbered(text: str) -> Iterator[tuple[int, str]]:
    for number, line in enumerate(text.splitlines(), 1):
        if line.strip():
            yield number, line


def _refmod(data: SidFile, value: re.Match[str], path: str | Path, number: int) -> None:
    key, index, text = value[1].lower(), value[2], value[3].strip().strip("'\"").strip()
    try:
        if key == "mass":
            data.mass = float(text.upper().replace("D", "E"))
        elif key == "nelastq":
            data.modes = [f"mode {i}" for i in range(1, int(text) + 1)]
        elif key == "ielastq" and index is not None:
            data.modes[int(index) - 1] = text
    except (ValueError, IndexError) as error:
        raise FileError(f"{path} has a damaged line {number} ({error}). Remedy: export it again") from error


@dataclass(frozen=True, eq=False)
class _Parsed:
    header: dict[str, int]
    entries: list[tuple[int, str, tuple[int, ...], float]]


def _parsed(lines: list[tuple[int, str]], path: str | Path) -> _Parsed:
    """Return header and entries of one expansion."""
    header: dict[str, int] = {}
    entries: list[tuple[int, str, tuple[int, ...], float]] = []
    for number, line in lines:
        found = _ENTRY.match(line)
        try:
            if found is not None:
                indices = tuple(int(i) - 1 for i in found[2].split(","))
                entries.append((number, found[1].lower(), indices, float(found[3].upper().replace("D", "E"))))
            elif (value := _VALUE.match(line)) is not None:
                header[value[1].lower()] = int(value[3])
            else:
                raise ValueError(f"{line!r} is not an entry")
        except ValueError as error:
            raise FileError(f"{path} has a damaged line {number} ({error}). Remedy: export it again") from error
    return _Parsed(header, entries)


@dataclass(frozen=True, eq=False)
class _Raw:
    """Entries of one expansion, before the order of their indices is known."""

    taylor: Taylor
    name: str
    parsed: _Parsed

    def column_first(self) -> bool:
        """Return whether the indices of a column vector show that the mode is the last index."""
        vector = self.parsed.header.get("ncol") == 1
        return vector and any(kind == "m1" and len(at) == 3 and at[2] > 0 for _, kind, at, _ in self.parsed.entries)

    def fill(self, column_first: bool, count: int, path: str | Path) -> None:
        """Set the arrays of the expansion."""
        header = self.parsed.header
        try:
            order, rows, columns = (header[key] for key in ("order", "nrow", "ncol"))
        except KeyError as error:
            raise FileError(f"{self.name} in {path} lacks {error}. Remedy: export it again") from error
        structure = header.get("structure", FULL)
        m0, m1 = np.zeros((rows, columns)), np.zeros((rows, columns, count))
        if structure == IDENTITY:
            m0 += np.eye(rows, columns)
        for number, kind, at, value in self.parsed.entries:
            if kind == "mn":
                continue  # terms of higher order are optional in the standard, and not used here
            try:
                if kind == "m0" and len(at) == 2 and min(at) >= 0:
                    m0[at] = value
                elif kind == "m1" and len(at) == 3 and min(at) >= 0:
                    m1[at if column_first else (at[0], at[2], at[1])] = value
                else:
                    raise IndexError(f"{kind}{tuple(i + 1 for i in at)}")
            except IndexError as error:
                raise FileError(
                    f"an entry of {self.name} in {path} (line {number}) is outside its {rows} x {columns} matrix of "
                    f"{count} modes ({error}). Remedy: export it again"
                ) from error
        if structure == SYMMETRIC:
            m0, m1 = _filled(m0), np.stack([_filled(m1[:, :, i]) for i in range(count)], axis=2) if count else m1
        self.taylor.m0, self.taylor.m1, self.taylor.structure = m0, m1 if order > 0 else None, structure


def _filled(matrix: np.ndarray) -> np.ndarray:
    """Return a symmetric matrix from one or both triangles."""
    lower, upper = np.tril(matrix, -1), np.triu(matrix, 1)
    if np.any(lower) and np.any(upper):
        return matrix
    return np.asarray(matrix + lower.T + upper.T)
