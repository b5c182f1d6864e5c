#!/usr/bin/env bash
# setup.sh [test|dev]: Debian's FEniCSx and gmsh, and .venv on top of them, with what runs and compiles kanefe; with test also
# what the tests need, with dev also ruff, mypy and pre-commit. Idempotent: with everything in place it only compares fingerprints.
set -euo pipefail
cd "$(dirname "$0")/.."
. .ci/common.sh

python=/usr/bin/python3
# What pip's packages are fitted to: with these in place pip works while apt installs the rest, each on one core. scipy is not
# among them, and comes by dolfinx: asked for before it, apt brings another OpenBLAS beside the serial one.
# OpenBLAS is 5 to 6 times faster here than Debian's default BLAS; its serial build does not fight with MPI over the cores.
packages_first=(python3 python3-venv python3-numpy libopenblas0-serial)
# libegl1 and libgl1-mesa-dri draw the pictures of reports where there is no screen.
packages=(python3-dolfinx python3-dolfinx-real python3-gmsh python3-h5py gcc libc6-dev libegl1 libgl1-mesa-dri)
elsewhere="elsewhere 'pip install .' in an environment of Python 3.11-3.13 gives everything but mesh assembly, then: kanefe demo --body beam"

check_system() {
  on_debian || die "this set-up needs apt-get, that is Debian 12 or newer; $elsewhere"
  local ID='' VERSION_ID='' PRETTY_NAME='this system'
  . /etc/os-release
  if [ "$ID" = debian ] && [ "${VERSION_ID:-99}" -lt 12 ]; then
    die "$PRETTY_NAME is too old for FEniCSx: Debian 12 (bookworm) is the oldest that has it; $elsewhere"
  fi
  [ "$ID" = debian ] || say "warning: tried on Debian 12 and 13 only, this is $PRETTY_NAME"
}

check_python() {
  [ -x "$python" ] || die "$python is missing although Debian's python3 is installed; repair it with: apt-get install --reinstall python3-minimal"
  "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
    die "$python is $("$python" --version 2>&1), but kanefe needs Python 3.11 or newer; use Debian 12 or newer"
}

# Debian's dolfinx is compiled against Debian's numpy, so pip must never bring another one.
write_constraints() {
  "$python" - <<'PYTHON' >.venv/constraints.txt
from importlib.metadata import distributions

frozen = {"numpy", "scipy", "mpi4py", "petsc4py", "slepc4py", "cffi", "sympy", "fenics-basix", "fenics-dolfinx",
          "fenics-ffcx", "fenics-ufl"}
for name, version in sorted({(d.metadata["Name"].lower(), d.version) for d in distributions()}):
    if name in frozen:
        print(f"{name}=={version}")
PYTHON
  grep -q '^numpy==' .venv/constraints.txt || die "$python has no numpy of Debian's; repair it with: apt-get install --reinstall python3-numpy"
}

# Debian's h5py goes by a name that pip does not know (h5py.-debian-h5py-serial), and PyPI's brings a second HDF5 that
# cannot live in one process with dolfinx's: so it is taken off the list, as scipy is, which apt may still be bringing. $1 is an
# extra.
write_requirements() {
  "$python" - "$1" <<'PYTHON'
import re, sys, tomllib

project = tomllib.load(open("pyproject.toml", "rb"))["project"]
for requirement in project["dependencies"] + project["optional-dependencies"][sys.argv[1]]:
    if re.split(r"[^\w-]", requirement)[0] not in ("h5py", "scipy", project["name"]):
        print(requirement)
PYTHON
}

install_project() {
  write_requirements "$1" >".venv/requirements-$1.txt"
  pip_install .venv/bin/python -c .venv/constraints.txt -r ".venv/requirements-$1.txt"
}

check_environment() {
  quietly check .venv/bin/python -c '
from importlib.metadata import distribution
import numpy, scipy, dolfinx, gmsh, h5py, petsc4py
for line in open(".venv/constraints.txt"):
    name, version = line.strip().split("==")
    if distribution(name).version != version:
        raise SystemExit(f"{name} is {distribution(name).version}, not the {version} of Debian")
for module in (numpy, scipy, dolfinx, gmsh, h5py):
    if not module.__file__.startswith("/usr/lib/"):
        raise SystemExit(f"{module.__name__} comes from {module.__file__}, not from Debian")
' || die "the environment .venv is not sound; run 'make clean' and this again, and if it stays so: apt-get install --reinstall python3-numpy python3-dolfinx"
  say "using $(.venv/bin/python -c '
import dolfinx, gmsh, numpy, scipy
print(f"dolfinx {dolfinx.__version__}, gmsh {gmsh.__version__}, numpy {numpy.__version__}, scipy {scipy.__version__}")' 2>/dev/null | tail -n 1), BLAS $(readlink -f "/usr/lib/$(uname -m)-linux-gnu/libblas.so.3")"
}

# add_extra EXTRA: what it names in pyproject.toml, once.
add_extra() {
  up_to_date .venv ".kanefe-$1" "$wanted" && return 0
  say "adding the extra $1 to .venv"
  install_project "$1"
  echo "$wanted" >".venv/.kanefe-$1"
}

make_venv() {
  check_system
  install_packages "${packages_first[@]}"
  check_python
  install_packages "${packages[@]}" &
  beside=$!
  make_environment "$python" .venv --system-site-packages
  write_constraints
  install_project compile
  pip_install .venv/bin/python --no-deps -e .
  wait "$beside" || exit 1
  beside=
  write_constraints
  check_environment
  echo "$wanted" >.venv/.kanefe-compile
  say "set-up done in $SECONDS s"
}

lock
wanted=$(fingerprint .ci/setup.sh pyproject.toml)
if on_debian && [ -z "$(missing_packages "${packages_first[@]}" "${packages[@]}")" ] && up_to_date .venv .kanefe-compile "$wanted"; then
  [ $# -gt 0 ] || say "set-up is in place"
else
  make_venv
fi
case ${1:-} in
  test) add_extra test ;;
  dev)
    add_extra test
    add_extra dev
    ;;
esac
