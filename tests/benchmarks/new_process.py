"""Processes of their own, to be timed: what they print, or their last lines where they fail."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

TESTS = Path(__file__).resolve().parents[1]


class BrokenProcess(Exception):
    """A process that was to be timed failed."""


def completed(*arguments: str, **surroundings: str) -> subprocess.CompletedProcess[str]:
    """Run Python in a new process that finds the benchmarks and the helpers of the tests.

    Raises
    ------
    BrokenProcess
        If it fails, with its last lines.
    """
    path = os.pathsep.join([str(TESTS), str(TESTS / "shared"), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "PYTHONPATH": path, **surroundings}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # an installed package has its bytecode: sources take three times
    done = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, env=environment, check=False)
    if done.returncode != 0:
        lines = done.stderr.strip().splitlines() or [f"status {done.returncode}"]
        raise BrokenProcess("\n".join([f"a new process failed: {lines[-1]}", *lines[-12:-1]]))
    return done


def answer_of(module: str, *arguments: object, **surroundings: str) -> dict[str, Any]:
    """Return the JSON that a module of the benchmarks prints last."""
    done = completed("-m", f"benchmarks.{module}", *map(str, arguments), **surroundings)
    answer: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return answer
