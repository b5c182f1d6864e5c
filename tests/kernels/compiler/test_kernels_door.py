"""Kernels as plain Python, and what they may import."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import kanefe.kernels

KERNELS = Path(kanefe.kernels.__file__).parent
ROOT = KERNELS.parents[1]


def test_the_real_kernels_are_plain_python_too() -> None:
    code = "import sys, kanefe.order_n.route; print('numba' in sys.modules)"
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "PYTHONPATH": path, "KANEFE_JIT": "0"}
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "False"


# file of a kernel -> what it may import from outside of the kernels: nothing that holds a number a kernel computes with
OUTSIDE = {
    "compiler/_numba.py": {"kanefe.errors"},
    "compiler/_numba_functions.py": {"kanefe.errors"},
    "compiler/foreign.py": {"kanefe.errors"},
    "compiler/compiled_functions.py": {"kanefe.errors", "kanefe.storage.files", "kanefe.storage.kept_code"},
    "compiler/processors.py": {"kanefe.storage.files"},
    "compiler/side_by_side.py": {"kanefe.storage.kept_code"},
    "compiler/build.py": {
        "kanefe.errors",
        "kanefe.storage.kept_code",
        "kanefe.unknown",
    },  # it imports all that there are
}


def imported(tree: ast.AST, package: str) -> Iterator[str]:
    """Yield the full names of what a file of a package imports, wherever in the file."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package.rsplit(".", node.level - 1)[0] if node.level else ""
            module = ".".join(part for part in (above, node.module) if part)
            yield from (f"{module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith(("import_module", "__import__")):
            yield from (a.value if isinstance(a, ast.Constant) else "kanefe.unknown" for a in node.args[:1])


def foreign(path: Path, source: str) -> list[str]:
    """Return what a kernel file (its path in the folder of kernels) imports of kanefe from outside of the kernels."""
    package = ".".join(("kanefe", "kernels", *path.parts[:-1]))
    of_laws = ("kanefe.arguments", "kanefe.errors", "kanefe.frames") if path.parts[:2] == ("contact", "laws") else ()
    allowed = {"kanefe.kernels", *OUTSIDE.get(path.as_posix(), ()), *of_laws}  # laws check what users give them
    return [
        name
        for name in imported(ast.parse(source), package)
        if name.partition(".")[0] in ("kanefe", "kanefe_fem")
        and not any(name == module or name.startswith(f"{module}.") for module in allowed)
    ]


@pytest.mark.parametrize("path", sorted(path.relative_to(KERNELS) for path in KERNELS.rglob("*.py")), ids=str)
def test_no_kernel_imports_from_outside(path: Path) -> None:
    assert foreign(path, (KERNELS / path).read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    ("path", "source"),
    [
        ("closing.py", "from kanefe.literal.loop_closure import TOLERANCE"),
        ("closing.py", "from kanefe import assembly"),
        ("closing.py", "import kanefe.literal.loop_closure as a"),
        ("closing.py", "import kanefe"),
        ("closing.py", "def f():\n    from kanefe.literal.loop_closure import TOLERANCE"),
        ("closing.py", "if TYPE_CHECKING:\n    from kanefe.tree.model_data import Model"),
        ("closing.py", "from ..assembly import TOLERANCE"),
        ("closing.py", "from kanefe.kernels_of_others import TOLERANCE"),
        ("closing.py", "import_module('kanefe.literal.loop_closure')"),
        ("closing.py", "import_module(name)"),
        ("closing.py", "from kanefe.errors import ModelError"),
        ("loops/closing.py", "from ...assembly import TOLERANCE"),
        ("loops/_numba.py", "from kanefe.errors import ModelError"),
        ("compiler/_numba.py", "from kanefe_fem.beams.body import beam_model"),
    ],
)
def test_an_import_from_outside_is_seen(path: str, source: str) -> None:
    assert len(foreign(Path(path), source)) == 1


@pytest.mark.parametrize(
    ("path", "source"),
    [
        (
            "closing.py",
            "import numpy as np\nfrom kanefe.kernels.constraints.tolerances import TOLERANCE\nfrom . import tree",
        ),
        ("loops/closing.py", "from ..tolerances import TOLERANCE\nfrom kanefe.kernels import tree"),
        ("compiler/_numba.py", "from kanefe.errors import ModelError"),
    ],
)
def test_what_a_kernel_may_import(path: str, source: str) -> None:
    assert foreign(Path(path), source) == []
