#!/usr/bin/env bash
# NGSolve 6.2.2608 has nodal elements of order 2, whose space on a tetrahedral mesh counts the vertices alone: NodalFESpace(mesh,
# order=2) tells order 2 and as many unknowns as vertices, without a message. Only an assembly in it stops: its elements have 10
# functions for 4 numbers.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv own
own/bin/pip install -q --disable-pip-version-check ngsolve==6.2.2608 numpy==1.26.4
own/bin/python - <<'PYTHON'
import ngsolve as ng
from netgen.occ import unit_cube

mesh = ng.Mesh(unit_cube.GenerateMesh(maxh=1.0))
nodal, usual = ng.NodalFESpace(mesh, order=2), ng.H1(mesh, order=2)
print(f"ngsolve {ng.__version__}: {mesh.nv} vertices, {mesh.nedge} edges; order {nodal.globalorder} of nodal elements: "
      f"{nodal.ndof} unknowns, of H1: {usual.ndof}")
assert nodal.ndof == mesh.nv and usual.ndof == mesh.nv + mesh.nedge, "this has changed"
u, v = nodal.TnT()
try:
    ng.BilinearForm(u * v * ng.dx).Assemble()
except Exception as error:
    print("assembly:", str(error).splitlines()[0])
    assert "Inconsistent number of degrees of freedom" in str(error), "this has changed"
else:
    raise SystemExit("this has changed: the assembly is done")
PYTHON
