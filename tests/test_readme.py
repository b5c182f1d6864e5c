"""The README's script runs as printed."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.mark.fenicsx
def test_the_first_script_runs(tmp_path, monkeypatch, capsys):
    (script,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), flags=re.DOTALL)
    (tmp_path / "meshes").symlink_to(ROOT / "meshes")
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    exec(compile(script, "README.md", "exec"), names)
    assert {path.name for path in tmp_path.iterdir()} >= {"energy.png", "arm.pvd", "run.h5"}
    printed = [float(x) for x in re.findall(r"-?\d+\.?\d*(?:e[+-]?\d+)?", capsys.readouterr().out)]
    # the arm has all but stopped shaking: its root carries the weight of arm and tip mass
    assert printed[2] == pytest.approx((6.5233 + 0.5) * 9.81, rel=0.1)
