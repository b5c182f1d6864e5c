"""`kanefe new --step`: the script of an assembly runs as it stands, and with the joints that its user takes."""

from __future__ import annotations

import runpy
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from kanefe.errors import FileError, MissingDependency
from kanefe.new_project import project
from step_files import hinge, write_step

pytestmark = pytest.mark.gmsh


@pytest.fixture
def plugin(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the plugin be found, however this checkout was installed."""
    found = EntryPoint("step", "kanefe_fem.assemblies.script:step_project", project.PROJECTS)
    monkeypatch.setattr(project, "entry_points", lambda **_: (found,))


def test_the_script_runs_and_tells_what_was_found(plugin, tmp_path, capsys):
    step = write_step(tmp_path / "hinge.step", hinge, names=("fork", "arm", "pin"))
    copy, script = project.new_project(str(tmp_path / "press"), str(step))
    assert copy.read_bytes() == step.read_bytes()
    text = script.read_text()
    assert "    # 'pin in arm': 'revolute',  # likely: a shaft of radius 4 mm in a hole, no play" in text
    assert "GROUND = 'arm'" in text  # the largest
    runpy.run_path(str(script), run_name="__main__")
    said = capsys.readouterr().out
    assert "left out, because no joint that is taken reaches them: fork, pin" in said
    assert "nothing moves: take joints in JOINTS" in said
    taken = text.replace("GROUND = 'arm'", "GROUND = 'fork'")
    taken = taken.replace("# 'pin in fork': 'revolute'", "'pin in fork': 'fixed'")
    script.write_text(taken.replace("# 'pin in arm'", "'pin in arm'"))
    runpy.run_path(str(script), run_name="__main__")
    assert "left out" not in capsys.readouterr().out
    assert (script.parent / "run.html").stat().st_size > 1e5


def test_what_cannot_be_read_leaves_no_folder(plugin, tmp_path):
    with pytest.raises(FileError, match=r"nothing\.step"):
        project.new_project(str(tmp_path / "press"), str(tmp_path / "nothing.step"))
    assert not (tmp_path / "press").exists()


def test_without_the_plugin_the_remedy_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(project, "entry_points", lambda **_: ())
    with pytest.raises(MissingDependency, match="kanefe new --step needs kanefe_fem"):
        project.new_project(str(tmp_path / "press"), "part.step")
    assert list(Path(tmp_path).iterdir()) == []
