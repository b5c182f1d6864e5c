"""The virtual environment of the peers, apart from ours: they want another numpy."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

PACKAGES = ("exudyn", "pin", "numpy", "scipy")
IMPORTS = "import exudyn, pinocchio, numpy, scipy.sparse"


class NoPeers(Exception):
    """The environment of the peers cannot be made; the message says why and what to do."""


def peer_python(folder: Path) -> Path:
    """Return the Python of an environment that has the peers; make what is missing.

    Parameters
    ----------
    folder : Path
        Of the environment.

    Raises
    ------
    NoPeers
        If a command fails, with its last lines.
    """
    python = folder / "bin" / "python"
    if python.exists() and _runs([str(python), "-c", IMPORTS]):
        return python
    print(f"making an environment for {', '.join(PACKAGES)} in {folder} (once)", file=sys.stderr, flush=True)
    if not python.exists():
        _run([sys.executable, "-m", "venv", str(folder)], "no virtual environment can be made there")
    _run(
        [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *PACKAGES],
        "pip cannot install the peers (wheels of both are for Linux x86_64; the index must be in reach)",
    )
    _run([str(python), "-c", IMPORTS], "the peers are installed and cannot be imported")
    return python


def surroundings() -> dict[str, str]:
    """Return the environment variables for the peers: without our import paths, which lead to our numpy."""
    kept = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PYTHONHOME")}
    return {**kept, "PYTHONNOUSERSITE": "1"}


def _runs(command: list[str]) -> bool:
    return subprocess.run(command, capture_output=True, env=surroundings(), check=False).returncode == 0


def _run(command: list[str], trouble: str) -> None:
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", env=surroundings(), check=False)
    if done.returncode != 0:
        last = "\n".join((done.stderr or done.stdout).strip().splitlines()[-8:])
        raise NoPeers(
            f"{trouble}. Remedy: --env FOLDER of an environment that has {', '.join(PACKAGES)}, or an empty or new "
            f"folder\n{' '.join(command)}:\n{last}"
        )
