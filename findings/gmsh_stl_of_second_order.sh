#!/usr/bin/env bash
# gmsh 4.15.2 (and 4.8.0, 4.9.5) writes STL of quadrilaterals of second order with one triangle of each instead of two: half of the
# surface is missing, without a message. A binary file states the full number of triangles in its head and holds half of them,
# so that strict readers call it truncated. Of first order both are whole.
# Seen: a cube of 24 quadrilaterals, area 6, written as 24 triangles of area 3; the head of the binary file says 48.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv own
own/bin/pip install -q --disable-pip-version-check gmsh==4.15.2 numpy==1.26.4
own/bin/python - <<'PYTHON'
import re

import gmsh
import numpy as np

gmsh.initialize(["cube"], False)
gmsh.option.setNumber("General.Terminal", 0)
gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
gmsh.model.occ.synchronize()
gmsh.option.setNumber("Mesh.RecombineAll", 1)
for _, curve in gmsh.model.getEntities(1):
    gmsh.model.mesh.setTransfiniteCurve(curve, 3)
for _, surface in gmsh.model.getEntities(2):
    gmsh.model.mesh.setTransfiniteSurface(surface)
gmsh.model.mesh.generate(2)
RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def written(binary):
    """Return the corners of triangles in a file, and the number that its head states."""
    gmsh.option.setNumber("Mesh.Binary", binary)
    gmsh.write("cube.stl")
    content = open("cube.stl", "rb").read()
    if binary:
        rows = (len(content) - 84) // 50
        return np.frombuffer(content, RECORD, rows, 84)["corners"], int.from_bytes(content[80:84], "little")
    points = [[float(x) for x in row.split()] for row in re.findall(r"vertex (.*)", content.decode())]
    return np.array(points).reshape(-1, 3, 3), content.count(b"facet normal")


for order, expected in ((1, (48, 6.0)), (2, (24, 3.0))):
    gmsh.model.mesh.setOrder(order)
    for binary in (0, 1):
        corners, stated = written(binary)
        edges = corners[:, 1:] - corners[:, :1]
        area = float(np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1).sum() / 2)
        print(f"order {order}, {'binary' if binary else 'text'}: {stated} stated, {len(corners)} triangles of area {area:g}, right 48 of 6")
        assert (len(corners), round(area, 5)) == expected, "this has changed"
        assert stated == (48 if binary else expected[0]), "this has changed"
gmsh.finalize()
PYTHON
