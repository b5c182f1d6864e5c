#!/usr/bin/env bash
# meshio 5.3.5 reads decks of Abaqus and Nastran that place nodes, and leaves the places out without a message: an instance
# at x = 10 m, nodes in cylindrical coordinates, and grid points in a system of their own are read at their bare numbers.
# Seen: least x 0, 1 and 0 m, where 10, 0.7071 and 10 m are meant (see also issues 1456 and 1569 of meshio).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv own
own/bin/pip install -q --disable-pip-version-check meshio==5.3.5 numpy==1.26.4
own/bin/python - <<'PYTHON'
import meshio

CELLS = "*ELEMENT,TYPE=C3D8,ELSET=E\n1,1,2,3,4,5,6,7,8\n"
CUBE = "1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n"
SECTOR = "1,1,0,0\n2,2,0,0\n3,2,45,0\n4,1,45,0\n5,1,0,1\n6,2,0,1\n7,2,45,1\n8,1,45,1\n"
PART = f"*Part, name=P\n*NODE\n{CUBE}{CELLS}*End Part\n*Assembly, name=A\n*Instance, name=I, part=P\n10.,0.,0.\n*End Instance\n*End Assembly\n"
card = lambda *fields: "".join(str(field).ljust(8) for field in fields)
corners = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
grids = [card("GRID", i, 5, *map(float, xyz)) for i, xyz in enumerate(corners, 1)]
system = [card("CORD2R", 5, 0, "10.", "0.", "0.", "10.", "0.", "1.") + "+c", card("+c", "11.", "0.", "0.")]
solid = [card("CHEXA", 1, 1, 1, 2, 3, 4, 5, 6) + "+a", card("+a", 7, 8)]
FILES = {
    "instance.inp": ("*Heading\n" + PART, 0.0, 10.0),
    "cylindrical.inp": ("*NODE, SYSTEM=C\n" + SECTOR + CELLS, 1.0, 0.7071),
    "system.bdf": ("\n".join(["BEGIN BULK", *system, *grids, *solid, "ENDDATA", ""]), 0.0, 10.0),
}
for name, (text, seen, meant) in FILES.items():
    open(name, "w").write(text)
    least = meshio.read(name).points[:, 0].min()
    print(f"meshio {meshio.__version__}, {name}: least x {least:g} m, meant {meant:g} m")
    assert least == seen, "this has changed"
PYTHON
