"""The demo: where it cannot write, it says so before anything is computed."""

from __future__ import annotations

from pathlib import Path

import pytest

import kanefe as kf
from kanefe_fem import demo


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
