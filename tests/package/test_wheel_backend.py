"""The build backend hands on what the front end gives it: pip tells by PYTHONPATH where numpy and numba are."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from repository import ROOT


@pytest.fixture
def backend(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    found = importlib.util.spec_from_file_location("wheel_backend", ROOT / ".ci" / "wheel_backend.py")
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    monkeypatch.setattr(module, "IS_COMPILED", True)
    monkeypatch.setattr(module, "BUILT", Path("/nonexistent"))
    return module


@pytest.mark.parametrize("kernels", ["here", "all"])
def test_the_build_of_kernels_sees_what_pip_gives(
    backend: ModuleType, kernels: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    ran: list[tuple[list[str], dict[str, str]]] = []
    built: list[dict[str, Any]] = []
    monkeypatch.setenv("PYTHONPATH", "/overlay")
    monkeypatch.setattr(backend.subprocess, "run", lambda command, env, **rest: ran.append((command, env)))
    monkeypatch.setattr(backend.build_meta, "build_wheel", lambda folder, settings, metadata: built.append(settings))
    backend.build_wheel(str(tmp_path), {"kernels": kernels} if kernels == "all" else None)
    ((command, environment),) = ran
    assert environment["PYTHONPATH"].split(os.pathsep) == [str(ROOT), "/overlay"]
    assert command[-2:] == ["--wheel", kernels]
    assert "kernels" not in built[0]


def test_an_unknown_setting_is_refused(backend: ModuleType, tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match=r"kernels='every' is unknown.*here, all"):
        backend.build_wheel(str(tmp_path), {"kernels": "every"})
