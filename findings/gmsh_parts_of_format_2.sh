#!/usr/bin/env bash
# gmsh 4.8 (Debian 12, python3-gmsh 4.8.4+ds2-3) does not read the partitioned meshes of format 2.2 that it writes itself: the
# whole file is "No mesh elements were found", and the last of the pieces of Mesh.PartitionSplitMeshFiles ends the process
# (segmentation fault), so that no error can be caught. Format 4.1 is read. gmsh 4.9.5 to 4.11.1 give errors for all four; 4.12.2
# to 4.15.2 read them.
# Seen: error, error, error, signal 11 for p.msh, p_1.msh, p_2.msh, p_3.msh.
set -euo pipefail
/usr/bin/python3 -c "import gmsh; assert gmsh.__version__.startswith('4.8')" 2> /dev/null || { echo "needs gmsh 4.8: apt install python3-gmsh"; exit 2; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
/usr/bin/python3 - <<'PYTHON'
import subprocess
import sys

import gmsh

READ = "import gmsh, sys; gmsh.initialize(['x'], False); gmsh.option.setNumber('General.Terminal', 0); gmsh.merge(sys.argv[1])"


def write(version, split):
    gmsh.initialize(["two"], False)
    gmsh.option.setNumber("General.Terminal", 0)
    a, b = gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1), gmsh.model.occ.addBox(1, 0, 0, 1, 1, 1)
    gmsh.model.occ.fragment([(3, a)], [(3, b)])
    gmsh.model.occ.synchronize()
    for dimension, tag, name in ((3, 1, "a"), (3, 2, "b"), (2, 1, "held")):
        gmsh.model.setPhysicalName(dimension, gmsh.model.addPhysicalGroup(dimension, [tag]), name)
    gmsh.option.setNumber("Mesh.CharacteristicLengthMax", 0.5)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.PartitionSplitMeshFiles", split)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.partition(3)
    gmsh.write("p.msh")
    gmsh.finalize()


def read(name):
    done = subprocess.run([sys.executable, "-c", READ, name], capture_output=True, text=True)
    return "read" if done.returncode == 0 else "error" if done.returncode > 0 else f"signal {-done.returncode}"


for version, split, expected in (
    (4.1, 0, {"p.msh": "read"}),
    (2.2, 0, {"p.msh": "error"}),
    (2.2, 1, {"p_1.msh": "error", "p_2.msh": "error", "p_3.msh": "signal 11"}),
):
    write(version, split)
    found = {name: read(name) for name in expected}
    print(f"gmsh {gmsh.__version__}, format {version}: {found}")
    assert found == expected, "this has changed"
PYTHON
