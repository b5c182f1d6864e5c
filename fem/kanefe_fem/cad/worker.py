"""What the process of `kanefe_fem.machine.own_process` does with CAD files: gmsh, and one file that is open in it."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from kanefe_fem import _gmsh
from kanefe_fem.cad.import_shapes import import_shapes, join_touching, survey
from kanefe_fem.cad.mesher import Job, mesh_solids
from kanefe_fem.cad.middle import mesh_middle
from kanefe_fem.cad.relations import Surface, common_volume, surfaces_of
from kanefe_fem.cad.shapes import Shapes
from kanefe_fem.mesh.mesh import Mesh

Told = Callable[[str], None]


@dataclass
class State:
    """The session of gmsh, and what is open in it."""

    gmsh: Any
    shapes: Shapes | None = None
    path: Path = Path()


@contextlib.contextmanager
def opened() -> Iterator[State]:
    """Yield a session of gmsh."""
    with _gmsh.session() as gmsh:
        yield State(gmsh)


def read(state: State, path: Path, scale: float, unit: str, joined: bool, told: Told) -> Shapes:
    """Import a file, and return what is in it."""
    told("reading")
    state.gmsh.clear()
    state.gmsh.model.add("part")
    healed = import_shapes(state.gmsh, path)
    if joined:
        told("joining its parts")
        join_touching(state.gmsh, path)
    told("looking at its faces")
    state.shapes, state.path = survey(state.gmsh, path, scale, unit, healed), path
    return state.shapes


def mesh(state: State, job: Job, told: Told) -> dict[str, Any]:
    """Mesh solids of the file that was read, or the middle surface of one; return the fields of the mesh."""
    if state.shapes is None:
        raise RuntimeError("no file was read before it is meshed")
    make = mesh_middle if job.is_middle else mesh_solids
    found = make(state.gmsh, state.shapes, state.path, job, told)
    # mappings that cannot be written to do not go through pipes
    plain = {one.name: getattr(found, one.name) for one in fields(Mesh)}
    return {name: dict(value) if hasattr(value, "items") else value for name, value in plain.items()}


def overlaps(state: State, pairs: list[tuple[int, int]], told: Told) -> list[float | None]:
    """Return the common volume of pairs of solids, mm^3; None where OpenCASCADE cannot tell."""
    found = []
    for i, (a, b) in enumerate(pairs):
        told(f"looking for overlaps, {i + 1} of {len(pairs)}")
        found.append(common_volume(state.gmsh, a, b))
    return found


def surfaces(state: State, size: float, told: Told) -> dict[int, Surface]:
    """Return the surface of each solid, with sides of at most a size in mm."""
    told("meshing faces")
    return surfaces_of(state.gmsh, size)
