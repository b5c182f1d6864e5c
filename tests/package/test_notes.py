"""Notes under constants of modules are sentences that a reader need not decode: quantity first, with its unit."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from itertools import pairwise

import pytest

from repository import ROOT

FOLDERS = ("kanefe", "fem/kanefe_fem")

DANGLING = re.compile(r"(Of|Times|The same|And|But|By|At|From|Up|So|Those|That|What|Where|After|Below|In place of) ")
"""Beginnings that refer to the name above or to another note, and do not name the quantity."""

UNITS = {
    *("m", "mm", "m2", "m3", "s", "kg", "kg/m3", "N", "Pa", "J", "rad", "rad/s", "Hz", "K", "%", "degrees", "turns"),
    *("N/m", "1/s", "s/m", "m/s", "m/s2", "kg/m", "bytes", "pixels", "inch", "inches", "characters"),
}
QUANTITIES = re.compile(
    r"numbers?|counts?|relative|ratios?|fractions?|factors?|power|per cent|multiples?|dimensionless|coefficients?"
    r"|divided by|cosine|sine|probabilit|per unit|eigenvalue|singular value|exponent|degree|order|version"
    r"|ind(ex|ices)|columns?|values?|steps|periods|samples|iterations|evaluations|constants?|identifier|address|date"
    r"|states|colours|products|radians|digits|dots|points|bits|rounds|coordinates|stations|sweeps|deaths"
)
"""Words by which the note under a number says what is counted or what it is relative to, where it has no unit."""


def notes() -> Iterator[tuple[str, ast.expr | None, str]]:
    """Return place, value and text of the note under each constant of a module."""
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            body = ast.parse(path.read_text(encoding="utf-8")).body
            for constant, note in pairwise(body):
                if not isinstance(constant, ast.Assign | ast.AnnAssign) or not isinstance(note, ast.Expr):
                    continue
                if isinstance(note.value, ast.Constant) and isinstance(note.value.value, str):
                    place = f"{path.relative_to(ROOT).as_posix()}:{constant.lineno}"
                    yield place, constant.value, " ".join(note.value.value.split())


def is_number(value: ast.expr | None) -> bool:
    """Return whether a constant is a number or a tuple of numbers, possibly by arithmetic."""
    if isinstance(value, ast.Tuple):
        return all(is_number(each) for each in value.elts)
    allowed = (ast.Constant, ast.UnaryOp, ast.BinOp, ast.operator, ast.unaryop)
    return value is not None and all(
        isinstance(node, allowed) and not isinstance(getattr(node, "value", 0), str | bytes | bool)
        for node in ast.walk(value)
    )


def fault(value: ast.expr | None, text: str) -> str:
    """Return what is wrong with a note, nothing if it can be read by itself."""
    if DANGLING.match(text):
        return f"begins with {text.split()[0]!r}: name the quantity first"
    if not re.match(r"[A-Z(\d]|\w+:|\w+\b", text) or not text.endswith((".", ":")):
        return "is not a sentence that ends in a full stop"
    words = set(re.findall(r"[^\s,;:().]+", text))
    if is_number(value) and not words & UNITS and not QUANTITIES.search(text.lower()):
        return "gives no unit of a number, nor what it counts or is relative to"
    return ""


def test_notes_name_quantity_and_unit() -> None:
    found = list(notes())
    assert len(found) > 500
    assert {place: (wrong, text) for place, value, text in found if (wrong := fault(value, text))} == {}


@pytest.mark.parametrize(
    ("code", "text"),
    [
        ("0.3", "Of the largest: vibrations that count as begun anew."),
        ("10.0", "Times rtol: a share of the energy that a run may miss without a word."),
        ("0.7", "The same of modes that are twofold."),
        ("1e-3", "How much a mesh may differ."),
        ("1e-3", "Distance below which two places are one"),
    ],
)
def test_fragments_are_found(code: str, text: str) -> None:
    assert fault(ast.parse(code, mode="eval").body, text)


def test_sentences_pass() -> None:
    assert not fault(ast.parse("1e-3", mode="eval").body, "Distance below which two points are the same, m.")
    assert not fault(ast.parse("0.3", mode="eval").body, "Coefficient of friction mu, dimensionless.")
