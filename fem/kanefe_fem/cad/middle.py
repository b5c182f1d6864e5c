"""The middle surface of a thin solid as a mesh: one side of it is meshed, and its nodes move half the thickness."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from kanefe.errors import MeshError
from kanefe.fe_model.shapes import MIDS, measures, shape
from kanefe_fem import _gmsh
from kanefe_fem.cad.mesher import HXT, MESH_ADAPT, Job, generate_stage, set_sizes
from kanefe_fem.cad.shapes import Face, Shapes, Solid
from kanefe_fem.cad.sheets import EVEN, REMEDY, Borders, Probe, Sheet, depth, outward, sheet_of
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh.sagitta import sagitta
from kanefe_fem.mesh.unfolded import unfolded

ENOUGH = 9
"""Number of points within a face by which it is compared with others."""

ON = 1e-3
"""Distance from a face, relative to the root of its area, up to which a point is on it."""

FINEST = 160
"""Largest number of points along each parameter of a face, among which those within it are sought."""

ALIKE = 1e-3
"""Sine of the angle below which the normals of two faces at a node are one."""

COARSE, NEWTON = 9, 6
"""Numbers of points along each parameter from which the nearest place is sought, and of steps to it."""

STEPS = 20
"""Most steps to the middle: each doubles the digits where a plane meets a cylinder."""


def mesh_middle(gmsh: Any, shapes: Shapes, path: Path, job: Job, told: Callable[[str], None]) -> Mesh:
    """Mesh the middle surface of one solid of the current model.

    Raises
    ------
    MeshError
        If it is no sheet, or gmsh cannot mesh a face.
    """
    solid = next(solid for solid in shapes.solids if solid.tag in job.tags)
    if job.method != HXT:
        gmsh.option.setNumber("Mesh.Algorithm", MESH_ADAPT)
    told("looking for opposite faces")
    borders = _borders(gmsh, solid, shapes.scale)
    sheet = sheet_of(solid, borders, _probe(gmsh, shapes.scale), path.name)
    faces = {face.tag: face for face in solid.faces if face.tag in sheet.thickness}
    by_group = _set_groups(gmsh, solid, job.faces, sheet, path.name)
    set_sizes(gmsh, [solid], job, shapes.scale)
    gmsh.model.occ.remove(gmsh.model.getEntities(3))
    gmsh.model.occ.remove([one for one in gmsh.model.getEntities(2) if one[1] not in faces], recursive=True)
    gmsh.model.occ.synchronize()
    generate_stage(gmsh, 1, "edges", shapes, path, told)
    generate_stage(gmsh, 2, "faces", shapes, path, told)
    _gmsh.generate(gmsh, job.order)
    mesh = _gmsh.extract(gmsh, path)
    of_faces = _rows_of_faces(gmsh, list(faces))
    nodes = np.array(mesh.nodes) * shapes.scale
    sides = [(faces[tag], sheet.thickness[tag], rows) for tag, rows in of_faces.items()]
    moved = to_middle(nodes, nodes, sides, path.name)
    if mesh.order == 2:
        moved = to_middle(nodes, _with_corners(mesh, nodes, moved), sides, path.name)
    bow = sagitta(gmsh) * shapes.scale if job.order == 1 else 0.0
    _refuse_turned(replace(mesh, nodes=nodes, thickness=by_group), moved, path.name)
    return unfolded(replace(mesh, nodes=moved, thickness=by_group, sagitta=bow))


def middle_volume(mesh: Mesh) -> float:
    """Return area times thickness of a middle surface, m^3."""
    return sum(
        mesh.thickness[name] * float(measures(block.kind, mesh.nodes[block.nodes])[0].sum())
        for name, blocks in mesh.cells.items()
        for block in blocks
    )


def _with_corners(mesh: Mesh, nodes: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Return nodes of one side whose mid-side nodes move as their corners: else they come too near to one of them."""
    found = moved.copy()
    for block in mesh.cell_blocks:
        for place, ends in enumerate(MIDS[block.kind], start=shape(block.kind).corners):
            rows = block.nodes[:, place]
            found[rows] = nodes[rows] + (moved - nodes)[block.nodes[:, list(ends)]].mean(axis=1)
    return found


def to_middle(
    nodes: np.ndarray, start: np.ndarray, sides: list[tuple[Face, float, np.ndarray]], file: str
) -> np.ndarray:
    """Return nodes of one side moved to where each of their faces is half its thickness away, by the shortest way.

    Parameters
    ----------
    nodes, start : ndarray, shape (n, 3)
        On the side, and from where the way is the shortest, m.
    sides : list of (Face, thickness in m, rows of its nodes)
    file : str
        For messages.

    Raises
    ------
    MeshError
        If the thickness changes where faces are smooth.
    """
    moved = start.copy()
    count = np.zeros(len(nodes), dtype=int)
    slots = []
    for face, thickness, rows in sides:
        slots.append((face, thickness, rows, count[rows]))
        count[rows] += 1
    for _ in range(STEPS):
        normals = np.zeros((len(nodes), max(int(count.max()), 1), 3))
        missing = np.zeros(normals.shape[:2])
        for face, thickness, rows, slot in slots:
            normals[rows, slot] = outward(face, moved[rows])
            missing[rows, slot] = 0.5 * thickness - depth(face, moved[rows])
        step = np.einsum("nik,nk->ni", np.linalg.pinv(normals, rcond=ALIKE), missing)
        moved -= step
        if np.abs(step).max() <= 1e-14 * np.abs(nodes).max():
            break
    for face, thickness, rows, _ in slots:
        error = np.abs(depth(face, moved[rows]) - 0.5 * thickness)
        if error.max() > EVEN * thickness:
            at = ", ".join(f"{one:.4g}" for one in nodes[rows[error.argmax()]])
            raise MeshError(
                f"{file}: no middle surface: at ({at}) m the thickness changes from face to face, on one it is "
                f"{1e3 * thickness:.4g} mm. {REMEDY}"
            )
    return moved


def _refuse_turned(mesh: Mesh, moved: np.ndarray, file: str) -> None:
    """Refuse cells that turn over with the moved nodes, as they do if they are smaller than the way of these."""
    for name, blocks in mesh.cells.items():
        for block in blocks:
            before, after = (x[block.nodes[:, 1:3]] - x[block.nodes[:, :1]] for x in (mesh.nodes, moved))
            wrong = np.flatnonzero(np.einsum("mi,mi->m", _across(before), _across(after)) <= 0.0)
            if len(wrong):
                at = ", ".join(f"{one:.4g}" for one in mesh.nodes[block.nodes[wrong[0]]].mean(axis=0))
                raise MeshError(
                    f"{file}: {len(wrong)} cells at the fold at ({at}) m are smaller than half the thickness of "
                    f"{1e3 * mesh.thickness[name]:.4g} mm. Remedy: a larger size="
                )


def _across(sides: np.ndarray) -> np.ndarray:
    return np.cross(sides[:, 0], sides[:, 1])


def _borders(gmsh: Any, solid: Solid, scale: float) -> Borders:
    """Return the lengths of the edges that the faces of a solid share."""
    own = {face.tag for face in solid.faces}
    found: dict[int, dict[int, float]] = {tag: {} for tag in own}
    for tag in own:
        for _, edge in gmsh.model.getBoundary([(2, tag)], combined=False, oriented=False):
            for other in map(int, gmsh.model.getAdjacencies(1, edge)[0]):
                if other in own and other != tag:
                    length = scale * float(gmsh.model.occ.getMass(1, edge))
                    found[tag][other] = found[tag].get(other, 0.0) + length
    return found


def _probe(gmsh: Any, scale: float) -> Probe:
    how = () if _gmsh.is_before(gmsh, 4, 9) else (True,)

    def within(tag: int, places: np.ndarray) -> np.ndarray:
        inside = [gmsh.model.isInside(2, tag, place, *how) > 0 for place in places.reshape(-1, 2).tolist()]
        return np.array(inside, dtype=bool)

    def points(face: Face) -> np.ndarray:
        low, high = gmsh.model.getParametrizationBounds(2, face.tag)
        count, found = 5, np.zeros((0, 3))
        while len(found) < ENOUGH and count <= FINEST:
            ticks = (np.arange(count) + 0.5) / count
            u, v = np.meshgrid(*(a + (b - a) * ticks for a, b in zip(low, high, strict=True)))
            places = np.column_stack([u.ravel(), v.ravel()])
            places = places[within(face.tag, places)]
            if len(places):
                found = np.reshape(gmsh.model.getValue(2, face.tag, places.ravel()), (-1, 3)) * scale
            count *= 2
        return found

    def covers(face: Face, at: np.ndarray) -> np.ndarray:
        places = _parameters(gmsh, face.tag, at / scale)
        there = np.reshape(gmsh.model.getValue(2, face.tag, places.ravel()), (-1, 3)) * scale
        is_on = np.linalg.norm(there - at, axis=1) < ON * np.sqrt(face.area)
        is_on[is_on] = within(face.tag, places[is_on])
        return is_on

    return Probe(points, covers)


def _parameters(gmsh: Any, tag: int, points: np.ndarray) -> np.ndarray:
    """Return the parameters (k, 2) of the places of a face nearest to points, by Newton's method from those of a grid.

    gmsh's own search takes 50 ms a point where it is beside the face, or fails.
    """
    low, high = map(np.asarray, gmsh.model.getParametrizationBounds(2, tag))
    u, v = np.meshgrid(*(np.linspace(a, b, COARSE) for a, b in zip(low, high, strict=True)))
    grid = np.column_stack([u.ravel(), v.ravel()])
    at = np.reshape(gmsh.model.getValue(2, tag, grid.ravel()), (-1, 3))
    places = grid[np.linalg.norm(points[:, None] - at, axis=2).argmin(axis=1)]
    for _ in range(NEWTON):
        missing = points - np.reshape(gmsh.model.getValue(2, tag, places.ravel()), (-1, 3))
        slopes = np.reshape(gmsh.model.getDerivative(2, tag, places.ravel()), (-1, 2, 3)).swapaxes(1, 2)
        places = np.clip(places + np.einsum("kai,ki->ka", np.linalg.pinv(slopes), missing), low, high)
    return places


def _set_groups(
    gmsh: Any, solid: Solid, named: Mapping[str, tuple[int, ...]], sheet: Sheet, file: str
) -> dict[str, float]:
    """Make physical groups of the side that is meshed and of its edges at rims; return the thickness by group, m.

    Faces of a sheet that have a name are a group of cells by it; of a rim, the edges that it shares with the side.
    """
    owner: dict[int, str] = {}
    for name, tags in named.items():
        for own in {own for tag in tags for own in sheet.across.get(tag, ())}:
            other = owner.setdefault(own, name)
            if other != name:
                raise MeshError(
                    f"{file}: the faces of groups {other!r} and {name!r} are two sides of one sheet, which is one "
                    "group of cells. Remedy: one of them"
                )
    rest = {f"{1e3 * t:.4g} mm" for tag, t in sheet.thickness.items() if tag not in owner}
    thickness: dict[str, float] = {}
    groups: dict[str, list[int]] = {}
    for tag, t in sheet.thickness.items():
        name = owner.get(tag) or solid.name + (f" {1e3 * t:.4g} mm" if len(rest) > 1 else "")
        if abs(thickness.setdefault(name, t) - t) > EVEN * t:
            raise MeshError(
                f"{file}: the faces of group {name!r} are {1e3 * thickness[name]:.4g} and {1e3 * t:.4g} mm thick. "
                "Remedy: a name for each thickness"
            )
        groups.setdefault(name, []).append(tag)
    for name, of in groups.items():
        gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, of), name)
    for name, tags in named.items():
        if name in groups:
            continue
        edges = {
            int(edge)
            for _, edge in gmsh.model.getBoundary([(2, tag) for tag in tags], combined=False, oriented=False)
            if any(int(face) in sheet.thickness for face in gmsh.model.getAdjacencies(1, edge)[0])
        }
        if not edges:
            raise MeshError(
                f"{file}: the faces of group {name!r} have no edge on the side that is meshed. Remedy: without it, "
                "and mesh.with_groups(...) of the lines there"
            )
        gmsh.model.setPhysicalName(1, gmsh.model.addPhysicalGroup(1, sorted(edges)), name)
    return thickness


def _rows_of_faces(gmsh: Any, tags: list[int]) -> dict[int, np.ndarray]:
    """Return the rows of the nodes on each face, with its edges."""
    all_tags = np.asarray(gmsh.model.mesh.getNodes()[0], dtype=np.int64)
    row = np.zeros(int(all_tags.max()) + 1, dtype=np.int64)
    row[all_tags] = np.arange(len(all_tags))
    found = {}
    for tag in tags:
        ids = gmsh.model.mesh.getNodes(2, tag, includeBoundary=True)[0]
        found[tag] = np.unique(row[np.asarray(ids, dtype=np.int64)])
    return found
