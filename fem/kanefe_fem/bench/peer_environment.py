"""The virtual environment of the peers, apart from ours: they want another numpy."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

PACKAGES = ("exudyn", "pin", "numpy", "scipy")
IMPORTS = "import exudyn, pinocchio, numpy, scipy.sparse"

OF_MESHES = ("exudyn", "ngsolve", "numpy", "scipy")
IMPORTS_OF_MESHES = "import exudyn.FEM, ngsolve, netgen.read_gmsh, scipy.sparse.linalg"
"""The peers that make bodies from meshes, in an environment of their own: NGSolve is large."""


class NoPeers(Exception):
    """The environment of the peers cannot be made; the message says why and what to do."""


def peer_python(folder: Path, packages: Sequence[str] = PACKAGES, imports: str = IMPORTS) -> Path:
    """Return the Python of an environment that has the peers; make what is missing.

    Parameters
    ----------
    folder : Path
        Of the environment.
    packages : sequence of str
        What is installed into it.
    imports : str
        A line of Python that shows that they are there.

    Raises
    ------
    NoPeers
        If a command fails, with its last lines.
    """
    python = folder / "bin" / "python"
    if python.exists() and _runs([str(python), "-c", imports]):
        return python
    print(f"making an environment for {', '.join(packages)} in {folder} (once)", file=sys.stderr, flush=True)
    if not python.exists():
        _run([sys.executable, "-m", "venv", str(folder)], "no virtual environment can be made there", packages)
    _run(
        [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *packages],
        "pip cannot install the peers (their wheels are for Linux x86_64; the index must be in reach)",
        packages,
    )
    _run([str(python), "-c", imports], "the peers are installed and cannot be imported", packages)
    return python


def surroundings() -> dict[str, str]:
    """Return the environment variables for the peers: without our import paths, which lead to our numpy."""
    kept = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PYTHONHOME")}
    return {**kept, "PYTHONNOUSERSITE": "1"}


def _runs(command: list[str]) -> bool:
    return subprocess.run(command, capture_output=True, env=surroundings(), check=False).returncode == 0


def _run(command: list[str], trouble: str, packages: Sequence[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", env=surroundings(), check=False)
    if done.returncode != 0:
        last = "\n".join((done.stderr or done.stdout).strip().splitlines()[-8:])
        raise NoPeers(
            f"{trouble}. Remedy: --env FOLDER of an environment that has {', '.join(packages)}, or an empty or new "
            f"folder\n{' '.join(command)}:\n{last}"
        )
