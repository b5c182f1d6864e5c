#!/usr/bin/env bash
# mpirun of one MPI with a Python of another starts as many runs of size 1, without a word: MPICH's mpirun (of PyPI's dolfinx, or
# apt's mpich) with Debian's mpi4py, which is built on Open MPI. Each of them would do all of the work, and write the same file.
# The number of processes is then in PMI_SIZE alone.
# Seen: size 1 and PMI_SIZE 2, twice.
set -euo pipefail
mpich=${MPICH_MPIRUN:-$(command -v mpirun.mpich || true)}
[[ -n "$mpich" ]] && /usr/bin/python3 -c "import mpi4py" 2> /dev/null ||
  { echo "needs apt install python3-mpi4py openmpi-bin, and MPICH_MPIRUN=PATH of an mpirun of MPICH"; exit 2; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
code="import os; from mpi4py import MPI; print('size', MPI.COMM_WORLD.size, 'PMI_SIZE', os.environ.get('PMI_SIZE'))"
OMPI_MCA_ess_singleton_isolated=1 "$mpich" -n 2 /usr/bin/python3 -c "$code" | tee found
[[ $(sort -u found) == "size 1 PMI_SIZE 2" && $(wc -l < found) == 2 ]] || { echo "this has changed"; exit 1; }
