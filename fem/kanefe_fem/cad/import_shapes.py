"""Import of STEP and BREP files by gmsh's OpenCASCADE, and what is in them. All lengths of gmsh are mm here.

gmsh can convert to metres, but tolerances of OpenCASCADE are lengths, made for mm: small parts would suffer.
"""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any

import numpy as np

from kanefe.errors import FileError, MeshError, MissingDependency
from kanefe_fem.cad import _ocp
from kanefe_fem.cad.classify import kind_of_face, samples
from kanefe_fem.cad.shapes import NAME_OF_NONE, Colour, Face, Shapes, Solid, names_of, without_noise
from kanefe_fem.cad.step_text import UNITS, colours, decoded, name_of_unit, names_of_faces, units_of_shapes

BREP = (".brep",)
"""Suffix of OpenCASCADE's own files, which name no unit."""

CLOSED = (1e-6, 1e-5, 1e-4)
"""Gaps that healing closes, relative to the size of the part; the mass tells what that changes."""

SAME = 1e-5
"""Difference of area and of place, relative to the area and to the size of the part, of a face in two readers."""

NO_COLOUR = (0, 0, 255, 0)
"""Red, green, blue and opacity that gmsh gives for an entity without a colour: numbers up to 255."""


def scale_of(path: Path, unit: str | None) -> tuple[float, str, str]:
    """Return the length of OpenCASCADE's mm in m, the name of the unit, and what is to be told of it.

    Raises
    ------
    FileError
        If the file names no unit, and none is given, or if it has several and one is given.
    """
    if path.suffix.lower() in BREP:
        if unit is None:
            raise FileError(
                f"{path.name}: a BREP file has no unit. Remedy: unit='mm', 'm' or another of {', '.join(UNITS)}"
            )
        return UNITS[unit], unit, ""
    declared = units_of_shapes(path)
    names = ", ".join(map(name_of_unit, declared)) or "mm"
    if unit is None:
        nothing = f"{path.name} names no unit of length and is read in mm. Remedy: unit='mm' if that is so, or another"
        return 1e-3, names, "" if declared else nothing
    if len(declared) > 1:
        raise FileError(f"{path.name} has shapes in {names}: unit={unit!r} cannot replace both. Remedy: leave it out")
    ratio = UNITS[unit] / (declared[0] if declared else 1e-3)
    said = ""
    if declared and abs(ratio - 1.0) > 1e-9:
        said = f"{path.name} says {names} and is read in {unit}, as unit= asks: {ratio:.6g} times as large"
    return 1e-3 * ratio, unit, said


def import_shapes(gmsh: Any, path: Path) -> float:
    """Import the solids of a file into the current model, in mm; return the gap that was closed to make them, mm.

    Raises
    ------
    FileError
        If gmsh cannot read the file.
    MeshError
        If it has no solid and none can be made; the message names where its faces are open.
    """
    gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
    gmsh.option.setNumber("Geometry.OCCImportLabels", 1)
    try:
        found = gmsh.model.occ.importShapes(str(path), highestDimOnly=False)
        gmsh.model.occ.synchronize()
    except Exception as problem:
        raise FileError(
            f"gmsh's OpenCASCADE cannot read {path.name}: {problem}. Remedy: export it again as STEP AP214 or AP242"
        ) from problem
    if gmsh.model.getEntities(3):
        return 0.0
    if not gmsh.model.getEntities(2):
        what = "nothing" if not found else "no faces, only curves and points"
        raise MeshError(f"{path.name} contains {what}. Remedy: export the solids of the part")
    box = np.reshape(gmsh.model.getBoundingBox(-1, -1), (2, 3))
    size = float(np.linalg.norm(box[1] - box[0]))
    faces = len(gmsh.model.getEntities(2))
    for share in CLOSED:
        with contextlib.suppress(Exception):  # gmsh raises bare Exception
            gmsh.model.occ.healShapes([], share * size, True, True, True, True, True)
            gmsh.model.occ.synchronize()
        if gmsh.model.getEntities(3):
            return share * size
    open_edges = [tag for _, tag in gmsh.model.getEntities(1) if len(gmsh.model.getAdjacencies(1, tag)[0]) == 1]
    where = _middle(gmsh, open_edges[0]) if open_edges else None
    raise MeshError(
        f"{path.name} has {faces} faces and no solid: its surfaces do not close"
        + (f"; {len(open_edges)} edges bound one face only, the first at ({where}) in mm" if where else "")
        + ". Remedy: sew the surfaces where the file was made, and export a solid; surfaces alone are no body"
    )


def join_touching(gmsh: Any, path: Path) -> None:
    """Let parts of the current model that touch share their faces there; colours of faces are lost.

    Raises
    ------
    MeshError
        If two parts overlap.
    """
    solids = gmsh.model.getEntities(3)
    if len(solids) < 2:
        return
    facts = [(gmsh.model.getEntityName(*each), gmsh.model.getColor(*each)) for each in solids]
    names = [name for name, _ in names_of([name for name, _ in facts])]
    _, pieces = gmsh.model.occ.fragment(solids, [])
    gmsh.model.occ.synchronize()
    owner: dict[tuple[int, int], int] = {}
    for i, own in enumerate(pieces):
        for piece in own:
            first = owner.setdefault(piece, i)
            if first != i:
                volume = gmsh.model.occ.getMass(*piece)
                raise MeshError(
                    f"{path.name}: {names[first]!r} and {names[i]!r} overlap by {volume:.4g} mm^3, and cannot be "
                    "joined. Remedy: cut one from the other where they were made"
                )
            gmsh.model.setEntityName(*piece, facts[i][0])
            if facts[i][1] != NO_COLOUR:
                gmsh.model.setColor([piece], *facts[i][1])


def _middle(gmsh: Any, edge: int) -> str:
    start, end = (float(one[0]) for one in gmsh.model.getParametrizationBounds(1, edge))
    return ", ".join(f"{one:.6g}" for one in gmsh.model.getValue(1, edge, [(start + end) / 2.0]))


def remove_surfaces(gmsh: Any) -> int:
    """Remove surfaces that are part of no solid, and curves of no surface; return how many surfaces."""
    alone = {
        dimension: [one for one in gmsh.model.getEntities(dimension) if not len(gmsh.model.getAdjacencies(*one)[0])]
        for dimension in (2, 1, 0)
    }
    for entities in alone.values():
        gmsh.model.occ.remove(entities, recursive=True)
    gmsh.model.occ.synchronize()
    return len(alone[2])


def survey(gmsh: Any, path: Path, scale: float, unit: str, healed: float) -> Shapes:
    """Return what is in the current model: solids and faces with all their numbers, in m."""
    left_out = remove_surfaces(gmsh)
    tags = [tag for _, tag in gmsh.model.getEntities(3)]
    paths = [gmsh.model.getEntityName(3, tag) for tag in tags]
    if len(paths) == 1 and names_of(paths)[0][1] == NAME_OF_NONE:
        paths = [path.stem]
    is_text = path.suffix.lower() not in BREP
    declared, (named, unread) = (colours(path), _named_faces(path)) if is_text else ([], ([], ()))
    solids = []
    made: dict[int, Face] = {}  # a face between solids that are joined is one of both
    for tag, (name, product), where in zip(tags, names_of(paths), paths, strict=True):
        box = np.reshape(gmsh.model.getBoundingBox(3, tag), (2, 3))
        size = float(np.linalg.norm(box[1] - box[0]))
        bounds = gmsh.model.getBoundary([(3, tag)], combined=False, oriented=False)
        for _, face in bounds:
            if face not in made:
                made[face] = _face(gmsh, face, size, scale, declared, named)
        faces = tuple(made[face] for _, face in bounds)
        volume = gmsh.model.occ.getMass(3, tag)
        centre = np.array(gmsh.model.occ.getCenterOfMass(3, tag))
        if not volume > 0.0:
            raise MeshError(
                f"{path.name}: the solid {name!r} has the volume {volume:.3g} mm^3: its faces point inwards or do not "
                "close. Remedy: repair it where it was made, and export it again"
            )
        solids.append(
            Solid(
                tag=int(tag),
                name=name,
                product=product,
                path=where.split(" & ")[0],
                colour=_colour(gmsh, 3, tag, declared) or _one_colour(faces),
                volume=float(volume) * scale**3,
                centre=without_noise(centre * scale, size * scale),
                moments=np.reshape(gmsh.model.occ.getMatrixOfInertia(3, tag), (3, 3)) * scale**5,
                low=box[0] * scale,
                high=box[1] * scale,
                faces=faces,
            )
        )
    return Shapes(tuple(solids), unit, scale, healed * scale, left_out, unread)


def _named_faces(path: Path) -> tuple[list[_ocp.NamedFace], tuple[str, ...]]:
    """Return all faces with their own names, if there are any, and the names that cannot be read without OCP."""
    names = names_of_faces(path)
    if not names:
        return [], ()
    try:
        found = _ocp.named_faces(path)
    except MissingDependency:  # told by whoever asked for the shapes
        return [], names
    known = set(names)
    return [face._replace(name=name if (name := decoded(face.name)) in known else "") for face in found], ()


def _face(gmsh: Any, tag: int, size: float, scale: float, declared: list[Colour], named: list[_ocp.NamedFace]) -> Face:
    """Return a face; its name is that of the first of those that are left, which leaves the list: parts touch."""
    area = float(gmsh.model.occ.getMass(2, tag))
    found = samples(gmsh, tag)
    facts = kind_of_face(found, area, size)
    for name in {"point", "radius", "length"} & set(facts):
        facts[name] = facts[name] * scale
    centre = np.array(gmsh.model.occ.getCenterOfMass(2, tag))
    same = (
        i
        for i, one in enumerate(named)
        if abs(one.area - area) < SAME * area and float(np.linalg.norm(one.centre - centre)) < SAME * size
    )
    at = next(same, None)
    return Face(
        tag=int(tag),
        area=area * scale**2,
        centre=centre * scale,
        edges=found.edges * scale,
        inside=(found.inside if len(found.inside) or len(found.edges) else found.grid) * scale,
        name="" if at is None else named.pop(at).name,
        colour=_colour(gmsh, 2, tag, declared),
        **facts,
    )


def _one_colour(faces: tuple[Face, ...]) -> Colour | None:
    """Return the colour of all faces, if they have one."""
    found = {face.colour for face in faces}
    return found.pop() if len(found) == 1 else None


def _colour(gmsh: Any, dimension: int, tag: int, declared: list[Colour]) -> Colour | None:
    """Return the colour of an entity as the file declares it: versions of gmsh give it as it is, or as linear light."""
    given = tuple(int(one) for one in gmsh.model.getColor(dimension, tag))
    if given == NO_COLOUR:
        return None
    for one in declared:
        own = np.array(one) / 255.0
        linear = np.where(own <= 0.04045, own / 12.92, ((own + 0.055) / 1.055) ** 2.4)
        if any(np.abs(255.0 * seen - given[:3]).max() < 1.01 for seen in (own, linear)):
            return one
    return given[0], given[1], given[2]
