"""gmsh source of an angle bracket with a fillet: a foot that is bolted down, an arm with an eye. Units: m.

Read by `kanefe_fem.read_mesh("meshes/bracket.py")`; run as a script it writes `bracket.msh` next to itself.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

ARM = 0.12  # m, from the back of the foot to the end of the arm, along x
FOOT = 0.08  # m, height of the foot along z; its back is the face x = 0
WIDTH = 0.04  # m, along y
THICKNESS = 0.01  # m, of both
FILLET = 0.008  # m, radius of the inner corner
EYE = (0.105, 0.006)  # m, x and radius of the hole through the arm
BOLTS, BOLT = (0.03, 0.065), 0.0035  # m, depth below the arm's top and radius of the holes through the foot
SIZE, FINE = 0.013, 0.004  # m, sides of cells, and at the fillet
ORDER = 2

VOLUME = (
    ((ARM + FOOT - THICKNESS) * THICKNESS + (1.0 - math.pi / 4.0) * FILLET**2) * WIDTH
    - math.pi * EYE[1] ** 2 * THICKNESS
    - len(BOLTS) * math.pi * BOLT**2 * THICKNESS
)  # m3


def build(gmsh: Any) -> None:
    """Make the geometry, the physical groups and the mesh in the current gmsh model."""
    occ = gmsh.model.occ
    t, r, y = THICKNESS, FILLET, -WIDTH / 2
    corners = ((0, t), (0, t - FOOT), (t, t - FOOT), (t, -r), (t + r, 0), (ARM, 0), (ARM, t))
    points = [occ.addPoint(x, y, z) for x, z in corners]
    centre = occ.addPoint(t + r, y, -r)
    count = len(points)
    sides = [
        occ.addCircleArc(points[3], centre, points[4]) if i == 3 else occ.addLine(points[i], points[(i + 1) % count])
        for i in range(count)
    ]
    outline = occ.addPlaneSurface([occ.addCurveLoop(sides)])
    solid = [entity for entity in occ.extrude([(2, outline)], 0.0, WIDTH, 0.0) if entity[0] == 3]
    holes = [(3, occ.addCylinder(EYE[0], 0.0, -t, 0.0, 0.0, 3 * t, EYE[1]))]
    holes += [(3, occ.addCylinder(-t, 0.0, t - depth, 3 * t, 0.0, 0.0, BOLT)) for depth in BOLTS]
    occ.cut(solid, holes)
    occ.synchronize()

    group(gmsh, 3, "bracket", [tag for _, tag in gmsh.model.getEntities(3)])
    faces = {tag: gmsh.model.getBoundingBox(2, tag) for _, tag in gmsh.model.getEntities(2)}
    small = 1e-4
    back = [tag for tag, box in faces.items() if box[3] < small]
    eye = [tag for tag, b in faces.items() if b[3] - b[0] < 2 * EYE[1] + small and b[0] > EYE[0] - EYE[1] - small]
    eye = [tag for tag in eye if faces[tag][4] < EYE[1] + small]
    group(gmsh, 2, "foot", back)
    group(gmsh, 2, "eye", eye)

    field = gmsh.model.mesh.field
    near = field.add("Cylinder")
    for name, value in (
        ("VIn", FINE),
        ("VOut", SIZE),
        ("Radius", 1.3 * r),
        ("XCenter", t + r / 3),
        ("YCenter", 0.0),
        ("ZCenter", -r / 3),
        ("XAxis", 0.0),
        ("YAxis", WIDTH),
        ("ZAxis", 0.0),
    ):
        field.setNumber(near, name, value)
    field.setAsBackgroundMesh(near)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 10)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(ORDER)


def group(gmsh: Any, dimension: int, name: str, tags: list[int]) -> None:
    """Give entities a physical group with a name."""
    number = gmsh.model.addPhysicalGroup(dimension, tags)
    gmsh.model.setPhysicalName(dimension, number, name)


if __name__ == "__main__":
    import gmsh

    gmsh.initialize()
    build(gmsh)
    gmsh.write(str(Path(__file__).with_suffix(".msh")))
    gmsh.finalize()
