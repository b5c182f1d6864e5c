"""The command line as a module."""

from __future__ import annotations

import subprocess
import sys

import kanefe


def test_python_m_is_the_command() -> None:
    done = subprocess.run([sys.executable, "-m", "kanefe", "version"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert kanefe.__version__ in done.stdout
