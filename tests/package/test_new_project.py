"""`kanefe new`: a folder whose script runs as it stands, with a mesh and without; what cannot be made is refused."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import kanefe as kf
from kanefe.new_project.project import new_project
from repository import surroundings

# A finder that refuses gmsh, as where it is not installed.
WITHOUT_GMSH = """
import runpy, sys

class NoGmsh:
    def find_spec(self, name, path=None, target=None):
        if name == "gmsh":
            raise ModuleNotFoundError("No module named 'gmsh'", name="gmsh")

sys.meta_path.insert(0, NoGmsh())
sys.path.insert(0, ".")
runpy.run_path("run.py", run_name="__main__")
"""


def run(folder: Path, *command: str) -> str:
    done = subprocess.run(
        [sys.executable, *command], cwd=folder, capture_output=True, text=True, timeout=300, env=surroundings()
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def lowest_point(text: str) -> float:
    """Return what the script tells of the tip, in mm."""
    (line,) = (line for line in text.splitlines() if line.startswith("lowest point of the tip"))
    return float(line.split()[-2])


def test_the_project_is_the_template_with_its_name(tmp_path: Path) -> None:
    written = new_project(str(tmp_path / "wobble-2"))
    assert [path.name for path in written] == ["README.md", "mesh.py", "run.py"]
    for path in written:
        text = path.read_text(encoding="utf-8")
        assert "wobble-2" in text
        assert "PROJECT" not in text
        if path.suffix == ".py":
            compile(text, path.name, "exec")


@pytest.mark.fenicsx
@pytest.mark.gmsh
def test_the_script_runs_with_and_without_a_mesh(tmp_path: Path) -> None:
    folder = new_project(str(tmp_path / "wobble"))[0].parent
    from_mesh, from_beams = run(folder, "run.py"), run(folder, "-c", WITHOUT_GMSH)
    assert "pip install gmsh" in from_beams or "kanefe[fenicsx]" in from_beams
    assert "made of beam elements" not in from_mesh
    assert {path.name for path in (folder / "out").iterdir()} >= {"overview.png", "run.html", "arm.pvd", "run.h5"}
    # the beam has no hole and one width: an eighth softer or stiffer, and not another arm
    assert lowest_point(from_mesh) == pytest.approx(lowest_point(from_beams), rel=0.25)
    assert lowest_point(from_mesh) < -0.5


@pytest.mark.gmsh
def test_without_a_display_the_mesh_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", "")
    folder = new_project(str(tmp_path / "wobble"))[0].parent
    assert "no window here: the mesh is in mesh.msh" in run(folder, "mesh.py")
    assert (folder / "mesh.msh").stat().st_size > 1000


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("a b", "'a b' is not a name of a project. Remedy: letters"),
        ("-x", "'-x' is not a name"),
        ("", "'' is not a name"),
        ("numpy", "would hide the Python package"),
        ("nowhere/project1", "there is no folder .*nowhere"),
        ("there", "there is a folder .*there already"),
        ("file", "there is a file .*file already"),
        ("file/project1", "cannot make .*project1: Not a directory"),
    ],
)
def test_what_cannot_be_made_is_refused(name: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "file").touch()
    with pytest.raises(kf.KanefeError, match=message):
        new_project(f"{tmp_path}/{name}" if name else "")
    assert not list((tmp_path / "there").iterdir())


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="a folder in which none is made is Linux's")
def test_where_the_system_makes_no_folders_it_says_so() -> None:
    with pytest.raises(kf.FileError, match="cannot make /proc/project1: nothing can be made there"):
        new_project("/proc/project1")


def test_the_command_says_what_is_next(tmp_path: Path) -> None:
    told = run(tmp_path, "-m", "kanefe", "new", "wobble")
    assert told.splitlines() == ["made wobble with README.md, mesh.py, run.py", "next: cd wobble && python run.py"]
