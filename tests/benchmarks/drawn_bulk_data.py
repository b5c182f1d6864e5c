"""Bulk data of Nastran drawn at random: grid points in systems in systems, written in all forms of fields."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

SYSTEMS, GRIDS = 40, 2000
"""Numbers of systems and of grid points in a deck."""

FIRST_CORNER = 900_001
"""Label of the first of the grid points that place systems."""

BY_GRIDS = 0.4
"""Share of systems that grid points place (CORD1)."""

FORMS = ("small", "large", "free")
"""Forms of fields."""

WIDTHS = {"small": 8, "large": 16}


class _Placed(NamedTuple):
    """Kind, origin and axes (columns) of a system as it was drawn; fields round them."""

    kind: str
    origin: np.ndarray
    axes: np.ndarray


def bulk_of(seed: int, explicit: bool = False) -> str:
    """Return a deck; if `explicit`, without GRDSET, whose systems then stand on all points that name none.

    Of four seeds one has cards of all forms of fields, the others have one form each.
    """
    rng = np.random.default_rng(seed)
    forms = FORMS if seed % 4 == 0 else FORMS[seed % 4 - 1 : seed % 4]
    placed = {0: _Placed("R", np.zeros(3), np.eye(3))}
    lines: list[list[str]] = []
    usual = [int(x) for x in rng.integers(1, SYSTEMS + 1, 2)]
    for number in rng.permutation(np.arange(1, SYSTEMS + 1)).tolist():
        parent, kind = int(rng.choice(list(placed)[-8:])), str(rng.choice(list("RCS")))
        turned, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        A, origin = turned * np.sign(np.linalg.det(turned)), rng.uniform(-3, 3, 3)
        corners = origin, origin + rng.uniform(0.5, 2) * A[:, 2], origin + A @ (rng.uniform(0.5, 2), 0, rng.normal())
        if rng.random() < BY_GRIDS:
            labels = [FIRST_CORNER + 3 * number + i for i in range(3)]
            lines.append(_written(f"CORD1{kind}", [number, *labels], rng, forms))
            for label, corner in zip(labels, corners, strict=True):
                turn = usual[1] if explicit else None
                lines.append(_written("GRID", [label, parent, *_seen_from(placed[parent], corner), turn], rng, forms))
        else:
            seen = [x for corner in corners for x in _seen_from(placed[parent], corner)]
            lines.append(_written(f"CORD2{kind}", [number, parent, *seen], rng, forms))
        placed[number] = _Placed(kind, origin, A)
    for label in (rng.permutation(GRIDS) + 1).tolist():
        named = [int(x) if rng.random() < 0.8 else None for x in rng.integers(0, SYSTEMS + 1, 2)]
        within, turned_by = (usual[i] if x is None else x for i, x in enumerate(named))
        seen = _seen_from(placed[within], rng.uniform(-5, 5, 3))
        own = (within, turned_by) if explicit else named
        lines.append(_written("GRID", [label, own[0], *seen, own[1]], rng, forms))
    grdset = _written("GRDSET", [None, usual[0], None, None, None, usual[1]], rng, forms)
    lines.append(["$"] if explicit else grdset)
    order = rng.permutation(len(lines))
    return "\n".join(["CEND", "BEGIN BULK", *(line for i in order for line in lines[i]), "ENDDATA", ""])


def _seen_from(system: _Placed, point: np.ndarray) -> list[float]:
    """Return the coordinates that a system has of a point, angles in degrees."""
    x, y, z = system.axes.T @ (point - system.origin)
    far = float(np.linalg.norm((x, y, z)))
    around = float(np.degrees(np.arctan2(y, x)))
    if system.kind == "R":
        return [float(x), float(y), float(z)]
    if system.kind == "C":
        return [float(np.hypot(x, y)), around, float(z)]
    return [far, float(np.degrees(np.arccos(z / far))), around]


def _written(
    name: str, fields: list[float | int | None], rng: np.random.Generator, forms: tuple[str, ...]
) -> list[str]:
    """Return the lines of a card in one of the forms of fields."""
    form = str(rng.choice(forms))
    size = 16 if form == "free" else WIDTHS[form]
    texts = ["" if x is None else str(x) if isinstance(x, int) else _real(x, size, rng) for x in fields]
    most = 4 if form == "large" else 8
    rows = [texts[i : i + most] for i in range(0, len(texts), most)]
    if form == "free":
        blank = " " * int(rng.integers(0, 2))
        return [f",{blank}".join([name if i == 0 else str(rng.choice(("", "+"))), *row]) for i, row in enumerate(rows)]
    star = "*" if form == "large" else ""
    heads = [(name + star if i == 0 else star or str(rng.choice(("", "+")))).ljust(8) for i in range(len(rows))]
    texts_of = [[text.ljust(size) if rng.random() < 0.5 else text.rjust(size) for text in row] for row in rows]
    return [(head + "".join(row)).rstrip() for head, row in zip(heads, texts_of, strict=True)]


def _real(x: float, size: int, rng: np.random.Generator) -> str:
    """Return a number with as many digits as its field has room for, its exponent in any form."""
    letter = str(rng.choice(("E", "D", "e", "", ".", "0.")))  # the last two: without an exponent
    for digits in range(size, -1, -1):
        if letter in (".", "0."):
            text = f"{x:#.{digits}f}".replace("0.", letter, 1) if abs(x) < 1.0 else f"{x:#.{digits}f}"
        else:
            mantissa, exponent = f"{x:#.{digits}e}".split("e")
            text = f"{mantissa}{letter}{int(exponent):+d}"
        if len(text) <= size:
            return text if any(c in "123456789" for c in text.partition("e")[0]) else "0."
    return "0."
