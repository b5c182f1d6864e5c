"""EQUATIONS.md is true both ways: what it names cites the equation, and what cites an equation is named."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache

import pytest

from repository import ROOT

FOLDERS = {"kanefe": ROOT / "kanefe", "kanefe_fem": ROOT / "fem" / "kanefe_fem"}
MAP = ROOT / "kanefe" / "EQUATIONS.md"
NUMBERS = range(1, 49)

# "Eq. 41", "Eq. 13-16", "Eq. 31-34, 39", "Eq. 27 and 36", "Eq. 40 to 42"
CITATION = re.compile(r"Eqs?\.\s*(\d+(?:(?:\s*-\s*|\s*,\s*|\s+and\s+|\s+to\s+)(?:Eq\.\s*)?\d+)*)")


def cited(text: str) -> set[int]:
    """Return the numbers of the equations that a text cites."""
    found: set[int] = set()
    for match in CITATION.finditer(text):
        parts = re.findall(r"(\d+)(?:\s*(?:-|to)\s*(\d+))?", match.group(1))
        for first, last in parts:
            found.update(range(int(first), int(last or first) + 1))
    return found


@cache
def docstrings() -> dict[str, str]:
    """Return the docstring of every module, class, method and function by names such as "kanefe/frames.py:skew"."""
    return dict(_docstrings())


def _docstrings() -> Iterator[tuple[str, str]]:
    for package, folder in FOLDERS.items():
        for path in sorted(folder.rglob("*.py")):
            name = f"{package}/{path.relative_to(folder).as_posix()}"
            tree = ast.parse(path.read_text(encoding="utf-8"))
            if ast.get_docstring(tree):
                yield name, ast.get_docstring(tree) or ""
            yield from _inner(name, ":", tree)


def _inner(name: str, separator: str, node: ast.AST) -> Iterator[tuple[str, str]]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, (ast.FunctionDef, ast.ClassDef)):
            inner = f"{name}{separator}{child.name}"
            yield inner, ast.get_docstring(child) or ""
            yield from _inner(inner, ".", child)


def table() -> dict[int, list[str]]:
    """Return the functions of each equation in EQUATIONS.md."""
    rows: dict[int, list[str]] = {}
    for line in MAP.read_text(encoding="utf-8").splitlines():
        match = re.match(r"\|\s*(\d+)\s*\|([^|]*)\|", line)
        if match:
            assert int(match.group(1)) not in rows, f"Eq. {match.group(1)} has two rows"
            rows[int(match.group(1))] = re.findall(r"`([^`]+)`", match.group(2))
    return rows


ROWS = table()


def test_every_equation_has_a_row() -> None:
    assert list(ROWS) == list(NUMBERS)
    assert all(ROWS.values())


@pytest.mark.parametrize("number", NUMBERS)
def test_mapped_functions_exist_and_cite_their_equation(number: int) -> None:
    for name in ROWS[number]:
        assert name in docstrings(), f"Eq. {number} is mapped to {name}, which is not there or has no docstring"
        assert number in cited(docstrings()[name]), f"the docstring of {name} does not cite Eq. {number}"


def test_what_says_in_its_first_line_that_it_is_an_equation_is_in_the_map() -> None:
    first_lines = {name: cited(text.partition("\n")[0]) for name, text in docstrings().items() if ":" in name}
    assert sum(map(len, first_lines.values())) > len(NUMBERS)
    missing = {f"{name}: Eq. {n}" for name, found in first_lines.items() for n in found if name not in ROWS.get(n, [])}
    assert not missing, "these cite an equation: add them to its row of EQUATIONS.md"


def test_every_citation_is_of_an_equation_of_the_paper() -> None:
    wrong = {name: cited(text) - set(NUMBERS) for name, text in docstrings().items() if cited(text) - set(NUMBERS)}
    assert not wrong


def test_citations_are_read() -> None:
    assert cited("(Eq. 41)") == {41}
    assert cited("(Eq. 13-16 along the chain), Eq. 8") == {8, 13, 14, 15, 16}
    assert cited("(Eq. 31-34, 39), Eq. 27 and 36") == {27, 31, 32, 33, 34, 36, 39}
    assert cited("no equation of 1988, p. 4") == set()
