"""Superelements as text: OpenFAST's ExtPtfm, DMIG cards of Nastran, user elements of Abaqus."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame

SYMMETRIC, DOUBLE = 6, 2
"""Numbers of Nastran for the form and the numbers of a matrix."""

FIRST_MODE = 1001
"""Least number of a scalar point of Nastran, and of a node of Abaqus, that carries a mode."""

STEP = 1.0
"""Time between the two rows of loads of OpenFAST, which are zero, s."""


@dataclass(frozen=True, eq=False)
class Superelement:
    """Matrices over the motions of boundary nodes, and of modes behind them.

    Attributes
    ----------
    frames : tuple of InterfaceFrame
        Interfaces that are nodes.
    rows : tuple of (int, int)
        Frame and component (0 to 5) of the first rows; all further ones are modes.
    mass, damping, stiffness : ndarray, shape (n, n)
        In m, kg, s, rad.
    """

    frames: tuple[InterfaceFrame, ...]
    rows: tuple[tuple[int, int], ...]
    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray

    @property
    def modes(self) -> int:
        """Number of modes."""
        return len(self.mass) - len(self.rows)

    @property
    def numbers(self) -> dict[str, int]:
        """Number of the node of each interface, and of each mode as "mode 1"."""
        first = max(FIRST_MODE, len(self.frames) + 1)
        return {frame.name: i for i, frame in enumerate(self.frames, 1)} | {
            f"mode {i + 1}": first + i for i in range(self.modes)
        }

    @property
    def labels(self) -> list[tuple[int, int]]:
        """Label and component (1 to 6, 0 of a mode) of each row."""
        return [(i + 1, c + 1) for i, c in self.rows] + [(number, 0) for number in self.mode_numbers]

    @property
    def mode_numbers(self) -> list[int]:
        """Number of each mode."""
        return list(self.numbers.values())[len(self.frames) :]


def openfast(found: Superelement) -> str:
    """Return the file of matrices of ExtPtfm: header, three matrices, and loads over time, here none."""
    n = len(found.mass)
    head = ["!Superelement, written by kanefe", "!Flex 5 format", f"!Dimension: {n}"]
    head += [f"!Time increment in simulation: {STEP}", f"!Total simulation time in file: {STEP}"]
    for name, matrix in (
        ("Mass Matrix (Units (kg,m))", found.mass),
        ("Stiffness Matrix (Units (N,m))", found.stiffness),
        ("Damping Matrix (Units (N,m,kg))", found.damping),
    ):
        head += ["", f"!{name}", f"!Dimension: {n}", *(" ".join(f"{x:23.15e}" for x in row) for row in matrix)]
    head += ["", "!Loading and Wave Elevation (Units (N,m))", f"!Dimension: 1 time column - {n} force columns"]
    head += [" ".join(f"{x:23.15e}" for x in (time, *np.zeros(n))) for time in (0.0, STEP)]
    return "\n".join([*head, ""])


def nastran(found: Superelement) -> str:
    """Return bulk data with grid points, scalar points and DMIG cards in large fields."""
    lines = ["$ Superelement, written by kanefe: K2GG = KAAX, M2GG = MAAX, B2GG = BAAX"]
    for i, frame in enumerate(found.frames, 1):
        x, y, z = (f"{value:16.9E}" for value in frame.position)
        lines += [f"$ grid {i}: {_plain(frame.name)}", f"{'GRID*':8s}{i:16d}{'':16s}{x}{y}*", f"{'*':8s}{z}"]
    lines += [f"{'SPOINT':8s}{number:8d}" for number in found.mode_numbers]
    for name, matrix in (("KAAX", found.stiffness), ("MAAX", found.mass), ("BAAX", found.damping)):
        if matrix.any():
            lines += _direct(name, matrix, found.labels)
    return "\n".join([*lines, ""])


def _direct(name: str, matrix: np.ndarray, labels: list[tuple[int, int]]) -> Iterator[str]:
    """Yield the cards of the lower triangle of a matrix, column by column."""
    yield f"{'DMIG':8s}{name:8s}{0:8d}{SYMMETRIC:8d}{DOUBLE:8d}{0:8d}"
    for j, (label, component) in enumerate(labels):
        rows = [i for i in range(j, len(labels)) if matrix[i, j] != 0.0]
        if rows:
            yield f"{'DMIG*':8s}{name:16s}{label:16d}{component:16d}{'':16s}*"
        for at, i in enumerate(rows):
            number = f"{matrix[i, j]:16.9E}".replace("E", "D")
            yield f"{'*':8s}{labels[i][0]:16d}{labels[i][1]:16d}{number}{'':16s}{'*' if at + 1 < len(rows) else ''}"


def abaqus(found: Superelement) -> str:
    """Return a linear user element with its matrices, and nodes."""
    numbers = found.numbers
    lines = ["** Superelement, written by kanefe", "*NODE, NSET=SUPERELEMENT"]
    places = [*(frame.position for frame in found.frames), *np.zeros((found.modes, 3))]
    lines += [f"{n}, {x:.15e}, {y:.15e}, {z:.15e}" for n, (x, y, z) in zip(numbers.values(), places, strict=True)]
    lines += [f"*NSET, NSET={_plain(frame.name).upper()}\n{i}" for i, frame in enumerate(found.frames, 1)]
    lines += [f"*USER ELEMENT, TYPE=U1, NODES={len(numbers)}, LINEAR", "** ELEMENT NODES"]
    listed = [str(number) for number in numbers.values()]
    lines += ["** " + ", ".join(listed[i : i + 8]) for i in range(0, len(listed), 8)]
    freedoms = ["1, 2, 3, 4, 5, 6" if frame.turns else "1, 2, 3" for frame in found.frames] + ["1"] * found.modes
    lines += [freedoms[0]]
    lines += [f"{i + 1}, {freedoms[i]}" for i in range(1, len(freedoms)) if freedoms[i] != freedoms[i - 1]]
    for name, matrix in (("STIFFNESS", found.stiffness), ("MASS", found.mass), ("VISCOUS DAMPING", found.damping)):
        if matrix.any():
            values = [f"{x:.15e}" for x in matrix[np.tril_indices(len(matrix))]]
            lines += [f"*MATRIX, TYPE={name}", *(", ".join(values[i : i + 4]) for i in range(0, len(values), 4))]
    lines += ["*ELEMENT, TYPE=U1, ELSET=SUPERELEMENT"]
    row = ["1", *listed]
    lines += [", ".join(row[i : i + 16]) + ("," if i + 16 < len(row) else "") for i in range(0, len(row), 16)]
    return "\n".join([*lines, "*UEL PROPERTY, ELSET=SUPERELEMENT", ""])


def _plain(name: str) -> str:
    """Return a name of letters, digits and underscores."""
    return "".join(c if c.isascii() and c.isalnum() else "_" for c in name)


FORMS: dict[str, Callable[[Superelement], str]] = {"openfast": openfast, "nastran": nastran, "abaqus": abaqus}
"""Formats by name."""
