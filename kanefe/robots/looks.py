"""What links look like: the visuals of URDF, and the shapes of MJCF, as surfaces that are drawn."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from kanefe.contact.geometry.look import Look
from kanefe.contact.geometry.shape import SurfaceShape
from kanefe.contact.outlines import outline
from kanefe.contact.shapes import Box, Capsule, Cylinder, Sphere
from kanefe.errors import KanefeError
from kanefe.frames import rotation_matrix
from kanefe.robots.pose import Pose

READ = (".stl", ".obj")
"""Formats of meshes that are read."""

SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH = 2, 3, 4, 5, 6, 7
"""MuJoCo's numbers of kinds of shapes."""


@dataclass(frozen=True)
class LinkLook:
    """A shape that a link is drawn with.

    Attributes
    ----------
    link : str or None
        None: the ground.
    pose : Pose
        In the frame of the link.
    shape : SurfaceShape
    """

    link: str | None
    pose: Pose
    shape: SurfaceShape


def looks_of_urdf(root: ElementTree.Element, path: Path) -> tuple[list[LinkLook], list[str]]:
    """Return the visuals of a URDF file, and the links of those that cannot be drawn: of other formats, or missing."""
    found: list[LinkLook] = []
    missed: list[str] = []
    for link in root.findall("link"):
        name = (link.get("name") or "unnamed").replace("/", ".")
        for visual in link.findall("visual"):
            try:
                found.append(LinkLook(name, _origin(visual.find("origin")), _shape(visual, path)))
            except (KanefeError, ValueError):
                missed.append(name)
    return found, list(dict.fromkeys(missed))


def _origin(element: ElementTree.Element | None) -> Pose:
    """Return the pose of an element "origin": three angles about fixed axes x, y and z, in this order."""
    if element is None:
        return Pose()
    at = np.array([float(one) for one in (element.get("xyz") or "0 0 0").split()])
    angles = [float(one) for one in (element.get("rpy") or "0 0 0").split()]
    (cx, cy, cz), (sx, sy, sz) = np.cos(angles), np.sin(angles)
    about_x = np.array(((1.0, 0.0, 0.0), (0.0, cx, -sx), (0.0, sx, cx)))
    about_y = np.array(((cy, 0.0, sy), (0.0, 1.0, 0.0), (-sy, 0.0, cy)))
    about_z = np.array(((cz, -sz, 0.0), (sz, cz, 0.0), (0.0, 0.0, 1.0)))
    return Pose(at, about_z @ about_y @ about_x)


def _shape(visual: ElementTree.Element, path: Path) -> SurfaceShape:
    """Return the shape of a visual; a ValueError if there is none that is read."""
    for kind in visual.findall("geometry/*"):
        if kind.tag == "box":
            return Box([float(one) for one in (kind.get("size") or "").split()])
        if kind.tag == "cylinder":
            return Cylinder(float(kind.get("radius") or ""), float(kind.get("length") or ""), axis="z")
        if kind.tag == "sphere":
            return Sphere(float(kind.get("radius") or ""))
        if kind.tag == "mesh" and (file := mesh_file(kind.get("filename") or "", path)) is not None:
            scale = np.array([float(one) for one in (kind.get("scale") or "1 1 1").split()])
            look = Look.from_file(file)
            # a mirrored mesh is inside out
            triangles = look.triangles if np.prod(scale) > 0.0 else look.triangles[:, ::-1]
            return Look(look.vertices * scale, triangles)
    raise ValueError("no shape that is read")


def mesh_file(name: str, path: Path) -> Path | None:
    """Return the file of a mesh that a URDF file names; packages are sought in the folders above the file."""
    if Path(name).suffix.lower() not in READ:
        return None
    kind, _, rest = name.rpartition("://")
    folders = [path.resolve().parent] if kind != "package" else list(path.resolve().parents)
    inside = [rest] if kind != "package" else [rest, rest.partition("/")[2]]
    places = (folder / one for folder in folders for one in inside)
    return next((place for place in places if place.is_file()), None)


def looks_of_mjcf(model: Any, links: list[str]) -> Iterator[LinkLook]:
    """Yield the shapes of a compiled model of MJCF: of bodies with shapes that touch nothing, these alone."""
    silent = (model.geom_contype == 0) & (model.geom_conaffinity == 0)
    with_visuals = set(model.geom_bodyid[silent].tolist())
    for i in range(model.ngeom):
        body = int(model.geom_bodyid[i])
        shape = _shape_of_mjcf(model, i) if silent[i] or body not in with_visuals else None
        if shape is not None:
            pose = Pose(model.geom_pos[i].copy(), rotation_matrix(model.geom_quat[i]))
            yield LinkLook(links[body] if body else None, pose, shape)


def _shape_of_mjcf(model: Any, number: int) -> SurfaceShape | None:
    """Return a shape of MJCF; None: a plane, a field of heights or a distance field."""
    kind, size = int(model.geom_type[number]), model.geom_size[number].copy()
    if kind == SPHERE:
        return Sphere(float(size[0]))
    if kind in (CAPSULE, CYLINDER):
        made = Capsule if kind == CAPSULE else Cylinder
        return made(float(size[0]), 2.0 * float(size[1]), axis="z")
    if kind == BOX:
        return Box(2.0 * size)
    if kind == ELLIPSOID and (ball := outline(Sphere(1.0))) is not None:
        return Look(ball.vertices * size, ball.triangles)
    if kind == MESH:
        mesh = int(model.geom_dataid[number])
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        start, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        return Look(model.mesh_vert[first : first + count].astype(float), model.mesh_face[start : start + faces])
    return None
