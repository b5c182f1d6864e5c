"""gmsh source of the demonstration arm: a tapered aluminium bar with four holes. Units: m.

Read by `kanefe_fem.read_mesh("meshes/arm.py")`; run as a script it writes `arm.msh` next to itself.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

LENGTH = 1.0  # m, along x
ROOT_WIDTH, TIP_WIDTH = 0.08, 0.05  # m, along y
THICKNESS = 0.04  # m, along z
HOLES = ((0.2, 0.022), (0.4, 0.020), (0.6, 0.018), (0.8, 0.016))  # (x, radius) in m, through the thickness
SIZE = 0.03  # m, largest side of a cell
ORDER = 2  # curved cells, for round holes

VOLUME = (LENGTH * (ROOT_WIDTH + TIP_WIDTH) / 2.0 - sum(math.pi * r**2 for _, r in HOLES)) * THICKNESS  # m3


def build(gmsh: Any) -> None:
    """Make the geometry, the physical groups and the mesh in the current gmsh model."""
    occ = gmsh.model.occ
    corners = ((0.0, -ROOT_WIDTH / 2), (LENGTH, -TIP_WIDTH / 2), (LENGTH, TIP_WIDTH / 2), (0.0, ROOT_WIDTH / 2))
    points = [occ.addPoint(x, y, -THICKNESS / 2) for x, y in corners]
    sides = [occ.addLine(points[i], points[(i + 1) % 4]) for i in range(4)]
    outline = occ.addPlaneSurface([occ.addCurveLoop(sides)])
    bar = [entity for entity in occ.extrude([(2, outline)], 0.0, 0.0, THICKNESS) if entity[0] == 3]
    holes = [(3, occ.addCylinder(x, 0.0, -THICKNESS, 0.0, 0.0, 2 * THICKNESS, radius)) for x, radius in HOLES]
    occ.cut(bar, holes)
    occ.synchronize()

    group(gmsh, 3, "arm", [tag for _, tag in gmsh.model.getEntities(3)])
    for name, x in (("root", 0.0), ("tip", LENGTH)):
        faces = [t for _, t in gmsh.model.getEntities(2) if abs(occ.getCenterOfMass(2, t)[0] - x) < 1e-6]
        group(gmsh, 2, name, faces)

    gmsh.option.setNumber("Mesh.MeshSizeMax", SIZE)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 12)
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
