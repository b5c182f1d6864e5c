"""How much code there is, and how long its parts are: no more than the limits of a table.

There is room for an addition or two. A commit that needs more raises a limit and says why; one that takes code away
lowers it.
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from repository import ROOT

LONG_FILE = 400
"""Number of lines above which a file is long."""

PARAMETERS, FUNCTION_LINES = (6, 8), (40, 60, 80)
"""Numbers of parameters of kernels, and of lines of code of functions, above which they are counted."""

LIMITS = {
    "constants of kernels": 267,
    "lines of imports of kernels": 2125,
    "kernels above 8 parameters": 0,
    "kernels above 6 parameters": 8,
    "functions above 40 lines of code": 2,
    "functions above 60 lines of code": 1,
    "functions above 80 lines of code": 0,
    "files above 400 lines": 0,
}
"""Largest values of what is counted."""

ROOMS = {
    "kernels": 33616,
    "integrate": 11450,
    "linear": 10700,
    "imports": 9000,
    "kane": 844,
    "literal": 1587,
    "states": 957,
    "order_n": 5260,
    "loads": 4430,
    "contact": 3638,
    "joints": 3800,
    "results": 3825,
    "checks": 3685,
    "views": 3457,
    "studies": 3490,
    "bodies": 3690,
    "fe_model": 5030,
    "environment": 2836,
    "scene": 3050,
    "reduction": 3320,
    "tree": 3165,
    "storage": 2420,
    "robots": 2214,
    "fmu": 1488,
    "screening": 1197,
    "unreduced": 1157,
    "equations": 1950,
    "certified": 1830,
    "stepping": 726,
    "doctor": 678,
    "report": 577,
    "records": 487,
    "constraints": 422,
    "batches": 500,
}
"""Largest number of lines of each room."""


ADDITION = 100
"""Number of lines by which a room may be longer than that: those of a joint and its like."""


@cache
def parsed() -> dict[Path, tuple[list[str], ast.Module]]:
    """Return lines and syntax tree of each file of the package, by its path there."""
    files = sorted((ROOT / "kanefe").rglob("*.py"))
    texts = {path.relative_to(ROOT / "kanefe"): path.read_text(encoding="utf-8") for path in files}
    return {path: (text.splitlines(), ast.parse(text)) for path, text in texts.items()}


def functions(tree: ast.Module) -> Iterator[ast.FunctionDef]:
    return (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))


def code_lines(function: ast.FunctionDef, lines: list[str]) -> int:
    """Return the number of lines of the body, without its docstring, comments and blank lines."""
    body = function.body[1:] if ast.get_docstring(function) is not None else function.body
    inside = lines[body[0].lineno - 1 : function.end_lineno] if body else []
    return sum(1 for line in inside if line.strip() and not line.strip().startswith("#"))


def constants(tree: ast.Module) -> int:
    """Return the number of names in upper case that a module assigns."""
    targets = [
        target
        for node in tree.body
        for target in (node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)])
    ]
    names = [name for target in targets for name in (target.elts if isinstance(target, ast.Tuple) else [target])]
    return sum(isinstance(name, ast.Name) and name.id.isupper() for name in names)


@cache
def counted() -> Counter[str]:
    found: Counter[str] = Counter()
    for path, (lines, tree) in parsed().items():
        found[f"files above {LONG_FILE} lines"] += len(lines) > LONG_FILE
        for function in functions(tree):
            for limit in FUNCTION_LINES:
                found[f"functions above {limit} lines of code"] += code_lines(function, lines) > limit
        if path.parts[0] != "kernels":
            continue
        found["constants of kernels"] += constants(tree)
        imports = (node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom))
        found["lines of imports of kernels"] += sum((node.end_lineno or 0) - node.lineno + 1 for node in imports)
        for function in functions(tree):
            given = function.args
            count = len(given.posonlyargs + given.args + given.kwonlyargs)
            for limit in PARAMETERS:
                found[f"kernels above {limit} parameters"] += count > limit
    return found


@pytest.mark.parametrize("what", LIMITS)
def test_counts_do_not_grow(what: str) -> None:
    assert counted()[what] <= LIMITS[what], f"{what}: {counted()[what]}"


def test_what_is_counted_has_a_limit() -> None:
    assert counted().keys() == LIMITS.keys()


def test_no_room_grows() -> None:
    """Rooms that are not in the table are new, and small."""
    lines = Counter[str]()
    for path, (text, _) in parsed().items():
        lines[path.parts[0]] += len(text)
    assert {room: count for room, count in lines.items() if count > ROOMS.get(room, LONG_FILE) + ADDITION} == {}
