"""The demo: where it cannot write, it says so before anything is computed."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import kanefe as kf
from kanefe_fem import demo, ship_demo
from kanefe_fem.sramss.spatial import SHOES


def test_the_ship_has_a_gear_of_its_own(tmp_path: Path) -> None:
    with pytest.raises(kf.ModelError, match="no meaning with --ship"):
        demo.demo(demo.ArmKind.beam, None, tmp_path, ship=True)


def test_a_passage_of_some_seconds_tells_what_slips(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.setattr(ship_demo, "SPAN", 6.0)
    monkeypatch.setattr(ship_demo, "RISE", 3.0)
    demo.demo(demo.ArmKind.solid, None, tmp_path, ship=True)
    said = capsys.readouterr().out
    assert "times real time" in said
    assert "largest pull of a lashing" in said
    assert {path.name for path in tmp_path.iterdir()} >= {"ship_loose.png", "ship_lashed.png", "ship.pvd", "ship.html"}


def test_the_shoe_that_slips_first_is_told_by_time(capsys) -> None:
    shoe = SimpleNamespace(slip=np.zeros(1), normal=np.zeros(1))
    times = {f"{name} slip": np.array([20.0 - i]) for i, name in enumerate(SHOES[:-1])} | {f"{SHOES[-1]} slip": []}
    run = SimpleNamespace(contact=lambda name: shoe, events=times, statistics={"seconds": 1.0, "steps": 1})
    ship_demo._print_run("loose", run)
    assert f"first: {SHOES[-2]} at {20 - len(SHOES) + 2:.1f} s" in capsys.readouterr().out
    run.events = {name: [] for name in times}
    ship_demo._print_run("loose", run)
    assert "first: never" in capsys.readouterr().out


def test_a_folder_that_cannot_be_made_is_refused_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def build(*arguments: object) -> None:
        raise AssertionError("the arm was built before")

    monkeypatch.setattr(demo, "beam_arm", build)
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(kf.FileError, match=r"cannot make the folder .*out.* Remedy: --out another one"):
        demo.demo(demo.ArmKind.beam, None, tmp_path / "file" / "out")
    monkeypatch.setattr(demo.os, "access", lambda *arguments: False)
    with pytest.raises(kf.FileError, match=r"cannot write to the folder .* Remedy: --out another one"):
        demo.demo(demo.ArmKind.beam, None, tmp_path)
