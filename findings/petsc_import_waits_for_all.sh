#!/usr/bin/env bash
# "from petsc4py import PETSc" waits under mpirun until all processes have come to it (petsc4py 3.18 and Open MPI 4.1 of Debian 12):
# PetscInitialize works with all of MPI.COMM_WORLD. A program in which one process imports dolfinx, and the others first wait for
# a message of it, hangs without a word. The documentation of petsc4py does not say so.
# Seen: the first process imports for as long as the second one sleeps.
set -euo pipefail
python=/usr/bin/python3
command -v /usr/bin/mpirun > /dev/null && $python -c "import importlib.util as u, sys; sys.exit(u.find_spec('petsc4py') is None)" ||
  { echo "needs apt install python3-petsc4py openmpi-bin"; exit 2; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
cat > two.py <<'PYTHON'
import time

from mpi4py import MPI

SLEEP = 5.0
if MPI.COMM_WORLD.rank:
    time.sleep(SLEEP)
start = time.monotonic()
from petsc4py import PETSc

if MPI.COMM_WORLD.rank == 0:
    waited = time.monotonic() - start
    print(f"petsc4py {'.'.join(map(str, PETSc.Sys.getVersion()))}: imported after {waited:.1f} s, the other slept {SLEEP} s")
    assert waited > 0.8 * SLEEP, "this has changed"
PYTHON
root=()
[[ $EUID -ne 0 ]] || root=(--allow-run-as-root)
/usr/bin/mpirun "${root[@]}" --oversubscribe -n 2 $python two.py
