"""The README's first script runs as printed, what it links to is there, and it stays short."""

import re

import pytest

from repository import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")
(SCRIPT,) = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)


@pytest.mark.fenicsx
def test_the_first_script_runs(tmp_path, monkeypatch, capsys):
    (tmp_path / "meshes").symlink_to(ROOT / "meshes")
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    exec(compile(SCRIPT, "README.md", "exec"), names)
    assert {path.name for path in tmp_path.iterdir()} >= {"energy.png", "run.html", "run.h5"}
    force = re.findall(r"-?\d+\.?\d*(?:e[+-]?\d+)?", capsys.readouterr().out.split("[")[-1])
    # the arm has all but stopped shaking: its root carries the weight of arm and tip mass
    assert float(force[2]) == pytest.approx((6.5233 + 0.5) * 9.81, rel=0.1)


@pytest.mark.parametrize("link", sorted(set(re.findall(r"\]\(([^)#]+)", README))))
def test_links_lead_somewhere(link):
    assert (ROOT / link).exists()


def test_it_is_short():
    assert len(README.splitlines()) <= 150
