"""What started this process: mpirun of the same MPI, and the same versions on all processes."""

from __future__ import annotations

import platform
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

import kanefe
from kanefe.errors import ModelError
from kanefe.storage.digest import code_stamp, installed_versions

COUNTS = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE")
"""Environment variables in which Open MPI's and MPICH's launchers tell the number of processes."""

PACKAGES = ("numpy", "scipy", "fenics-dolfinx", "dolfinx-solver-real", "petsc4py", "slepc4py", "mpi4py")
"""Distributions that all processes need in one version."""


def check_launcher(size: int, environment: Mapping[str, str]) -> None:
    """Raise a ModelError if a launcher has started several processes, and MPI knows of one alone.

    Parameters
    ----------
    size : int
        Number of processes that MPI knows.
    environment : dict of str to str
    """
    started = next((environment[name] for name in COUNTS if name in environment), "1")
    if size == 1 and started.isdigit() and int(started) > 1:
        raise ModelError(
            f"mpirun has started {started} processes, but the MPI of this Python sees one: they belong to different "
            "installations. Remedy: the mpirun of the same (Debian's /usr/bin/mpirun for Debian's Python; bin/mpirun "
            "of the environment for kanefe[fenicsx])"
        )


@cache
def versions_here() -> dict[str, str]:
    """Return the versions of Python, of kanefe's own code and of packages."""
    code = code_stamp(Path(kanefe.__file__).parent, Path(__file__).parents[1])
    own = {"Python": platform.python_version(), "kanefe": f"{kanefe.__version__} ({code[:8]})"}
    return own | installed_versions(*PACKAGES)


def refuse_different(versions: Sequence[Mapping[str, str]], hosts: Sequence[str]) -> None:
    """Raise a ModelError if processes have other versions than the first; it names packages, processes and hosts.

    Parameters
    ----------
    versions : sequence of dict of str to str
        What `versions_here` returns on each process.
    hosts : sequence of str
    """
    for number, found in enumerate(versions):
        other = [name for name in sorted({*versions[0], *found}) if versions[0].get(name) != found.get(name)]
        if other:
            name = other[0]
            raise ModelError(
                f"process {number + 1} of {len(versions)}, on {hosts[number]}, has {name} "
                f"{found.get(name, 'not at all')}, the first, on {hosts[0]}, {versions[0].get(name, 'not at all')}"
                f"{f', and {len(other) - 1} more differ' if len(other) > 1 else ''}. Remedy: the same environment on "
                "all machines"
            )
