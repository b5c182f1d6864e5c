"""The layers: which room may import which, that an edge upwards is noticed, and that no files form a circle."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import grimp
import pytest

from repository import ROOT

PACKAGES = {"kanefe": ROOT / "kanefe", "kanefe_fem": ROOT / "fem" / "kanefe_fem"}
CONTRACTS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]["contracts"]
SANCTIONED = {
    tuple(edge.split(" -> "))
    for contract in CONTRACTS
    if contract["type"] == "layers"
    for edge in contract.get("ignore_imports", [])
}

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


def imports_of(package: str) -> dict[str, set[str]]:
    """Return what each file of a package imports of it, also in functions and for type checkers."""
    graph = grimp.build_graph(*PACKAGES, cache_dir=None)
    inside = {name for name in graph.modules if name.partition(".")[0] == package}
    return {name: graph.find_modules_directly_imported_by(name) & inside for name in inside}


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


@pytest.mark.parametrize(
    ("path", "lines", "module", "name"),
    [
        ("kanefe/kane/energy.py", FUNCTION, "kanefe.system", "System"),
        ("kanefe/loads/spring.py", FOR_TYPES, "kanefe.tree.freeze", "build_model"),
        ("kanefe/constraints/rows.py", FUNCTION, "kanefe.loads.spring", "Spring"),  # a room of the same layer
        ("kanefe/joints/revolute.py", FUNCTION, "kanefe_fem.beams.body", "beam_body"),
        ("kanefe_fem/mesh/mesh.py", FUNCTION, "kanefe.kernels.layout", "COUNT"),
    ],
)
def test_an_edge_upwards_is_noticed_and_named(copy: Path, path: str, lines: str, module: str, name: str) -> None:
    with (copy / path).open("a", encoding="utf-8") as file:
        file.write(lines.format(module, name))
    holds, said = lint(copy)
    assert not holds
    importer = path.removesuffix(".py").replace("/", ".")
    assert f"{importer} -> {module} (l." in said


def test_a_room_without_a_layer_is_noticed(copy: Path) -> None:
    (copy / "kanefe" / "cellar").mkdir()
    (copy / "kanefe" / "cellar" / "__init__.py").touch()
    holds, said = lint(copy)
    assert not holds
    assert "cellar" in said


@pytest.mark.parametrize("package", PACKAGES)
def test_no_files_import_each_other_in_a_circle(package: str) -> None:
    imports = imports_of(package)
    # the sanctioned edge is one to a room; it is no way into a circle of files for the others
    allowed = {name: {end for end in ends if (name, end) not in SANCTIONED} for name, ends in imports.items()}
    try:
        TopologicalSorter(allowed).prepare()
    except CycleError as error:
        pytest.fail(f"a circle, each imported by the next: {' -> '.join(error.args[1])}")


@pytest.mark.parametrize("package", PACKAGES)
def test_few_files_lie_in_the_root(package: str) -> None:
    files = sorted(path.name for path in PACKAGES[package].glob("*.py"))
    assert len(files) <= MOST_ROOT_FILES[package], f"give one of them a room: {', '.join(files)}"
