"""Meshes of imported solids, with groups by name, place and colour and sizes by group."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from kanefe.errors import MeshError
from kanefe.fe_model.shapes import measures
from kanefe_fem import _gmsh
from kanefe_fem.cad.estimate import from_triangles, refuse_if_too_large
from kanefe_fem.cad.shapes import Shapes, Solid
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh.sagitta import sagitta
from kanefe_fem.mesh.unfolded import unfolded

HXT, DELAUNAY = 10, 1
"""Numbers of the methods of gmsh for volumes, of which the first is ten times faster."""

MESH_ADAPT = 1
"""Number of the method of gmsh for faces that changes the triangles of others until they are good."""

LEAST_SIZE = 0.1
"""Smallest size of cells by curvature, relative to the smallest that is given: splines have sharp bends."""

_OF_FACE = re.compile(r"[Ss]urface (\d+)")


class Unmeshable(MeshError):
    """What a method of gmsh cannot mesh."""


@dataclass(frozen=True)
class Job:
    """What to mesh, and how.

    Attributes
    ----------
    tags : tuple of int
        Solids to mesh.
    sizes : dict of int to float
        Largest side of a cell by solid, m.
    face_sizes : dict of int to float
        The same by face, where it is smaller, m.
    faces : dict of str to tuple of int
        Groups of faces.
    per_turn : int
        Cells around a full turn of a curved face; zero: as the size asks.
    order : {1, 2}
    method : int
        Of gmsh for volumes; with the slower one faces are meshed by one that does not let triangles cross.
    is_middle : bool
        Whether the middle surface is meshed, of one solid.
    """

    tags: tuple[int, ...]
    sizes: Mapping[int, float]
    face_sizes: Mapping[int, float] = field(default_factory=dict)
    faces: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    per_turn: int = 0
    order: int = 1
    method: int = HXT
    is_middle: bool = False


def mesh_solids(gmsh: Any, shapes: Shapes, path: Path, job: Job, told: Callable[[str], None]) -> Mesh:
    """Mesh solids of the current model.

    Raises
    ------
    MeshError
        If gmsh cannot mesh a face, which is named, or if the mesh becomes too large for the memory.
    """
    solids = [solid for solid in shapes.solids if solid.tag in job.tags]
    left_out = [(3, solid.tag) for solid in shapes.solids if solid.tag not in job.tags]
    if left_out:
        gmsh.model.occ.remove(left_out, recursive=True)
        gmsh.model.occ.synchronize()
    _set_groups(gmsh, solids, job)
    set_sizes(gmsh, solids, job, shapes.scale)
    gmsh.option.setNumber("Mesh.Algorithm3D", job.method)
    if job.method != HXT:
        gmsh.option.setNumber("Mesh.Algorithm", MESH_ADAPT)
    generate_stage(gmsh, 1, "edges", shapes, path, told)
    generate_stage(gmsh, 2, "faces", shapes, path, told)
    _refuse_by_surfaces(gmsh, solids, job, path)
    generate_stage(gmsh, 3, "solids", shapes, path, told)
    for solid in solids:  # newer versions of the faster method give up without an error
        if not any(len(ids) for ids in gmsh.model.mesh.getElements(3, solid.tag)[1]):
            raise Unmeshable(
                f"{path.name}: gmsh left the solid {solid.name!r} without cells, as where triangles of its faces "
                "cross. Remedy: another size; or remove slivers and faces that cross where the part was made"
            )
    told("second order" if job.order == 2 else "groups")
    _gmsh.generate(gmsh, job.order)
    mesh = _gmsh.extract(gmsh, path)
    if mesh.order == 2:
        mesh = unfolded(mesh)
        bow = 0.0
    else:
        bow = sagitta(gmsh) * shapes.scale
    return replace(mesh, nodes=np.array(mesh.nodes) * shapes.scale, sagitta=bow)


def _set_groups(gmsh: Any, solids: list[Solid], job: Job) -> None:
    for solid in solids:
        gmsh.model.setPhysicalName(3, gmsh.model.addPhysicalGroup(3, [solid.tag]), solid.name)
    for name, tags in job.faces.items():
        gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, list(tags)), name)


def set_sizes(gmsh: Any, solids: list[Solid], job: Job, scale: float) -> None:
    """Set the largest size, and fields that make it smaller in solids, on faces and on their edges."""
    largest = max(job.sizes[solid.tag] for solid in solids)
    gmsh.option.setNumber("Mesh.CharacteristicLengthMax", largest / scale)
    least = LEAST_SIZE * min([*job.sizes.values(), *job.face_sizes.values()])
    gmsh.option.setNumber("Mesh.CharacteristicLengthMin", least / scale if job.per_turn else 0.0)
    _gmsh.set_per_turn(gmsh, job.per_turn)
    fields = []
    for size in sorted({*job.sizes.values(), *job.face_sizes.values()}):
        inside = [solid.tag for solid in solids if job.sizes[solid.tag] == size]
        own = {tag for tag, each in job.face_sizes.items() if each == size}
        faces = [f.tag for solid in solids for f in solid.faces if solid.tag in inside or f.tag in own]
        if size >= largest or not faces:
            continue
        edges = {tag for _, tag in gmsh.model.getBoundary([(2, tag) for tag in faces], combined=False, oriented=False)}
        fields.append(_restricted(gmsh, size / scale, inside, faces, sorted(edges)))
    if fields:
        least = gmsh.model.mesh.field.add("Min")
        gmsh.model.mesh.field.setNumbers(least, "FieldsList", fields)
        gmsh.model.mesh.field.setAsBackgroundMesh(least)


def _restricted(gmsh: Any, size: float, solids: list[int], faces: list[int], edges: list[int]) -> int:
    """Return a field of one size on some entities."""
    field_of = gmsh.model.mesh.field
    constant = field_of.add("MathEval")
    field_of.setString(constant, "F", f"{size:.17g}")
    restricted = field_of.add("Restrict")
    field_of.setNumber(restricted, "IField", constant)
    field_of.setNumbers(restricted, "VolumesList", solids)
    field_of.setNumbers(restricted, "SurfacesList", faces)
    field_of.setNumbers(restricted, "CurvesList", edges)
    return int(restricted)


def generate_stage(
    gmsh: Any, dimension: int, what: str, shapes: Shapes, path: Path, told: Callable[[str], None]
) -> None:
    """Mesh all entities of a dimension."""
    told(f"meshing {what}")
    gmsh.logger.stop()
    gmsh.logger.start()
    try:
        gmsh.model.mesh.generate(dimension)
    except Exception as problem:  # gmsh raises bare Exception
        said = "; ".join(m for m in gmsh.logger.get() if m.startswith("Error")) or str(problem)
        raise Unmeshable(
            f"{path.name}: gmsh cannot mesh {what}: {said}.{_place_of(said, shapes)} Remedy: another size; or remove "
            "the detail where the part was made: a face that crosses itself or a neighbour, or a sliver"
        ) from problem


def _place_of(said: str, shapes: Shapes) -> str:
    """Return where the face is that a message of gmsh names by its number."""
    match = _OF_FACE.search(said)
    for solid in shapes.solids:
        for face in solid.faces:
            if match and face.tag == int(match[1]):
                at = ", ".join(f"{one:.4g}" for one in face.centre)
                return f" The face is at ({at}) m, of {solid.name!r}, with an area of {face.area:.3g} m^2."
    return ""


def _refuse_by_surfaces(gmsh: Any, solids: list[Solid], job: Job, path: Path) -> None:
    """Refuse solids whose surfaces have too many triangles already: details are finer than the size."""
    counts, sides = [], []
    for solid in solids:
        count = sum(len(ids) for face in solid.faces for ids in gmsh.model.mesh.getElements(2, face.tag)[1])
        counts.append(float(max(count, 1)))
        sides.append(float(np.sqrt(4.0 / np.sqrt(3.0) * solid.area / max(count, 1))))
    found = from_triangles([solid.volume for solid in solids], counts, sides, job.order)
    refuse_if_too_large(found, list(job.sizes.values()), f"{path.name}, after its faces were meshed")


def volumes_of(mesh: Mesh) -> dict[str, float]:
    """Return the volume of each group of cells of a mesh, m^3."""
    return {
        name: sum(float(measures(b.kind, mesh.nodes[b.nodes])[0].sum()) for b in blocks)
        for name, blocks in mesh.cells.items()
    }
