#!/usr/bin/env bash
# meshio 5.3.5 drops what decks of Nastran and Abaqus hold, without a message: elements in large fields (CTETRA*, as I-DEAS
# writes them) beside others in small fields, node sets that name other sets, and all but the first name of a line of sets.
# Seen: 1 of 2 tetrahedra; 0 nodes of 3; and 1 cell of 2 (see also issue 1253 of meshio).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv own
own/bin/pip install -q --disable-pip-version-check meshio==5.3.5 numpy==1.26.4
own/bin/python - <<'PYTHON'
import meshio

card = lambda *fields: "".join(str(field).ljust(8) for field in fields)
corners = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1))
grids = [card("GRID", i, "", *map(float, xyz)) for i, xyz in enumerate(corners, 1)]
wide = "CTETRA* " + "".join(str(n).rjust(16) for n in (2, 1, 2, 3)) + "\n*       " + "".join(str(n).rjust(16) for n in (4, 5))
open("a.bdf", "w").write("\n".join(["BEGIN BULK", *grids, card("CTETRA", 1, 1, 1, 2, 3, 4), wide, "ENDDATA", ""]))
nodes = "*NODE\n" + "".join(f"{i},{x},{y},{z}\n" for i, (x, y, z) in enumerate(corners, 1))
cells = "*ELEMENT,TYPE=C3D4,ELSET=A\n1,1,2,3,4\n*ELEMENT,TYPE=C3D4,ELSET=B\n2,2,3,4,5\n"
sets = "*NSET,NSET=P\n1,2,3\n*NSET,NSET=Q\nP\n*ELSET,ELSET=C\n1\n*ELSET,ELSET=D\n2\n*ELSET,ELSET=E\nC, D\n"
open("a.inp", "w").write(nodes + cells + sets)

count = sum(len(block.data) for block in meshio.read("a.bdf").cells)
print(f"meshio {meshio.__version__}, a.bdf: {count} tetrahedra, 2 in the deck")
assert count == 1, "this has changed"
mesh = meshio.read("a.inp")
print(f"a.inp: {len(mesh.point_sets['Q'])} nodes in the set of a set, 3 in the deck")
assert len(mesh.point_sets["Q"]) == 0, "this has changed"
import numpy as np
found = sum(np.size(rows) for entry in mesh.cell_sets["E"] for rows in np.atleast_1d(np.array(entry, dtype=object)))
print(f"a.inp: {found} cells in the set of two sets, 2 in the deck")
assert found == 1, "this has changed"
PYTHON
