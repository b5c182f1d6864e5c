"""gmsh source of a skid landing gear of tubes with walls: arched cross tubes, skid tubes, eight shoes. Units: m.

Axes of the aircraft: x forward, y to port, z up, origin at the airframe's centre of mass. The tubes are those of
`skid_gear.py`, moved up so that the shoes end at the height of its skids, and with a bend where a cross tube leaves its
saddles. Read by `kanefe_fem.solid_body("meshes/skid_gear_solid.py", ...)`; run as a script it writes a mesh to the
working directory. It does not use `__file__`, so that bodies made from it are found in the cache without meshing.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

CROSS_TUBES = {"aft": -0.9, "forward": 0.9}  # x, m
SIDES = {"starboard": -1.0, "port": 1.0}
RADIUS, WALL = 0.0381, 0.00635  # outer radius and wall thickness of all tubes, m
SLEEVE, THICK = 0.12, 0.004  # length and wall of the sleeves on the skids in which the cross tubes end, m
SHOE, FLAT, DEEP = 0.20, 0.030, 0.004  # length and breadth of a shoe, and its depth below its tube, m
BOTTOM = -1.40  # z of the shoes' faces, m
SADDLE, SKID = (0.45, 0.60), (1.10, 0.0)  # |y|, and z above the axes of the skids, m
SEAT = 0.06  # breadth of a saddle along its tube, m
ARCH = 0.30  # radius of the bends, m
SKID_ENDS = (-1.4, 1.4)  # x, m
TOUCHING = (-1.2, -0.4, 0.4, 1.2)  # x of the shoes of a skid, m
SIZE, FINE = 0.028, 0.016  # size of a cell, and where tubes meet, m
ABOUT_SKID = math.hypot(RADIUS + DEEP, FLAT / 2) + 1e-6  # largest distance of a point of a skid from its axis, m
AXIS = BOTTOM + DEEP + RADIUS  # z of the axes of the skids, m

Solids = list[tuple[int, int]]


def arch() -> tuple[float, float]:
    """Return |y| where a bend begins, and the angle (rad) of the bend at which the tube meets the skid tube."""
    begin = SADDLE[0] + SEAT / 2
    across, down = SKID[0] - begin, SADDLE[1] - ARCH  # from the centre of the bend, which is below its begin
    # the leg is tangent to the bend: its distance from the centre is the radius
    return begin, math.asin(ARCH / math.hypot(across, down)) + math.atan2(down, across)


def build(gmsh: Any) -> None:
    """Make the geometry, the physical groups and the mesh in the current gmsh model."""
    occ = gmsh.model.occ
    # keep separate faces for the seats
    gmsh.option.setNumber("Geometry.OCCUnionUnify", 0)
    solid = joined(occ, skids(occ, RADIUS) + crosses(occ, RADIUS) + sleeves(occ) + shoes(occ))
    bores, _ = occ.cut(joined(occ, crosses(occ, RADIUS - WALL)), sleeves(occ))
    occ.cut(solid, bores + skids(occ, RADIUS - WALL))
    occ.synchronize()
    group(gmsh, 3, "gear", [tag for _, tag in gmsh.model.getEntities(3)])
    for name, corners in places().items():
        faces = faces_in(gmsh, *corners)
        group(gmsh, 2, name, faces)
    gmsh.model.mesh.field.setAsBackgroundMesh(sizes(gmsh.model.mesh.field))
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.option.setNumber("Mesh.Algorithm3D", 10)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    follow_the_walls(gmsh)


def joined(occ: Any, solids: Solids) -> Solids:
    """Return the union of solids."""
    whole, _ = occ.fuse(solids[:1], solids[1:])
    return list(whole)


def skids(occ: Any, radius: float) -> Solids:
    """Return full cylinders along the axes of the skid tubes."""
    first, last = SKID_ENDS
    return [(3, occ.addCylinder(first, side * SKID[0], AXIS, last - first, 0, 0, radius)) for side in SIDES.values()]


def sleeves(occ: Any) -> Solids:
    """Return full cylinders around the skid tubes, because the intersection of tubes of equal radius is ill-defined."""
    return [
        (3, occ.addCylinder(x - SLEEVE / 2, side * SKID[0], AXIS, SLEEVE, 0, 0, RADIUS + THICK))
        for side in SIDES.values()
        for x in CROSS_TUBES.values()
    ]


def crosses(occ: Any, radius: float) -> Solids:
    """Return full cylinders and bends along the axes of the cross tubes, which end on the axes of the skids."""
    made = []
    begin, angle = arch()
    inboard, top = SADDLE[0] - SEAT / 2, AXIS + SADDLE[1]
    for x in CROSS_TUBES.values():
        made.append((3, occ.addCylinder(x, -inboard, top, 0, 2 * inboard, 0, radius)))
        for side in SIDES.values():
            made.append((3, occ.addCylinder(x, side * inboard, top, 0, side * SEAT, 0, radius)))
            disk = occ.addDisk(x, side * begin, top, radius, radius)
            occ.rotate([(2, disk)], x, side * begin, top, 1, 0, 0, math.pi / 2)
            bend = occ.revolve([(2, disk)], x, side * begin, top - ARCH, 1, 0, 0, -side * angle)
            made += [entity for entity in bend if entity[0] == 3]
            y, z = begin + ARCH * math.sin(angle), top - ARCH * (1 - math.cos(angle))
            made.append((3, occ.addCylinder(x, side * y, z, 0, side * (SKID[0] - y), AXIS - z, radius)))
    return made


def shoes(occ: Any) -> Solids:
    """Return blocks that end within the walls of the skid tubes."""
    high = DEEP + 0.7 * WALL
    return [
        (3, occ.addBox(x - SHOE / 2, side * SKID[0] - FLAT / 2, BOTTOM, SHOE, FLAT, high))
        for side in SIDES.values()
        for x in TOUCHING
    ]


def places() -> dict[str, tuple[float, ...]]:
    """Return least and largest x, y and z of the faces of each group."""
    found = {}
    for tube, x in CROSS_TUBES.items():
        for side, sign in SIDES.items():
            y, z = sign * SADDLE[0], AXIS + SADDLE[1]
            found[f"{tube} {side} saddle"] = box(x, y, z, 2 * RADIUS, SEAT, 2 * RADIUS)
    for side, sign in SIDES.items():
        for number, x in enumerate(TOUCHING, start=1):
            found[f"{side} shoe {number}"] = box(x, sign * SKID[0], BOTTOM, SHOE, FLAT, 0.0)
    return found


def box(x: float, y: float, z: float, *sides: float) -> tuple[float, ...]:
    """Return the corners of a box around a point, with a margin."""
    slack = 1e-4
    half = [side / 2 + slack for side in sides]
    return (x - half[0], y - half[1], z - half[2], x + half[0], y + half[1], z + half[2])


def faces_in(gmsh: Any, *corners: float) -> list[int]:
    """Return the faces in a box, without those inside a tube."""
    found = []
    for _, tag in gmsh.model.getEntitiesInBoundingBox(*corners, dim=2):
        low, *_, high, _, _ = gmsh.model.getBoundingBox(2, tag)
        if high - low > 2 * RADIUS - WALL:
            found.append(tag)
    return found


def sizes(field: Any) -> int:
    """Return the field of cell sizes, which are smaller where cross tubes end on sleeves."""
    balls = []
    for x in CROSS_TUBES.values():
        for side in SIDES.values():
            ball = field.add("Ball")
            place = {"XCenter": x, "YCenter": side * SKID[0], "ZCenter": AXIS + RADIUS}
            for name, value in {**place, "Radius": 2 * RADIUS, "VIn": FINE, "VOut": SIZE}.items():
                field.setNumber(ball, name, value)
            balls.append(ball)
    least = field.add("Min")
    field.setNumbers(least, "FieldsList", balls)
    return int(least)


def follow_the_walls(gmsh: Any) -> None:
    """Curve the sides within walls, which gmsh leaves straight, so that cells next to curved sides do not fold.

    The middle node of such a side is moved to the middle in coordinates along, around and across its tube.
    """
    tags, places, _ = gmsh.model.mesh.getNodes()
    rows = np.zeros(int(max(tags)) + 1, dtype=int)
    rows[tags] = np.arange(len(tags))
    X = np.reshape(places, (-1, 3))
    across = [(2, tag) for _, tag in gmsh.model.getEntities(2) if is_across(gmsh, tag)]
    inside = {int(tag) for entity in [(3, -1), *across] for tag in gmsh.model.mesh.getNodes(*entity)[0]}
    _, cells = gmsh.model.mesh.getElementsByType(11)  # tetrahedra of order 2
    cells = np.reshape(cells, (-1, 10)).astype(int)
    sides = ((0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3))  # with the middle nodes 4 to 9
    middles = {int(m): (int(a), int(b)) for k, (i, j) in enumerate(sides) for a, b, m in cells[:, (i, j, 4 + k)]}
    for middle, ends in middles.items():
        if middle in inside:
            a, b = X[rows[list(ends)]]
            gmsh.model.mesh.setNode(middle, halfway(a, b).tolist(), [])
    places = np.vstack((np.zeros(3), np.eye(3), [(i, j, k) for i in (0, 0.5) for j in (0, 0.5) for k in (0, 0.5)]))
    _, stretches, _ = gmsh.model.mesh.getJacobians(11, places.ravel().tolist())
    if min(stretches) <= 0.0:  # with some versions of gmsh
        gmsh.model.mesh.optimize("HighOrder")


def halfway(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the middle of two points of one tube in its coordinates, of other points on the line between them."""
    side = math.copysign(1.0, a[1])
    skid = np.array((side * SKID[0], AXIS))
    off = [math.dist(p[1:], skid) for p in (a, b)]
    if max(abs(r - RADIUS) for r in off) < 1e-6:  # a chord of the outer surface
        return (a + b) / 2
    if max(off) < (RADIUS + THICK + 1e-6 if max(a[2], b[2]) > AXIS else ABOUT_SKID):
        y, z = skid + middle_about(a[1:] - skid, b[1:] - skid)
        return np.array(((a[0] + b[0]) / 2, y, z))
    if min(off) < RADIUS:
        return (a + b) / 2
    tube = math.copysign(CROSS_TUBES["forward"], a[0])
    (s, u), (t, v) = along_cross((side * a[1], a[2])), along_cross((side * b[1], b[2]))
    x, n = middle_about(np.array((a[0] - tube, u)), np.array((b[0] - tube, v)))
    y, z = off_cross((s + t) / 2, n)
    return np.array((tube + x, side * y, z))


def is_across(gmsh: Any, tag: int) -> bool:
    """Return whether a face is plane and across a skid: its end, or the end of a sleeve or shoe."""
    low, *_, high, _, _ = gmsh.model.getBoundingBox(2, tag)
    return high - low < 1e-5


def middle_about(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the middle of two points of a plane in polar coordinates about its origin."""
    toward = a / np.linalg.norm(a) + b / np.linalg.norm(b)
    return (np.linalg.norm(a) + np.linalg.norm(b)) / 2 * toward / np.linalg.norm(toward)


def along_cross(point: tuple[float, float]) -> tuple[float, float]:
    """Return the position of a point (y, z) along the axis of a cross tube, from its middle, and the distance above."""
    begin, angle = arch()
    y, z = point[0] - begin, point[1] - (AXIS + SADDLE[1] - ARCH)  # from the centre of the bend
    turned = math.atan2(y, z)
    if y <= 0.0:
        return point[0], z - ARCH
    if turned <= angle:
        return begin + ARCH * turned, math.hypot(y, z) - ARCH
    c, s = math.cos(angle), math.sin(angle)
    return begin + ARCH * angle + y * c - z * s, y * s + z * c - ARCH


def off_cross(s: float, n: float) -> tuple[float, float]:
    """Return the point (y, z) at the position s along the axis of a cross tube and at the distance n above it."""
    begin, angle = arch()
    turned = min(max((s - begin) / ARCH, 0.0), angle)
    c, sine = math.cos(turned), math.sin(turned)
    on = s - begin - ARCH * turned if s < begin or turned == angle else 0.0
    y = begin + (ARCH + n) * sine + on * c
    return y, AXIS + SADDLE[1] - ARCH + (ARCH + n) * c - on * sine


def group(gmsh: Any, dimension: int, name: str, tags: list[int]) -> None:
    """Give entities a physical group with a name."""
    number = gmsh.model.addPhysicalGroup(dimension, tags)
    gmsh.model.setPhysicalName(dimension, number, name)


if __name__ == "__main__":
    import gmsh

    gmsh.initialize()
    build(gmsh)
    gmsh.write("skid_gear_solid.msh")
    gmsh.finalize()
