#!/usr/bin/env bash
# meshio 5.3.5 cannot read a MED file in which some cells or nodes are in no group while others are, as medcoupling 9.15.0 (the
# library of Salome) writes it: the family of those has no list of groups (no "GRO"), which is optional, and meshio ends with
# a KeyError that names neither the family nor the group.
# Seen: KeyError of 'GRO'; without that family the same file is read, with its group.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv own
own/bin/pip install -q --disable-pip-version-check meshio==5.3.5 medcoupling==9.15.0 h5py==3.14.0
own/bin/python - <<'PYTHON'
import h5py
import medcoupling as mc
import meshio
import numpy as np

grid = mc.MEDCouplingCMesh()
along = mc.DataArrayDouble(np.linspace(0.0, 1.0, 3))
grid.setCoords(along, along, along)
cube = grid.buildUnstructured()
cube.setName("cube")
file = mc.MEDFileUMesh()
file.setMeshAtLevel(0, cube)
low = mc.DataArrayInt(np.arange(4, dtype=np.int64))  # four of eight cells
low.setName("LOW")
file.setGroupsAtLevel(0, [low])
file.write("cube.med", 2)
try:
    meshio.read("cube.med")
    found = "read"
except KeyError as error:
    found = f"KeyError {error}"
print(f"meshio {meshio.__version__}, medcoupling {mc.MEDCouplingVersionStr()}: {found}")
assert "GRO" in found, "this has changed"
with h5py.File("cube.med", "r+") as data:
    families = data["FAS/cube/ELEME"]
    for name in [name for name in families if "GRO" not in families[name]]:
        del families[name]
print("without the family of no group:", sorted(name for names in meshio.read("cube.med").cell_tags.values() for name in names))
PYTHON
