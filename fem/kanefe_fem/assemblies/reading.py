"""`read_step`: an assembly from a STEP file, with masses, proposed joints, and what does not fit."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import FileError, ModelError, outside
from kanefe.storage.files import regular_file
from kanefe_fem.assemblies.assembly import Assembly, Overlap
from kanefe_fem.assemblies.meetings import facing_planes, fits, may_touch
from kanefe_fem.assemblies.parts import MaterialOrDensity, Part, materials_of
from kanefe_fem.assemblies.proposals import ProposedJoint, propose
from kanefe_fem.cad.geometry import GeometryKeywords, chosen, mesh_in, opened_shapes
from kanefe_fem.cad.relations import Surface
from kanefe_fem.cad.shapes import Shapes, Solid
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.checks import MeshWarning, check_mesh

SIDES = 20.0
"""Diagonal of the assembly relative to the largest side of a triangle of its surfaces."""

SAME_VOLUME = 1e-3
"""Difference of two integrals of a volume, relative to it, above which that over the surface is taken, and told."""

SHARE_OF_ORDER = 0.1
"""Error of a surface of order 2, relative to its difference from that of order 1, at most: it is of a higher order."""

OVERLAP = 1e-6
"""Volume that two parts share, relative to the smaller, above which they overlap."""


@checked("path", "order", "flexible", "overlaps", "size", "per_turn", "unit", "most_seconds", "faces")
def read_step(
    path: str | Path,
    materials: Material | float | Mapping[str, Material | float] | None = None,
    flexible: str | Sequence[str] = (),
    *,
    order: int = 2,
    overlaps: bool = True,
    **geometry: Unpack[GeometryKeywords],
) -> Assembly:
    """Read an assembly from a STEP or BREP file: its parts with their masses, and the joints that they may have.

    Parameters
    ----------
    path : str or Path
    materials : Material, float or dict of str to Material or float, optional
        Of all parts; or by name of part, product or colour ("#cc8000"), with "*" for all others. A number is a density
        in kg/m3. Without it parts have no mass.
    flexible : str or sequence of str
        Parts to mesh, which need a Material; the others are rigid. Mesh sizes are `size` and the other keywords of
        `kanefe_fem.read_mesh`.
    order : {1, 2}
        Of the meshes of flexible parts.
    overlaps : bool
        Whether to look for parts that overlap, which takes most of the time.
    **geometry
        As of `kanefe_fem.read_mesh`: `size`, `per_turn`, `faces` (of flexible parts), `unit`, `most_seconds` (of each
        step).

    Returns
    -------
    Assembly
        ``print`` tells what was found and what was not.

    Raises
    ------
    FileError, MeshError, ModelError
        As `kanefe_fem.read_mesh`; and if a name stands for no part, or a flexible part has no Material.

    Notes
    -----
    Joints are proposed from shafts in holes of about the same radius, and from planes that lie on each other, by the
    motion that these leave free. None is taken unless `Assembly.scene` is told to.
    """
    path = Path(path)
    regular_file(path, kind="STEP file", remedy="check the name and the working directory")
    if path.suffix.lower() not in (".step", ".stp", ".brep"):
        raise FileError(f"{path.name} is no STEP or BREP file. Remedy: export the assembly as STEP (AP214 or AP242)")
    if geometry.get("joined"):
        raise ModelError("joined= makes one body of all parts, and is not of an assembly. Remedy: read_mesh")
    if geometry.get("midsurface"):
        raise ModelError(
            "midsurface= is of one part as a shell, and flexible parts of an assembly are solids. Remedy: "
            "read_mesh(..., cells=NAME, midsurface=True), and shell_body"
        )
    unit, seconds = geometry.get("unit"), geometry.get("most_seconds")
    with opened_shapes(path, unit, seconds) as (process, shapes):
        meshed = chosen(shapes, flexible, path.name) if flexible else []
        of_parts = materials_of(shapes.solids, materials, path)
        for solid in meshed:
            if not isinstance(of_parts[solid.name], Material):
                raise ModelError(
                    f"{path.name}: the flexible part {solid.name!r} needs a Material with E, nu and rho, not "
                    f"{of_parts[solid.name]!r}. Remedy: materials={{{solid.name!r}: Material(E=..., nu=..., rho=...)}}"
                )
        proposed = propose(fits(shapes.solids, shapes.size), facing_planes(shapes.solids, shapes.size))
        common = _overlaps(process, shapes) if overlaps else ()
        surfaces = process.ask("surfaces", shapes.size / SIDES / shapes.scale)
        meshes: dict[str, Any] = {}
        for solid in meshed:
            process.ask("read", path.resolve(), shapes.scale, shapes.unit, False)
            faces = {one.name: one.faces[solid.name] for one in proposed if solid.name in one.parts}
            meshes[solid.name] = check_mesh(mesh_in(process, shapes, [solid], path, order, geometry, faces))
    parts = {
        solid.name: _part(solid, surfaces[solid.tag], shapes.scale, of_parts[solid.name], meshes.get(solid.name), path)
        for solid in shapes.solids
    }
    return Assembly(
        source=path.name,
        unit=shapes.unit,
        parts=parts,
        joints={one.name: one for one in proposed},
        overlaps=common,
        alone=_alone(shapes, proposed, common),
    )


def _overlaps(process: Any, shapes: Shapes) -> tuple[Overlap, ...]:
    pairs = [(a, b) for a, b in combinations(shapes.solids, 2) if may_touch(a, b, 0.0)]
    volumes = process.ask("overlaps", [(a.tag, b.tag) for a, b in pairs])
    return tuple(
        Overlap((a.name, b.name), None if volume is None else volume * shapes.scale**3)
        for (a, b), volume in zip(pairs, volumes, strict=True)
        if volume is None or volume * shapes.scale**3 > OVERLAP * min(a.volume, b.volume)
    )


def _part(
    solid: Solid, surface: Surface, scale: float, material: MaterialOrDensity | None, mesh: Any, path: Path
) -> Part:
    """Return a part; where OpenCASCADE's volume is not that of the surface, with the integrals over the surface."""
    volume, centre, moments = solid.volume, solid.centre, solid.moments
    other = surface.volume * scale**3
    corners = surface.points[surface.triangles]
    straight = float(np.einsum("mx,mx->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))) / 6.0 * scale**3
    unsure = max(SAME_VOLUME * volume, SHARE_OF_ORDER * abs(other - straight))
    if abs(other - volume) > unsure and any(face.kind == "other" for face in solid.faces):
        warnings.warn(
            f"{path.name}: OpenCASCADE's integral gives {solid.name!r} a volume of {volume:.5g} m^3, its surface "
            f"encloses {other:.5g} m^3. Mass and inertia are taken from the surface",
            MeshWarning,
            stacklevel=outside(),
        )
        volume, centre, moments = other, surface.centre * scale, surface.moments * scale**5
    return Part(
        name=solid.name,
        product=solid.product,
        path=solid.path,
        colour=solid.colour,
        volume=volume,
        center=centre,
        moments=moments,
        material=material,
        vertices=surface.points * scale,
        triangles=surface.triangles,
        mesh=None if mesh is None else replace(mesh, source=f"{path.name} ({solid.name})"),
    )


def _alone(
    shapes: Shapes, proposed: Sequence[ProposedJoint], common: Sequence[Overlap]
) -> tuple[tuple[str, str, float], ...]:
    """Return the parts that no other meets, each with the nearest one and how far it is at most, m."""
    touched = {name for one in proposed for name in one.parts} | {name for one in common for name in one.parts}
    clouds = {solid.name: np.concatenate([face.points for face in solid.faces]) for solid in shapes.solids}
    found = []
    for name in clouds.keys() - touched if len(clouds) > 1 else ():
        gaps = {other: _least_distance(clouds[name], cloud) for other, cloud in clouds.items() if other != name}
        nearest = min(gaps, key=lambda other: gaps[other])
        found.append((name, nearest, gaps[nearest]))
    return tuple(sorted(found))


def _least_distance(one: np.ndarray, other: np.ndarray) -> float:
    from scipy.spatial import cKDTree

    return float(cKDTree(one).query(other)[0].min())
