"""The peers' process: it builds a scene once and is then asked for runs, so that ours can alternate with them.

The virtual environment of the peers, apart from ours: they want another numpy.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any, Self


class Peers:
    """A Python of the peers that answers requests, one line of JSON each.

    Parameters
    ----------
    python : Path
        Of their environment.
    server : Path
        The script that answers there.
    """

    def __init__(self, python: Path, server: Path) -> None:
        self._open = ExitStack()
        self._errors = self._open.enter_context(tempfile.TemporaryFile("w+"))  # noqa: SIM115  (closed by the stack)
        self._process = subprocess.Popen(
            [str(python), str(server)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            text=True,
            env=surroundings(),
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._process.stdin:
            self._process.stdin.close()
        if kind is not None:
            self._process.kill()
        self._process.wait()
        self._open.close()

    def ask(self, do: str, **request: Any) -> dict[str, Any]:
        """Return the answer to a request.

        Raises
        ------
        NoPeers
            If the process ended or answers with an error.
        """
        line = ""
        if self._process.stdin and self._process.stdout and self._process.poll() is None:
            self._process.stdin.write(json.dumps({"do": do, **request}) + "\n")
            self._process.stdin.flush()
            line = self._process.stdout.readline()
        if not line:
            self._errors.seek(0)
            raise NoPeers(f"the peers' process ended at {do!r}:\n{self._errors.read()[-800:]}")
        answer: dict[str, Any] = json.loads(line)
        if "error" in answer:
            raise NoPeers(f"the peers cannot {do}: {answer['error']}")
        return answer


PACKAGES = ("exudyn", "pin", "mujoco", "numpy", "scipy")


IMPORTS = "import exudyn, pinocchio, mujoco, numpy, scipy.sparse"


OF_MESHES = ("exudyn", "ngsolve", "numpy", "scipy")


IMPORTS_OF_MESHES = "import exudyn.FEM, ngsolve, netgen.read_gmsh, scipy.sparse.linalg"
"""Imports of the peers that make bodies from meshes, in a separate environment because NGSolve is large."""


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
