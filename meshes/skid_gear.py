"""gmsh source of a skid landing gear: two bent cross tubes and two skid tubes, as lines for beam elements. Units: m.

Axes of the aircraft: x forward, y to port, z up, origin at the airframe's centre of mass. Read by
`kanefe_fem.read_mesh("meshes/skid_gear.py")`; run as a script it writes `skid_gear.msh` next to itself.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

CROSS_TUBES = {"aft": -0.9, "forward": 0.9}  # x, m
PROFILE = ((-1.10, -1.40), (-0.45, -0.80), (0.45, -0.80), (1.10, -1.40))  # y, z of a cross tube, m
SKIDS = {"starboard": -1.10, "port": 1.10}  # y, m
SKID_ENDS = (-1.4, 1.4)  # x, m
TOUCHING = (-1.2, -0.4, 0.4, 1.2)  # x of the shoes of a skid, m
SIZE = 0.1  # length of a beam element, m


def build(gmsh: Any) -> None:
    """Make the geometry, the physical groups and the mesh in the current gmsh model."""
    geo = gmsh.model.geo
    saddles: dict[str, int] = {}
    ends: dict[tuple[str, str], int] = {}
    crosses: list[int] = []
    for tube, x in CROSS_TUBES.items():
        points = [geo.addPoint(x, y, z, SIZE) for y, z in PROFILE]
        crosses += [geo.addLine(a, b) for a, b in pairwise(points)]
        ends[tube, "starboard"], saddles[f"{tube} starboard"] = points[0], points[1]
        saddles[f"{tube} port"], ends[tube, "port"] = points[2], points[3]
    runs: list[int] = []
    shoes: dict[str, list[int]] = {}
    for side, y in SKIDS.items():
        stations = {x: ends[tube, side] for tube, x in CROSS_TUBES.items()}
        for x in (*SKID_ENDS, *TOUCHING):
            stations.setdefault(x, geo.addPoint(x, y, PROFILE[0][1], SIZE))
        ordered = [stations[x] for x in sorted(stations)]
        runs += [geo.addLine(a, b) for a, b in pairwise(ordered)]
        shoes[side] = [stations[x] for x in TOUCHING]
    geo.synchronize()
    group(gmsh, 1, "cross tubes", crosses)
    group(gmsh, 1, "skid tubes", runs)
    for name, point in saddles.items():
        group(gmsh, 0, f"{name} saddle", [point])
    for side, points in shoes.items():
        for number, point in enumerate(points, start=1):
            group(gmsh, 0, f"{side} shoe {number}", [point])
    gmsh.model.mesh.generate(1)


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
