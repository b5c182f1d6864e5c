"""The packages that kanefe can use: which are installed, which cannot be imported, and what each is for."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Literal

State = Literal["works", "missing", "broken"]

IMPORTING = """
import gc, importlib, json, os, sys
gc.disable()
for name in sys.argv[1:]:
    what, found = "", ""
    try:
        if name == "dolfinx":
            try:  # the newest dolfinx brings its own MPI, which must be loaded first
                importlib.import_module("dolfinx_solver")
            except ModuleNotFoundError:
                pass
        found = str(getattr(importlib.import_module(name), "__version__", ""))
    except BaseException as error:
        missing = isinstance(error, ModuleNotFoundError) and error.name == name.partition(".")[0]
        what = "missing" if missing else type(error).__name__ + ": " + str(error)
    print("\\n" + json.dumps([name, what, found]), flush=True)
os._exit(0)
"""
"""Program of the process that imports packages, so that a crash ends only that process. It skips garbage collection and
the teardown of modules, which would take a third of its time."""

LONGEST = 120.0
"""Time after which an import counts as hanging, s."""


@dataclass(frozen=True)
class Dependency:
    """A package that kanefe can use.

    Attributes
    ----------
    module : str
        Name for import.
    distribution : str
        Name for pip.
    brings : str
        What kanefe uses it for.
    command : str
        Command that installs it.
    is_needed : bool
        Whether kanefe requires it.
    """

    module: str
    distribution: str
    brings: str
    command: str
    is_needed: bool = False


def _extra(name: str) -> str:
    return f"pip install 'kanefe[{name}]'"


_ALWAYS = "pip install kanefe"
_SEA, _STUDY, _REPORT = _extra("sea"), _extra("study"), _extra("report")

PARTS = (
    Dependency("numpy", "numpy", "arrays", _ALWAYS, True),
    Dependency("scipy", "scipy", "sparse matrices, solvers", _ALWAYS, True),
    Dependency("h5py", "h5py", "files of results", _ALWAYS, True),
    Dependency("matplotlib", "matplotlib", "plots", _ALWAYS, True),
    Dependency("meshio", "meshio", "meshes of MED, VTK and other formats", _ALWAYS, True),
    Dependency("pyevtk", "pyevtk", "files for ParaView", _ALWAYS, True),
    Dependency(
        "dolfinx", "fenics-dolfinx", "bodies from meshes", "apt-get install python3-dolfinx, or " + _extra("fenicsx")
    ),
    Dependency("gmsh", "gmsh", "meshes, and sources of them", "apt-get install python3-gmsh, or pip install gmsh"),
    Dependency("OCP", "cadquery-ocp-novtk", "names of faces in STEP files", _extra("cad")),
    Dependency(
        "numba", "numba", "kernels where no wheel brought them, compiled functions of one's own", _extra("compile")
    ),
    Dependency("pyvista", "pyvista", "pictures of modes and stresses", _REPORT),
    Dependency("control", "control", "state spaces for python-control", _extra("control")),
    Dependency("sksundae", "scikit-sundae", "CVODE of SUNDIALS", _extra("sundials")),
    Dependency("xarray", "xarray", "motions of ships from netCDF", _SEA),
    Dependency("h5netcdf", "h5netcdf", "motions of ships from netCDF", _SEA),
    Dependency("wavespectra", "wavespectra", "measured seas", _SEA),
    Dependency("distributed", "distributed", "studies on a Dask cluster", _STUDY),
    Dependency("pandas", "pandas", "tables of studies as DataFrames", _STUDY),
    Dependency("rainflow", "rainflow", "cycles of stress histories", _extra("fatigue")),
    Dependency("pyyeti", "pyyeti", "op2 files of Nastran", _extra("nastran")),
    Dependency("mapdl_archive", "mapdl-archive", "nodes of Ansys", _extra("ansys")),
    Dependency("yourdfpy", "yourdfpy", "robots of URDF files", _extra("robots")),
    Dependency("mujoco", "mujoco", "robots of MJCF files", _extra("robots")),
)

APART = {"dolfinx", "gmsh", "OCP"}
"""Packages imported in a separate process, because their libraries must not meet those of other packages."""

COMPILER = Dependency(
    "cc", "cc", "kernels, forms of dolfinx, where they are not built yet", "apt-get install gcc libc6-dev"
)


@dataclass(frozen=True)
class Found:
    """State of a part.

    Attributes
    ----------
    part : Dependency
    state : "works", "missing" or "broken"
    version : str
        Empty if it is missing or unknown.
    trouble : str
        The error, if it is broken.
    """

    part: Dependency
    state: State
    version: str = ""
    trouble: str = ""

    @property
    def is_fault(self) -> bool:
        """Whether it is broken, or missing although required."""
        return self.state == "broken" or (self.state == "missing" and self.part.is_needed)


class Search:
    """Imports of all parts, in separate processes that run beside other work.

    Parameters
    ----------
    parts : sequence of Dependency
    """

    def __init__(self, parts: Sequence[Dependency] = PARTS) -> None:
        self._parts = parts
        names = [part.module for part in parts]
        groups = [n for n in names if n in APART], [n for n in names if n not in APART]
        self._running = [(group, _start(group)) for group in groups if group]

    def results(self) -> list[Found]:
        """Wait for the processes and return the state of each part in order, the compiler last."""
        found: dict[str, tuple[str, str]] = {}
        for group, process in self._running:
            found |= _collected(group, process)
        return [_found(part, *found[part.module]) for part in self._parts] + [_compiler()]


def _start(names: Iterable[str]) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", IMPORTING, *names],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
        env={"MPLBACKEND": "agg", **os.environ},
    )


def _collected(names: list[str], process: subprocess.Popen[str]) -> dict[str, tuple[str, str]]:
    """Return trouble and version of each package; packages that end the process are reported, the rest tried again."""
    reports: dict[str, tuple[str, str]] = {}
    left = names
    while left:
        try:
            out, errors = process.communicate(timeout=LONGEST)
            message = errors.strip().splitlines()[-1:] or "without a message"
            end = f"ended its process with {process.returncode}: {message}"
        except subprocess.TimeoutExpired:
            process.kill()
            out, errors = process.communicate()
            end = f"hung for {LONGEST:g} s"
        for line in out.splitlines():
            if line.startswith('["'):
                name, what, found = json.loads(line)
                reports[name] = what, found
        left = [name for name in left if name not in reports]
        if left:
            reports[left.pop(0)] = end, ""
            process = _start(left)
    process.communicate()
    return reports


def _found(part: Dependency, trouble: str, number: str) -> Found:
    if trouble == "missing":
        return Found(part, "missing")
    for name in (part.distribution, part.module):
        try:
            number = number or version(name)
        except PackageNotFoundError:
            continue
    return Found(part, "broken" if trouble else "works", number, " ".join(trouble.split()))


def _compiler() -> Found:
    name = os.environ.get("CC", "cc")
    if shutil.which(name) is None:
        return Found(COMPILER, "missing")
    done = subprocess.run([name, "--version"], capture_output=True, text=True, errors="replace", check=False)
    if done.returncode:
        return Found(COMPILER, "broken", "", f"{name} --version ends with {done.returncode}")
    return Found(COMPILER, "works", done.stdout.splitlines()[0] if done.stdout else "")
