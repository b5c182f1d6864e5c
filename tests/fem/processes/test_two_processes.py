"""Bodies made by two processes of MPI: the same as by one, and every failure ends both with one message."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import kanefe as kf
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.solids.body import solid_body
from repository import ROOT

pytestmark = [pytest.mark.mpi, pytest.mark.fenicsx, pytest.mark.gmsh]

ARM = ROOT / "meshes" / "arm.msh"
ALUMINIUM = Material(E=70e9, nu=0.33, rho=2700.0)
ENDS = {"root": "clamped", "tip": "rigid"}
KINDS = {
    "craig-bampton": (ENDS, kf.CraigBampton(modes=8, loads=("gravity",)), "none"),
    "stiffened": (ENDS, kf.CraigBampton(modes=4), "full"),
    "floating": ({"root": "rigid", "tip": "average"}, kf.CraigBampton(modes=6), "none"),
    "free": ({}, kf.FreeInterface(modes=6), "none"),
    "krylov": (ENDS, kf.Krylov(loads=("tip",), order=2), "none"),
    "automatic": (ENDS, kf.CraigBampton(modes="auto", up_to_frequency=500.0), "none"),
}
BY_MULTIGRID = ("craig-bampton", "floating")

SCRIPT = """
import sys
sys.path[:0] = {path!r}
from kanefe_fem import _fenicsx
comm = _fenicsx.world()
assert comm.size == 2, comm.size
from test_two_processes import ALUMINIUM, ARM, KINDS
from kanefe_fem.solids.body import solid_body
ends, reduction, stiffening = KINDS[{kind!r}]
options = dict(order=1)
{change}
body = solid_body(ARM, ALUMINIUM, ends, reduction, stiffening=stiffening, cache=False, comm=comm, **options)
assert (body is None) == (comm.rank > 0)
if body is not None:
    body.save({out!r})
"""


def launcher() -> list[str]:
    """Return the command that starts two processes, with the MPI of this Python."""
    beside = Path(sys.executable).with_name("mpirun")
    found = str(beside) if beside.exists() else shutil.which("mpirun", path="/usr/bin:/usr/local/bin")
    if found is None:
        pytest.skip("there is no mpirun")
    is_open = "Open MPI" in subprocess.run([found, "--version"], capture_output=True, text=True, timeout=60).stdout
    as_root = ["--allow-run-as-root", "--oversubscribe"] if is_open else []
    return [found, *(as_root if os.geteuid() == 0 else as_root[1:]), "-n", "2", sys.executable]


def started(code: str, seconds: float = 240.0) -> subprocess.CompletedProcess[str]:
    """Run a script on two processes that leave their cores to each other while they wait."""
    environment = {**os.environ, "OMPI_MCA_mpi_yield_when_idle": "1", "OMP_NUM_THREADS": "1"}
    return subprocess.run(
        [*launcher(), "-c", code], capture_output=True, text=True, timeout=seconds, cwd=ROOT, env=environment
    )


def script(kind: str, out: Path, change: str = "") -> str:
    path = [str(ROOT), str(ROOT / "fem"), str(ROOT / "tests" / "shared"), str(Path(__file__).parent)]
    return SCRIPT.format(path=path, kind=kind, out=str(out), change=change)


@pytest.mark.parametrize("kind", KINDS)
def test_the_body_is_that_of_one_process(kind: str, tmp_path: Path) -> None:
    done = started(script(kind, tmp_path / "body.npz"))
    assert done.returncode == 0, done.stderr
    two = kf.FlexibleBody.load(tmp_path / "body.npz")
    ends, reduction, stiffening = KINDS[kind]
    one = solid_body(ARM, ALUMINIUM, ends, reduction, stiffening=stiffening, order=1, cache=False)
    assert np.array_equal(two.nodes, one.nodes)
    assert two.provenance["processes"]["count"] == 2
    assert 0.0 < two.provenance["processes"]["residuals"]["statics"] < 1e-8
    # differences of two compliances of a patch, whose rows come from both processes
    assert two.provenance["tie_errors"] == pytest.approx(one.provenance["tie_errors"], rel=1e-6)
    pairs = {"stiffness": (two.stiffness, one.stiffness), "basis": (two.basis, one.basis)}
    pairs |= {name: (getattr(two.moments, name), getattr(one.moments, name)) for name in ("second", "shape_product")}
    if stiffening != "none":
        pairs["quadratic"] = two.moments.quadratic_first, one.moments.quadratic_first
    for name, (ours, theirs) in pairs.items():
        np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=1e-9 * np.abs(theirs).max(), err_msg=name)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", BY_MULTIGRID)
def test_the_body_by_multigrid_is_that_by_factors(kind: str, order: int, tmp_path: Path) -> None:
    change = f"options = dict(order={order}, solver='multigrid')"
    done = started(script(kind, tmp_path / "body.npz", change))
    assert done.returncode == 0, done.stderr
    two = kf.FlexibleBody.load(tmp_path / "body.npz")
    ends, reduction, _ = KINDS[kind]
    one = solid_body(ARM, ALUMINIUM, ends, reduction, order=order, solver="direct", cache=False)
    modes = [[mode["frequency"] for mode in body.provenance["reduction"]["modes"]] for body in (two, one)]
    np.testing.assert_allclose(*modes, rtol=1e-10)  # residuals of 5e-7, whose square is the error of frequencies
    np.testing.assert_allclose(two.frequencies, one.frequencies, rtol=1e-6)
    assert 0.0 < two.provenance["processes"]["residuals"]["modes"] <= 1e-6


FAILURES = {
    "a group that is not there": ("ends = {'rood': 'clamped'}", "rood"),
    "a file that is not there": ("ARM = 'none.msh'", "none.msh"),
    "what one process does alone": ("reduction = None", "reduction=None"),
    "another version": (
        "from kanefe_fem.processes import team\nif comm.rank:\n"
        "    own = team.versions_here()\n    team.versions_here = lambda: {**own, 'numpy': '0.1'}",
        "process 2 of 2",
    ),
    "an error on the second process": (
        "def fails(team, own):\n    if team.rank: raise MemoryError('full')\n"
        "from kanefe_fem.processes.team import led\nled(comm, lambda team: team.run(fails))",
        "MemoryError: full",
    ),
}


@pytest.mark.parametrize("what", FAILURES)
def test_a_failure_ends_both_with_one_message(what: str, tmp_path: Path) -> None:
    change, said = FAILURES[what]
    code = script("craig-bampton", tmp_path / "body.npz", change)
    done = started(code, 120.0)
    assert done.returncode != 0
    assert said in done.stderr
    assert done.stderr.count("Traceback") == 1, done.stderr
    assert not (tmp_path / "body.npz").exists()
