"""What the package promises about itself: version, entry points, package data, a tidy top level."""

import re
import subprocess
import tomllib
from importlib import import_module
from importlib.metadata import EntryPoint, distribution
from pathlib import Path

import pytest

import kanefe
from repository import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))

FOLDERS = {"kanefe", "meshes", "fem", "tests", "examples", "docs", "findings", ".ci"}
FILES = {"pyproject.toml", "README.md", "LICENSE", "CHANGELOG.md", "CONTRIBUTING.md", "ARCHITECTURE.md", "Makefile"}
FILES |= {"MANIFEST.in", "NOTICE.md", "CITATION.cff"}


def entry_points() -> list[EntryPoint]:
    groups = {"console_scripts": PROJECT["project"]["scripts"], **PROJECT["project"]["entry-points"]}
    return [EntryPoint(name, value, group) for group, points in groups.items() for name, value in points.items()]


def test_the_version_has_one_source():
    assert PROJECT["project"]["dynamic"] == ["version"]
    assert PROJECT["tool"]["setuptools"]["dynamic"]["version"] == {"attr": "kanefe.__version__"}
    assert distribution("kanefe").version == kanefe.__version__
    # a copy, for those who cite without installing
    cited = re.findall(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    assert cited == [kanefe.__version__]


def test_the_notice_names_what_is_not_code_of_ours():
    notice = (ROOT / "NOTICE.md").read_text(encoding="utf-8")
    kinds = {".csv", ".json", ".msh", ".urdf", ".re1", ".three", ".mss"}
    not_ours = [p for p in tracked_files() if Path(p).suffix in kinds and not p.startswith("docs/")]
    # figures of the documents, the public interface, and the tools that make the page of a run are no data
    rest = {"tests/package/public_api.json", "package.json", "package-lock.json"}
    for path in not_ours:
        assert f"`{path}`" in notice or path in rest or Path(path).name in rest, f"{path} is not in NOTICE.md"
    for path in re.findall(r"`([\w./]+\.\w+)`", notice):
        assert (ROOT / path).is_file(), path
    assert set(PROJECT["project"]["license-files"]) >= {"LICENSE", "NOTICE.md"}


def test_the_notice_has_the_version_of_what_is_bundled():
    import json

    made_of = json.loads((ROOT / "kanefe/views/player/web/package.json").read_text(encoding="utf-8"))
    notice = (ROOT / "NOTICE.md").read_text(encoding="utf-8")
    assert f"three.js {made_of['dependencies']['three']}" in notice
    assert f"esbuild {made_of['devDependencies']['esbuild']}" in notice


@pytest.mark.parametrize("point", entry_points(), ids=lambda point: f"{point.group}:{point.name}")
def test_entry_points_resolve_and_are_installed(point):
    assert point.load() is not None
    installed = {(p.group, p.name, p.value) for p in distribution("kanefe").entry_points}
    assert (point.group, point.name, point.value) in installed


def test_package_data_exists():
    for package, patterns in PROJECT["tool"]["setuptools"]["package-data"].items():
        folder = Path(import_module(package).__file__).parent
        for pattern in patterns:
            if pattern.endswith(".so"):  # in wheels alone
                continue
            assert list(folder.glob(pattern)), f"{package}: nothing matches {pattern}"


def test_every_folder_of_code_is_a_package():
    """Setuptools ships packages only, so a folder without __init__.py would be missing from the wheel."""
    for code in (ROOT / "kanefe", ROOT / "fem" / "kanefe_fem"):
        for path in code.rglob("*.py"):
            assert (path.parent / "__init__.py").exists(), f"{path.parent} has no __init__.py"


def tracked_files() -> list[str]:
    """Files under version control; empty outside a git checkout."""
    try:
        done = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, timeout=60)
    except FileNotFoundError:
        return []
    return done.stdout.split("\n")[:-1] if done.returncode == 0 else []


def test_the_top_level_is_tidy():
    paths = tracked_files()
    if not paths:
        pytest.skip("not a git checkout")
    folders = {path.split("/")[0] for path in paths if "/" in path}
    files = {path for path in paths if "/" not in path and not path.startswith(".")}
    assert folders <= FOLDERS, "move new folders below an existing one"
    assert files <= FILES


def test_plain_install_has_no_finite_element_package():
    """`pip install .` must work on Python 3.11-3.13 without any package that only an extra or Debian brings."""
    names = {re.match(r"[\w.-]+", requirement)[0].lower() for requirement in PROJECT["project"]["dependencies"]}
    assert not {"dolfinx-solver-real", "fenics-dolfinx", "petsc4py", "mpi4py", "gmsh"} & names
    assert PROJECT["project"]["requires-python"] == ">=3.11"
