"""`read_mesh` of STEP and BREP files: what is asked for is checked against what is in the file, then meshed."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TypedDict

import numpy as np

from kanefe.errors import MeshError, ModelError, UnitWarning, did_you_mean, outside
from kanefe.fe_model.places import SLACK, Place, PlaceLike, contained
from kanefe_fem.cad._ocp import EXTRA
from kanefe_fem.cad.estimate import Estimate, estimate, of_surface, refuse_if_too_large
from kanefe_fem.cad.import_shapes import scale_of
from kanefe_fem.cad.mesher import DELAUNAY, Job, Unmeshable, volumes_of
from kanefe_fem.cad.middle import middle_volume
from kanefe_fem.cad.shapes import Face, Shapes, Solid, by_name, name_of_colour
from kanefe_fem.cad.step_text import UNITS
from kanefe_fem.machine.own_process import OwnProcess, ProcessEnded
from kanefe_fem.mesh.checks import MeshWarning
from kanefe_fem.mesh.mesh import Mesh

WORKER = "kanefe_fem.cad.worker"
REST = "*"
"""Name in `size` of all parts that have none of their own."""

LEAST, MOST = 1e-4, 100.0
"""Sizes of a part between which its unit is not asked for, in m."""

WITHOUT_SIZE = 0.1
"""Largest side of a cell where only `per_turn` is given, relative to the diagonal of the parts."""

MOST_NAMES = 8
"""Largest number of parts that a message lists."""

AS_GEOMETRY = 0.01
"""Difference of volume between mesh and geometry, relative to the latter, above which it is told."""


class GeometryKeywords(TypedDict, total=False):
    """How `kanefe_fem.read_mesh` meshes a STEP or BREP file."""

    size: float | Mapping[str, float] | None
    per_turn: int | None
    unit: str | None
    faces: Mapping[str, PlaceLike]
    joined: bool
    midsurface: bool
    most_seconds: float | None


@contextmanager
def opened_shapes(
    path: Path, unit: str | None, most_seconds: float | None = None, joined: bool = False
) -> Iterator[tuple[OwnProcess, Shapes]]:
    """Yield what is in a STEP or BREP file, and the process in which it is open.

    Raises
    ------
    FileError, MeshError
        If the file cannot be read, or has no solid.
    ModelError
        If the unit is not known, or the size of the part says that it is wrong.
    """
    if unit is not None and unit not in UNITS:
        raise ModelError(f"unit={unit!r} is not known. {did_you_mean(unit, UNITS)}Remedy: one of {', '.join(UNITS)}")
    if most_seconds is not None and most_seconds <= 0.0:
        raise ModelError(f"most_seconds={most_seconds!r} must be > 0")
    scale, name, said = scale_of(path, unit)
    with OwnProcess(WORKER, path.name, most_seconds) as process:
        shapes: Shapes = process.ask("read", path.resolve(), scale, name, joined)
        if said:
            warnings.warn(said, UnitWarning, stacklevel=outside())
        largest = float(shapes.extent.max())
        if unit is None and not LEAST <= largest <= MOST * (1.0 + SLACK):
            raise ModelError(
                f"{path.name} is {largest:.3g} m large, if its numbers are {name} as it says. Remedy: unit= the unit "
                f"that its numbers have, one of {', '.join(UNITS)}; unit={name.split(', ')[0]!r} if it is really so"
            )
        for told in _told(shapes, path.name):
            warnings.warn(told, MeshWarning, stacklevel=outside())
        yield process, shapes


def _told(shapes: Shapes, file: str) -> Iterator[str]:
    """Yield what was done to the shapes of a file, and what of it is left out."""
    if shapes.healed:
        yield (
            f"{file} has faces that are not joined: gaps of up to {shapes.healed:.1g} m were closed to "
            f"{len(shapes.solids)} solids of {sum(s.volume for s in shapes.solids):.6g} m^3. Check the volume"
        )
    if shapes.left_out:
        yield (
            f"{file} has {shapes.left_out} surfaces beside its {len(shapes.solids)} solids, which are left out. "
            "Remedy: if they are part of a body, sew them to a solid where the file was made"
        )
    if shapes.unread:
        yield (
            f"{file} names faces ({', '.join(map(repr, shapes.unread[:MOST_NAMES]))}"
            f"{', ...' if len(shapes.unread) > MOST_NAMES else ''}), which only OCP reads. Remedy: {EXTRA}; or faces= "
            "by place"
        )


def mesh_of_geometry(path: Path, order: int | None, cells: str | Sequence[str] | None, given: GeometryKeywords) -> Mesh:
    """Return the mesh of a STEP or BREP file; see `kanefe_fem.read_mesh`."""
    joined = given.get("joined", False)
    with opened_shapes(path, given.get("unit"), given.get("most_seconds"), joined) as (process, shapes):
        solids = chosen(shapes, cells, path.name)
        if len(solids) > 1 and not joined:
            raise MeshError(
                f"{path.name} has {len(solids)} parts, {', '.join(repr(s.name) for s in solids[:MOST_NAMES])}"
                f"{', ...' if len(solids) > MOST_NAMES else ''}, which share no faces. Remedy: cells= one part for "
                "each body; joined=True, if parts that touch are one body"
            )
        if given.get("midsurface") and len(solids) > 1:
            raise MeshError(
                f"{path.name}: a middle surface is of one part, and these are {len(solids)}. Remedy: cells= one part, "
                "without joined="
            )
        return mesh_in(process, shapes, solids, path, order, given)


def mesh_in(
    process: OwnProcess,
    shapes: Shapes,
    solids: Sequence[Solid],
    path: Path,
    order: int | None,
    given: GeometryKeywords,
    more: Mapping[str, tuple[int, ...]] | None = None,
) -> Mesh:
    """Mesh some solids of a file that a process has open, with more groups of faces by their numbers."""
    is_middle = given.get("midsurface", False)
    order = order or (2 if is_middle else 1)
    faces = faces_in_places(solids, given.get("faces") or {}, path.name)
    if both := [name for name in faces if name in (more or {})]:
        raise ModelError(
            f"{path.name}: {both[0]!r} is a proposed joint, whose faces are a group already. Remedy: another name"
        )
    faces |= _by_name(solids, {*faces, *(more or {})})
    sizes, face_sizes = _sizes(shapes, solids, faces, path.name, order, given)
    found = _estimate(solids, [sizes[s.tag] for s in solids], order, is_middle)
    refuse_if_too_large(found, list(sizes.values()), path.name)
    by_colour = {} if is_middle else _by_colour(solids, faces)
    groups = {name: tuple(face.tag for face in each) for name, each in (faces | by_colour).items()}
    groups |= more or {}
    tags = tuple(solid.tag for solid in solids)
    job = Job(tags, sizes, face_sizes, groups, given.get("per_turn") or 0, order, is_middle=is_middle)
    try:
        mesh = Mesh(**process.ask("mesh", job))
    except (ProcessEnded, Unmeshable):  # where triangles cross, the faster method ends the program
        process.restart()
        process.ask("read", path.resolve(), shapes.scale, shapes.unit, given.get("joined", False))
        mesh = Mesh(**process.ask("mesh", replace(job, method=DELAUNAY)))
    told = _compared(mesh, solids, path.name)
    told |= {
        "unit": shapes.unit,
        "size": f"{min(sizes.values()):g} m",
        "estimate": f"{'at least ' if job.per_turn else ''}{found}",
    }
    return replace(mesh, provenance={**mesh.provenance, **told})


def chosen(shapes: Shapes, cells: str | Sequence[str] | None, file: str) -> list[Solid]:
    """Return the solids of given names, products or colours; all if there are none."""
    if cells is None:
        return list(shapes.solids)
    known = {solid.name: solid for solid in shapes.solids}
    found: list[Solid] = []
    for name in [cells] if isinstance(cells, str) else cells:
        those = by_name(known, name)
        if not those:
            raise ModelError(
                f"{file} has no part called {name!r}. {did_you_mean(name, known)}Remedy: one of "
                f"{', '.join(map(repr, known))}, or a colour such as '#cc8000'"
            )
        found += [one for one in those if one not in found]
    return found


def faces_in_places(solids: Sequence[Solid], places: Mapping[str, PlaceLike], file: str) -> dict[str, list[Face]]:
    """Return the faces that lie as a whole in each place.

    Raises
    ------
    ModelError
        If there is none, if two places have one face, or if a part has the name of a place.
    """
    low, high = np.min([s.low for s in solids], axis=0), np.max([s.high for s in solids], axis=0)
    found: dict[str, list[Face]] = {}
    owner: dict[int, str] = {}
    for name, place in places.items():
        if not name:
            raise ModelError(f"{file}: a group of faces has no name. Remedy: a name in faces=")
        if any(solid.name == name for solid in solids):
            raise ModelError(f"{file}: {name!r} is a part and cannot be a group of faces too. Remedy: another name")
        found[name] = [f for s in solids for f in s.faces if _lies_in(f, place, low, high, f"group {name!r}")]
        if not found[name]:
            raise ModelError(
                f"{file}: no whole face lies in {place!r}, the group {name!r}.{_nearest(solids, place)} Remedy: a "
                "larger distance, or another place, in m; for a part of a face, mesh.with_groups(...) afterwards"
            )
        for face in found[name]:
            other = owner.setdefault(face.tag, name)
            if other != name:
                at = ", ".join(f"{one:.4g}" for one in face.centre)
                raise ModelError(
                    f"{file}: the face at ({at}) m, with an area of {face.area:.3g} m^2, is in two groups, {other!r} "
                    f"and {name!r}. Remedy: places that have no face in common"
                )
    return found


def _lies_in(face: Face, place: PlaceLike, low: np.ndarray, high: np.ndarray, label: str) -> bool:
    if isinstance(place, Place):
        return bool(place.contains(face.points, SLACK * float((high - low).max())).all())
    return bool(contained(face.points, place, label).all())


def _nearest(solids: Sequence[Solid], place: PlaceLike) -> str:
    """Return where the face is that comes nearest to a point, if the place has one."""
    point = getattr(place, "point", None)
    if point is None:
        return ""
    faces = [face for solid in solids for face in solid.faces]
    nearest = min(faces, key=lambda face: float(np.linalg.norm(face.points - np.array(point), axis=1).min()))
    at = ", ".join(f"{one:.4g}" for one in nearest.centre)
    return f" The nearest face has its middle at ({at}) m."


def _by_name(solids: Sequence[Solid], taken: Collection[str]) -> dict[str, list[Face]]:
    """Return the faces of each name in the file that is no part and none of those that are taken."""
    found: dict[str, list[Face]] = {}
    for face in (face for solid in solids for face in solid.faces):
        if face.name and face.name not in taken and all(face.name != solid.name for solid in solids):
            found.setdefault(face.name, []).append(face)
    return found


def _by_colour(solids: Sequence[Solid], taken: Mapping[str, object]) -> dict[str, list[Face]]:
    """Return the faces of each colour, of solids whose faces have more than one."""
    found: dict[str, list[Face]] = {}
    for solid in solids:
        if len({face.colour for face in solid.faces}) > 1:
            for face in solid.faces:
                if face.colour is not None and name_of_colour(face.colour) not in taken:
                    found.setdefault(name_of_colour(face.colour), []).append(face)
    return found


def _sizes(
    shapes: Shapes,
    solids: Sequence[Solid],
    faces: Mapping[str, list[Face]],
    file: str,
    order: int,
    given: GeometryKeywords,
) -> tuple[dict[int, float], dict[int, float]]:
    """Return the size of each solid, and those of faces that have one of their own, m."""
    size, per_turn = given.get("size"), given.get("per_turn")
    if per_turn is not None and per_turn < 3:
        raise ModelError(f"per_turn={per_turn!r} must be a whole number of at least 3")
    if size is None and per_turn is None:
        is_middle = given.get("midsurface", False)
        proposal = _proposal(solids, is_middle)
        found = _estimate(solids, [proposal] * len(solids), order, is_middle)
        extent = " x ".join(f"{one:.3g}" for one in shapes.extent)
        raise ModelError(
            f"{file} is a geometry of {extent} m with {len(shapes.solids)} solids, and needs a size of the cells. "
            f"Remedy: size= the largest side of a cell in m, such as size={proposal:g} ({found}), by name "
            "(size={'bore': 0.001, '*': 0.004}), or per_turn= cells around each curved face"
        )
    if size is None:
        size = shapes.size * WITHOUT_SIZE
    own = size if isinstance(size, Mapping) else {REST: size}
    for name, value in own.items():
        if not value > 0.0:
            raise ModelError(f"size= of {name!r} is {value!r}. Remedy: a length in m, > 0")
    known = {solid.name: solid for solid in solids}
    of_solids: dict[int, float] = {}
    of_faces: dict[int, float] = {}
    for name, value in own.items():
        those = [] if name == REST else by_name(known, name)
        of_solids |= dict.fromkeys((solid.tag for solid in those), float(value))
        of_faces |= dict.fromkeys((face.tag for face in faces.get(name, ())), float(value))
        if not those and name != REST and name not in faces:
            raise ModelError(
                f"{file}: size= names {name!r}, which is no part and no group of faces. "
                f"{did_you_mean(name, [*known, *faces])}Remedy: one of {', '.join(map(repr, [*known, *faces, REST]))}"
            )
    without = [solid.name for solid in solids if solid.tag not in of_solids]
    if without and REST not in own:
        raise ModelError(f"{file}: size= has none for {without[0]!r}. Remedy: add it, or {REST!r} for all others")
    return {s.tag: of_solids.get(s.tag, float(own.get(REST, 0.0))) for s in solids}, of_faces


def _estimate(solids: Sequence[Solid], sizes: Sequence[float], order: int, is_middle: bool) -> Estimate:
    """Return what a mesh takes of solids, or of their middle surfaces, which have half of all faces."""
    if is_middle:
        return of_surface(0.5 * solids[0].area, sizes[0], order)
    return estimate([s.volume for s in solids], [s.area for s in solids], sizes, order)


def _proposal(solids: Sequence[Solid], is_middle: bool) -> float:
    """Return a size that gives the thinnest solid about one cell of second order through its thickness.

    A middle surface gets about four hundred triangles.
    """
    if is_middle:
        return float(f"{np.sqrt(0.5 * solids[0].area) / 13.0:.1g}")
    return float(f"{min(2.0 * solid.volume / solid.area for solid in solids):.1g}")


def _compared(mesh: Mesh, solids: Sequence[Solid], file: str) -> dict[str, str]:
    """Return what a mesh has of volume against its geometry, of a middle surface; warn where that is another one.

    Straight sides cut corners, thin parts are lost, and edges of sheets are not square.
    """
    if mesh.thickness:
        solid, remedy = solids[0], "none, if its edges are chamfered; else order=2, or solid_body"
        difference = middle_volume(mesh) / solid.volume - 1.0
        if abs(difference) > AS_GEOMETRY:
            _tell_volume(f"the middle surface of {solid.name!r} times its thickness", difference, file, remedy)
        return {"middle surface": f"area times thickness {100.0 * difference:+.2g} % of the volume of the solid"}
    volumes = volumes_of(mesh)
    for solid in solids:
        difference = volumes.get(solid.name, 0.0) / solid.volume - 1.0
        if abs(difference) > AS_GEOMETRY:
            remedy = (
                "order=2, whose cells follow curved faces, or a smaller size; if it stays, OpenCASCADE's integral over "
                "trimmed splines is off, and the mesh is right"
            )
            _tell_volume(f"the mesh of {solid.name!r}", difference, file, remedy)
    return {}


def _tell_volume(what: str, difference: float, file: str, remedy: str) -> None:
    warnings.warn(
        f"{file}: {what} has {100.0 * difference:+.2g} % of volume, and so of mass, against its geometry. "
        f"Remedy: {remedy}",
        MeshWarning,
        stacklevel=outside(),
    )
