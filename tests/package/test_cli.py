"""The command line as a module."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import kanefe
from player_pages import body_of, read_page
from result_scenes import pendulum


def test_python_m_is_the_command() -> None:
    done = subprocess.run([sys.executable, "-m", "kanefe", "version"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert kanefe.__version__ in done.stdout


def test_view_writes_the_page_of_a_saved_run(tmp_path: Path) -> None:
    pendulum().save(tmp_path / "run.h5", forces=False)
    command = [sys.executable, "-m", "kanefe", "view", str(tmp_path / "run.h5"), "--to", str(tmp_path / "run.html")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"written: {tmp_path / 'run.html'}\n"
    assert body_of(read_page((tmp_path / "run.html").read_text(encoding="utf-8")), "rod")["kind"] == "rigid"
