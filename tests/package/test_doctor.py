"""`kanefe doctor`: what is there, what is broken, the kernels, the caches, and routes that agree."""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

import kanefe as kf
from kanefe.doctor import examination, routes
from kanefe.doctor.examination import Examination
from kanefe.doctor.parts import PARTS, Dependency, Found, Search
from kanefe.doctor.stores import BuiltKernels, kernels, stores
from repository import ROOT, surroundings


def part(module: str, is_needed: bool = False) -> Dependency:
    return Dependency(module, module, "something", "pip install it", is_needed)


def test_packages_that_work_are_missing_or_broken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "sound_one.py").write_text("__version__ = '1.5'")
    (tmp_path / "fails.py").write_text("raise OSError('no library\\n of that name')")
    (tmp_path / "lacks.py").write_text("import not_there_at_all")
    (tmp_path / "crashes.py").write_text("import os; os._exit(9)")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    names = "fails", "crashes", "not_there_at_all", "lacks", "sound_one"
    found = {f.part.module: f for f in Search([part(name, name.startswith("not")) for name in names]).results()}
    assert [found[name].state for name in names] == ["broken", "broken", "missing", "broken", "works"]
    assert found["fails"].trouble == "OSError: no library of that name"
    assert "ended its process with 9" in found["crashes"].trouble
    assert "not_there_at_all" in found["lacks"].trouble
    assert found["sound_one"].version == "1.5"
    assert [name for name in names if found[name].is_fault] == ["fails", "crashes", "not_there_at_all", "lacks"]
    assert "cc" in found


def test_every_extra_is_told() -> None:
    """What pyproject offers as extras is among the parts, by the command that installs it."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    commands = " ".join(part.command for part in PARTS)
    for extra in set(project["optional-dependencies"]) - {"test", "docs", "dev"}:
        assert f"kanefe[{extra}]" in commands


def test_all_routes_agree() -> None:
    done = list(routes.solves())
    assert [solve.trouble for solve in done] == [""] * 6
    assert {solve.against for solve in done} == {"", "literal", "all modes"}
    assert not any(solve.is_fault for solve in done)


def test_a_route_that_differs_or_fails_is_a_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    def steps(scene: kf.System) -> object:
        if len(scene._entries) == 2:
            return 1.0 + 1e-6 * routes._by_literal_steps(scene.freeze())
        raise kf.SimulationError("no")

    monkeypatch.setattr(routes, "_by_compiled_steps", steps)
    faults = [solve.is_fault for solve in routes.solves()]
    assert faults == [False, True, False, True, False, False]


def test_kernels_and_stores_are_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = kernels()
    assert 0 <= found.built <= found.count
    assert found.count > 20
    monkeypatch.setenv("KANEFE_CACHE_DIR", str(tmp_path))
    (tmp_path / "bodies").mkdir()
    (tmp_path / "bodies" / "x.npz").write_bytes(b"12345")
    of_kernels, of_bodies = stores()
    assert (of_kernels.files, of_bodies.files, of_bodies.size) == (0, 1, 5)
    assert of_bodies.can_be_written


USED = """
from kanefe.doctor import routes
from kanefe.kernels.compiler import compiled_functions as units
assert not any(solve.is_fault for solve in routes.solves())
print(*sorted(name.rpartition("-")[0] for name in units._libraries))
"""


def test_the_libraries_of_the_solves_are_known() -> None:
    done = subprocess.run([sys.executable, "-c", USED], capture_output=True, text=True, check=True, env=surroundings())
    assert done.stdout.split() == sorted(routes.NEEDED)


@pytest.mark.parametrize("name", sorted(routes.NEEDED))
def test_no_solve_builds_what_is_missing(name: str, capsys: pytest.CaptureFixture) -> None:
    assert list(routes.solves([name])) == []
    there = BuiltKernels(29, 28, 0, True, (name,))
    examination._print_solves(Examination([Found(part("numba"), "works")], there, [], [], 1.0), sys.stdout)
    assert "none: the kernels are not built. Remedy: kanefe prepare" in capsys.readouterr().out


class NoSearch:
    """A search that has been done, and found numba."""

    def results(self) -> list[Found]:
        return [Found(part("numba"), "works")]


def examined(monkeypatch: pytest.MonkeyPatch, built: int, **of: object) -> None:
    monkeypatch.setattr(examination, "Search", NoSearch)
    missing = tuple(sorted(routes.NEEDED)) if built < 52 else ()
    kernels_there = BuiltKernels(52, built, 0, bool(of.get("is_on", True)), missing)
    monkeypatch.setattr(examination, "kernels", lambda: kernels_there)
    monkeypatch.setattr(examination, "solves", lambda missing: iter(() if missing else of.get("solves", ())))


def test_unbuilt_kernels_are_told_and_not_built(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> None:
    examined(monkeypatch, 51)
    assert examination.doctor() == 0
    page = capsys.readouterr().out
    assert "51 of 52 libraries built for this processor" in page
    assert "none: the kernels are not built. Remedy: kanefe prepare" in page
    assert "no faults" in page


def test_unbuilt_kernels_without_numba_are_a_fault(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    examined(monkeypatch, 51)
    monkeypatch.setattr(NoSearch, "results", lambda self: [Found(part("numba"), "missing")])
    assert examination.doctor() == 1
    assert "numba, which builds them, does not work. Remedy: pip install 'kanefe[compile]'" in capsys.readouterr().out


def test_kernels_as_plain_python_are_told(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> None:
    examined(monkeypatch, 0, is_on=False)
    assert examination.doctor() == 0
    assert "KANEFE_JIT=0: they run as plain Python" in capsys.readouterr().out


def test_a_cache_that_is_a_file_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "cache").touch()
    monkeypatch.setenv("KANEFE_CACHE_DIR", str(tmp_path / "cache"))
    assert [store.can_be_written for store in stores()] == [False, False]


def test_a_fault_ends_in_exit_code_1_and_in_json(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    sound = routes.Solve("literal", "pendulum", 0.1)
    wrong = replace(sound, route="compiled", difference=0.5, limit=1e-10, against="literal")
    examined(monkeypatch, 52, solves=[sound, wrong])
    path = tmp_path / "found.json"
    assert examination.doctor(str(path)) == 1
    told = json.loads(path.read_text(encoding="utf-8"))
    (fault,) = told["faults"]
    assert fault == "the route 'compiled' of 'pendulum' differs from literal by 5.0e-01, at most 1e-10 was expected"
    assert [solve["difference"] for solve in told["solves"]] == [None, 0.5]
    assert "1 fault, in" in capsys.readouterr().out


def test_json_that_cannot_be_written_is_refused_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(examination, "Search", lambda: pytest.fail("too late"))
    with pytest.raises(kf.FileError, match="there is no folder"):
        examination.doctor(str(tmp_path / "nowhere" / "found.json"))


def test_the_command_runs_and_writes_json_alone_to_standard_output() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "kanefe", "doctor", "--json", "-"],
        capture_output=True,
        text=True,
        timeout=200,
        env=surroundings(),
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["faults"] == []
    assert "packages" in done.stderr
