"""The layers: which room may import which, that an edge upwards is noticed, and that no files form a circle."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from kanefe._public import SERVED, served
from repository import ROOT

PACKAGES = {"kanefe": ROOT / "kanefe", "kanefe_fem": ROOT / "fem" / "kanefe_fem"}
CONTRACTS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]["contracts"]
# What lies flat in the root of a package may be imported from anywhere by its name, so it is kept to what has no room.
MOST_ROOT_FILES = {"kanefe": 10, "kanefe_fem": 10}


def lint(*folders: Path) -> tuple[bool, str]:
    """Return whether the contracts of pyproject.toml hold for the packages in some folders, and what is said of it."""
    code = "from importlinter.cli import lint_imports_command as lint; lint()"
    plain = {"NO_COLOR": "1", "TERM": "dumb", "COLUMNS": "200"}
    done = subprocess.run(
        [sys.executable, "-c", code, "--no-cache", "--config", str(ROOT / "pyproject.toml")],
        cwd=folders[0],
        env={**os.environ, **plain, "PYTHONPATH": os.pathsep.join(map(str, folders))},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    said = done.stdout + done.stderr
    return done.returncode == 0, said[max(said.find("Broken contracts"), 0) :]


def nodes_of(text: str) -> Iterator[ast.AST]:
    """Yield the statements of a file, at all depths; also its expressions, if modules are imported by them."""
    tree = ast.parse(text)
    if "import_module" in text:
        yield from ast.walk(tree)
        return
    left: list[ast.AST] = [tree]
    while left:
        node = left.pop()
        yield node
        parts = (getattr(node, name, ()) for name in ("body", "orelse", "finalbody", "handlers", "cases"))
        left += [one for part in parts if isinstance(part, list) for one in part]


def imports_of(package: str, folder: Path | None = None) -> dict[str, set[str]]:
    """Return what each file of a package imports of it: at the top, in functions, for type checkers, by its name."""
    folder = folder or PACKAGES[package]
    paths = {
        path: ".".join((package, *path.relative_to(folder).with_suffix("").parts)) for path in folder.rglob("*.py")
    }
    files = {name.removesuffix(".__init__"): path for path, name in paths.items()}
    found: dict[str, set[str]] = {}
    for name, path in files.items():
        ends: set[str] = set()
        for node in nodes_of(path.read_text(encoding="utf-8")):
            if isinstance(node, ast.Import):
                ends |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                inner = [f"{node.module}.{alias.name}" for alias in node.names]
                ends |= {one if one in files else str(node.module) for one in inner}
            elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("import_module"):
                ends |= {str(one.value) for one in node.args[:1] if isinstance(one, ast.Constant)}
        found[name] = ends & set(files)
    return found


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    for name, folder in PACKAGES.items():
        shutil.copytree(folder, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


def test_the_contracts_hold() -> None:
    holds, said = lint(*(folder.parent for folder in PACKAGES.values()))
    assert holds, said


FUNCTION = "\n\ndef _trespass():\n    from {} import {}\n"
FOR_TYPES = "\n\nif TYPE_CHECKING:\n    from {} import {}\n"


TRESPASSES = [
    ("kanefe/kane/energy.py", FUNCTION, "kanefe.system", "System"),
    ("kanefe/loads/spring.py", FOR_TYPES, "kanefe.tree.freeze", "build_model"),
    ("kanefe/constraints/rows.py", FUNCTION, "kanefe.loads.spring", "Spring"),  # a room of the same layer
    ("kanefe/joints/revolute.py", FUNCTION, "kanefe_fem.beams.body", "beam_body"),
    ("kanefe_fem/mesh/mesh.py", FUNCTION, "kanefe.kernels.tables", "Tables"),
]


def test_edges_upwards_are_noticed_and_named(copy: Path) -> None:
    for path, lines, module, name in TRESPASSES:
        with (copy / path).open("a", encoding="utf-8") as file:
            file.write(lines.format(module, name))
    holds, said = lint(copy)
    assert not holds
    for path, _, module, _ in TRESPASSES:
        importer = path.removesuffix(".py").replace("/", ".")
        assert f"{importer} -> {module} (l." in said


def test_a_room_without_a_layer_is_noticed(copy: Path) -> None:
    (copy / "kanefe" / "cellar").mkdir()
    (copy / "kanefe" / "cellar" / "__init__.py").touch()
    holds, said = lint(copy)
    assert not holds
    assert "cellar" in said


def circles(imports: dict[str, set[str]]) -> list[list[str]]:
    """Return the files of each strongly connected component of more than one, and those that import themselves."""
    names = sorted(imports)
    place = {name: i for i, name in enumerate(names)}
    edges = [(place[name], place[end]) for name, ends in imports.items() for end in ends]
    matrix = csr_array((np.ones(len(edges)), tuple(np.array(edges).T)), shape=(len(names), len(names)))
    _, labels = connected_components(matrix, directed=True, connection="strong")
    found = [[names[i] for i in np.flatnonzero(labels == label)] for label in np.unique(labels)]
    return [part for part in found if len(part) > 1 or part[0] in imports[part[0]]]


@pytest.mark.parametrize("package", PACKAGES)
def test_no_files_import_each_other_in_a_circle(package: str) -> None:
    imports = imports_of(package)
    assert len(imports) > 80
    assert circles(imports) == []


def test_imports_in_functions_and_for_type_checkers_count(tmp_path: Path) -> None:
    texts = {
        "__init__": "from house.a import x",
        "a": "def f():\n    from house import b",
        "b": "if TYPE_CHECKING:\n    from house.c import y",
        "c": "import house.a, sys",
        "d": "import_module('house.d')",
        "e": "from house.a import x",
    }
    for name, text in texts.items():
        (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")
    assert circles(imports_of("house", tmp_path)) == [["house.a", "house.b", "house.c"], ["house.d"]]


def test_no_layer_has_exceptions() -> None:
    assert [c["name"] for c in CONTRACTS if c["type"] == "layers" and "ignore_imports" in c] == []


def test_what_is_served_from_above_is_there_and_used() -> None:
    text = "".join(path.read_text(encoding="utf-8") for path in PACKAGES["kanefe"].rglob("*.py"))
    assert set(re.findall(r'served\("(\w+)"\)', text)) == set(SERVED)
    for name, module in SERVED.items():
        assert served(name).__module__ == module


@pytest.mark.parametrize("package", PACKAGES)
def test_few_files_lie_in_the_root(package: str) -> None:
    files = sorted(path.name for path in PACKAGES[package].glob("*.py"))
    assert len(files) <= MOST_ROOT_FILES[package], f"give one of them a room: {', '.join(files)}"
