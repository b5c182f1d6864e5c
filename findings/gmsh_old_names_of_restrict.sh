#!/usr/bin/env bash
# gmsh 4.15.2 (PyPI), field "Restrict": the lists FacesList, EdgesList and RegionsList, the older names, are taken
# without an error, a warning or an entry in the log, and do nothing: the mesh is as coarse as without the field. SurfacesList,
# CurvesList and VolumesList work, as both sets of names do in 4.9.5.
# Seen: triangles on the wall of a hole, by no field, old names, new names: 4.9.5: few, many, many; 4.15.2: few, few, many.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
cat > hole.py <<'PYTHON'
import gmsh

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
occ, field = gmsh.model.occ, gmsh.model.mesh.field
plate, hole = occ.addBox(0, 0, 0, 60, 60, 10), occ.addCylinder(30, 30, 0, 0, 0, 10, 5)
occ.cut([(3, plate)], [(3, hole)])
occ.synchronize()
gmsh.option.setNumber("Mesh.CharacteristicLengthMax", 20)
wall = [tag for _, tag in gmsh.model.getEntities(2) if gmsh.model.getType(2, tag) == "Cylinder"]
rims = sorted(tag for _, tag in gmsh.model.getBoundary([(2, tag) for tag in wall], combined=False, oriented=False))


def triangles(faces, edges):
    gmsh.logger.start()
    if faces:
        size, restricted = field.add("MathEval"), field.add("Restrict")
        field.setString(size, "F", "2")
        field.setNumber(restricted, "IField", size)
        field.setNumbers(restricted, faces, wall)
        field.setNumbers(restricted, edges, rims)
        field.setAsBackgroundMesh(restricted)
    gmsh.model.mesh.generate(2)
    count = sum(len(ids) for ids in gmsh.model.mesh.getElements(2, wall[0])[1])
    said = [line for line in gmsh.logger.get() if not line.startswith(("Info", "Progress"))]
    gmsh.logger.stop()
    gmsh.model.mesh.clear()
    return count, said


found = [triangles("", ""), triangles("FacesList", "EdgesList"), triangles("SurfacesList", "CurvesList")]
(none, _), (old, said), (new, _) = found
print(gmsh.__version__, "without a field", none, "old names", old, said, "new names", new)
is_ignored = old == none and not said
assert new > 3 * none
assert is_ignored if gmsh.__version__.startswith("4.15") else old > 3 * none
PYTHON
for version in 4.9.5 4.15.2; do
  python3 -m venv "$version"
  "$version/bin/pip" install -q --disable-pip-version-check "gmsh==$version" numpy
  "$version/bin/python" hole.py
done
