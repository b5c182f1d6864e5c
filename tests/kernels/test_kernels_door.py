"""The door to numba: where compiled code is kept, when it is made again, and what is said of it.

A kernel of two lines stands for the real ones, which take many seconds to compile.
"""

from __future__ import annotations

import ast
import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

import kanefe.kernels

KERNELS = Path(kanefe.kernels.__file__).parent
ROOT = KERNELS.parents[1]

STEP = """
from small.door import kernel
from small.inner.limits import LIMIT as DEEP
from small.limits import LIMIT

@kernel
def step(x):
    return x + {step} + LIMIT + DEEP
"""

ENTRY = """
from small.door import entry
from small.step import step

@entry
def two_steps(x):
    return step(step(x))
"""

RUN = "from small.entry import two_steps; print(two_steps(1.0), two_steps(2.0))"


class SmallPackage:
    """A package with the real door, an entry, and a kernel in another file; and a cache of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.cache = folder / "small", folder / "cache"
        (self.folder / "inner").mkdir(parents=True)
        shutil.copy(KERNELS / "_numba.py", self.folder / "door.py")
        for path in (self.folder, self.folder / "inner"):
            (path / "__init__.py").touch()
            (path / "limits.py").write_text("LIMIT = 0.0")
        (self.folder / "entry.py").write_text(ENTRY)
        self.write_step(0.5)

    def write_step(self, step: float) -> None:
        (self.folder / "step.py").write_text(STEP.format(step=step))

    def run(self, code: str = RUN, **environment: str) -> tuple[str, str]:
        """Return what a new process prints, and its errors."""
        variables = {"XDG_CACHE_HOME": str(self.cache), "KANEFE_JIT": "1", **environment}
        path = str(self.folder.parent)
        run = subprocess.run(
            [sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": path, **variables}, capture_output=True,
            text=True, check=True,
        )  # fmt: skip
        return run.stdout.strip(), run.stderr


@pytest.fixture
def small(tmp_path: Path) -> SmallPackage:
    return SmallPackage(tmp_path)


def test_compiling_is_announced_once_and_kept(small: SmallPackage) -> None:
    numbers, said = small.run()
    assert numbers == "2.0 3.0"
    assert said.count("\n") == 1
    assert said.startswith("kanefe: compiling two steps ")
    assert "once (kept in " in said
    folder = Path(said.partition("kept in ")[2].rstrip(")\n"))
    assert folder.is_relative_to(small.cache)
    assert any(path.suffix == ".nbi" for path in folder.rglob("*"))
    assert small.run() == (numbers, "")


def test_a_change_in_another_file_is_seen(small: SmallPackage) -> None:
    small.run()
    small.write_step(0.75)
    numbers, said = small.run()
    assert numbers == "2.5 3.5"
    assert said.count("kanefe: compiling two steps") == 1
    small.write_step(0.5)
    assert small.run() == ("2.0 3.0", "")  # the code of the first run is still there


@pytest.mark.parametrize("name", ["limits.py", "inner/limits.py"])
def test_a_change_of_a_constant_is_seen(name: str, small: SmallPackage) -> None:
    small.run()
    (small.folder / name).write_text("LIMIT = 0.25")
    numbers, said = small.run()
    assert numbers == "2.5 3.5"
    assert said.count("kanefe: compiling two steps") == 1
    (small.folder / name).write_text("LIMIT = 0.0")
    assert small.run() == ("2.0 3.0", "")


def test_a_cache_that_cannot_be_written_is_done_without(small: SmallPackage) -> None:
    small.cache.write_text("a file where the folder should be")
    for _ in range(2):
        numbers, said = small.run()
        assert numbers == "2.0 3.0"
        assert said.startswith("kanefe: compiling two steps ")
        assert "cache cannot be written, so this happens in every run" in said


def test_plain_python_imports_no_numba(small: SmallPackage) -> None:
    code = RUN + "; import sys; print('numba' in sys.modules)"
    assert small.run(code, KANEFE_JIT="0") == ("2.0 3.0\nFalse", "")
    assert not small.cache.exists()


def test_the_real_kernels_are_plain_python_too() -> None:
    code = "import sys, kanefe.order_n.route; print('numba' in sys.modules)"
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "PYTHONPATH": path, "KANEFE_JIT": "0"}
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "False"


def door_of(folder: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location("door_of_a_copy", folder / "_numba.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_kernel_file_has_its_say_in_the_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    copy = tmp_path / "kernels"
    shutil.copytree(KERNELS, copy, ignore=shutil.ignore_patterns("__pycache__"))
    (copy / "inner" / "deep").mkdir(parents=True)
    (copy / "inner" / "deep" / "constants.py").write_text("LIMIT = 1.0\n")
    door = door_of(copy)
    first = door._cache_folder()
    assert first.is_dir()
    assert door._cache_folder() == first
    folders = {first}
    files = sorted(copy.rglob("*.py"))
    for path in files:
        kept = path.read_bytes()
        path.write_bytes(kept + b"# changed\n")
        folders.add(door._cache_folder())
        path.write_bytes(kept)
        moved = path.rename(path.with_name("of_another_name.py"))
        folders.add(door._cache_folder())
        moved.rename(path)
    assert len(folders) == 2 * len(files) + 1
    (copy / "__pycache__").mkdir(exist_ok=True)
    (copy / "__pycache__" / "left.py").write_text("LIMIT = 2.0\n")
    assert door._cache_folder() == first


# file of a kernel -> what it may import from outside of the kernels: nothing that holds a number a kernel computes with
OUTSIDE = {"_numba.py": {"kanefe.storage.files", "kanefe.errors"}}


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
    allowed = {"kanefe.kernels", *OUTSIDE.get(path.as_posix(), ())}
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
        ("closing.py", "from kanefe.kane.loop_closure import TOLERANCE"),
        ("closing.py", "from kanefe import assembly"),
        ("closing.py", "import kanefe.kane.loop_closure as a"),
        ("closing.py", "import kanefe"),
        ("closing.py", "def f():\n    from kanefe.kane.loop_closure import TOLERANCE"),
        ("closing.py", "if TYPE_CHECKING:\n    from kanefe.tree.model_data import Model"),
        ("closing.py", "from ..assembly import TOLERANCE"),
        ("closing.py", "from kanefe.kernels_of_others import TOLERANCE"),
        ("closing.py", "import_module('kanefe.kane.loop_closure')"),
        ("closing.py", "import_module(name)"),
        ("closing.py", "from kanefe.errors import ModelError"),
        ("loops/closing.py", "from ...assembly import TOLERANCE"),
        ("loops/_numba.py", "from kanefe.errors import ModelError"),
        ("_numba.py", "from kanefe_fem.beams.body import beam_model"),
    ],
)
def test_an_import_from_outside_is_seen(path: str, source: str) -> None:
    assert len(foreign(Path(path), source)) == 1


@pytest.mark.parametrize(
    ("path", "source"),
    [
        ("closing.py", "import numpy as np\nfrom kanefe.kernels.tolerances import TOLERANCE\nfrom . import layout"),
        ("loops/closing.py", "from ..tolerances import TOLERANCE\nfrom kanefe.kernels import layout"),
        ("_numba.py", "from kanefe.errors import ModelError"),
    ],
)
def test_what_a_kernel_may_import(path: str, source: str) -> None:
    assert foreign(Path(path), source) == []
