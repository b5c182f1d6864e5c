"""The page of recipes for coding assistants: its snippets run, it is short, and the command prints it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from kanefe.skill import recipes
from repository import ROOT

sys.path.insert(0, str(ROOT / "docs" / "_ext"))
from page_snippets import snippets_of

MOST_LINES = 250
"""Largest number of lines of the page: what reads it reads all of it."""


def test_all_snippets_run_in_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("dolfinx", reason="a recipe meshes a solid")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    snippets = snippets_of(recipes())
    assert len(snippets) > 10
    for snippet in snippets:
        exec(compile(snippet["code"], "recipes.md", "exec"), names)
    assert (tmp_path / "run.html").stat().st_size > 1000


def test_the_page_is_short_and_printed() -> None:
    assert len(recipes().splitlines()) <= MOST_LINES
    done = subprocess.run([sys.executable, "-m", "kanefe", "skill"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == recipes().strip()
