"""Importing the packages loads nothing heavy, and scenes run end to end where the heavy packages are missing."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from repository import surroundings

HEAVY = ("dolfinx", "petsc4py", "mpi4py", "gmsh", "matplotlib", "h5py", "pyvista", "numba")

# A finder that comes before all others and refuses the heavy packages (all but numba, as the issue has it).
BLOCK = f"""
import sys

class Block:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {[name for name in HEAVY if name != "numba"]!r}:
            raise ImportError(name + " is blocked")

sys.meta_path.insert(0, Block())
"""

RUN = """
import numpy as np
import kanefe as kf

def run(body):
    scene = kf.System(gravity=(0, 0, -9.81))
    hub = scene.add_rigid_body("hub", mass=4.0, inertia=0.05, joint=kf.Revolute("z"))
    arm = scene.add_flexible_body("arm", body, parent=hub, at=(0.1, 0, 0))
    scene.add_rigid_body("tip", mass=0.5, inertia=1e-3, parent=arm.interface("tip"))
    scene.add_torque(hub, lambda t: 2.0 * np.sin(3 * t))
    result = scene.simulate((0.0, 0.1), rtol=1e-8, output_step=0.001)
    energy = result.energy
    total = energy.kinetic + energy.elastic + energy.gravity + energy.dissipated - energy.work
    # at looser tolerances the vibrations of the sudden start are damped
    assert abs(total - total[0]).max() < 1e-2 * abs(energy.work).max() + 1e-6, total
    force = result.coupling_force("arm", "root")
    assert force.shape == (101, 6) and np.all(np.isfinite(force))
    return result.position("tip")
"""

BEAMS = """
from kanefe_fem.beams.body import beam_body, straight_beam
from kanefe_fem.beams.sections import Tube
from kanefe_fem.materials.isotropic import Material

bar = straight_beam(1.0, Tube(0.04, 0.002), Material(E=70e9, nu=0.33, rho=2700.0), elements=8)
ends = {"root": "clamped", "tip": "rigid"}
body = beam_body(bar, ends, reduction=kf.CraigBampton(modes=4), damping=kf.ModalDamping(0.02))
"""


def python(code: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run code in a fresh interpreter that finds this repository's packages."""
    return subprocess.run(
        [sys.executable, "-W", "error::ImportWarning", "-c", code, *arguments],
        capture_output=True,
        text=True,
        env=surroundings(),
        timeout=120,
        check=False,
    )


def loaded_by(code: str) -> list[str]:
    """Return what a program prints: the modules that it has loaded."""
    done = python(code)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


@pytest.mark.parametrize("package", ["kanefe", "kanefe_fem"])
def test_importing_loads_nothing_heavy(package: str) -> None:
    done = python(f"import sys, {package}; print(*sorted({{name.partition('.')[0] for name in sys.modules}}))")
    assert done.returncode == 0, done.stderr
    loaded = set(done.stdout.split())
    assert package in loaded
    assert not loaded & set(HEAVY)
    assert not loaded & {"numpy", "scipy", "typer", "tqdm", "meshio"}


def test_a_run_of_rigid_bodies_does_without_scipy() -> None:
    done = python(
        "import sys\n"
        "import kanefe as kf\n"
        "scene = kf.System(gravity=(0, 0, -9.81))\n"
        "arm = scene.add_rigid_body('arm', 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute('y'))\n"
        "scene.add_rigid_body('rod', 1.0, 0.1, parent=arm, at=(1, 0, 0), joint=kf.Revolute('z'))\n"
        "model = scene.freeze()\n"
        "assert model.rhs(0.0, model.initial_state).any()\n"
        "for method in ('auto', 'dopri5'): scene.simulate((0.0, 0.01), method=method).position('rod')\n"
        "print(*sorted({name.partition('.')[0] for name in sys.modules}))"
    )
    assert done.returncode == 0, done.stderr
    assert not set(done.stdout.split()) & {"scipy", "tqdm"}


SPATIAL = """
import sys
import numpy
before = set(sys.modules)
import kanefe as kf
scene = kf.System(gravity=(0, 0, -9.81))
arm = scene.add_rigid_body("arm", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("y"))
scene.add_rigid_body("rod", 1.0, 0.1, parent=arm, at=(1, 0, 0), joint=kf.Revolute("z"))
model = scene.freeze()
assert model.rhs(0.0, model.initial_state).any()
print(*sorted(set(sys.modules) - before))
"""

# Beginnings of the names of modules: what trees of bodies without contacts, loops, stops and friction have no part in.
NOT_OF_TREES = (
    "kanefe.constraints.",
    "kanefe.contact.",
    "kanefe.integrate.checkpoint",
    "kanefe.literal.contact_instant",
    "kanefe.literal.contact_forces",
    "kanefe.literal.impact_steps",
    "kanefe.loads.bushing",
    "kanefe.loads.coordinate_friction",
    "kanefe.loads.coordinate_stop",
    "kanefe.loads.field_load",
    "kanefe.loads.spring",
    "kanefe.order_n.granular_contacts",
    "kanefe.unreduced",
)
# The same of such trees of rigid bodies without loads, of which one right-hand side is asked for.
NOT_OF_RIGID = (
    *NOT_OF_TREES,
    "kanefe.bodies.flexible",
    "kanefe.bodies.mass_moments",
    "kanefe.bodies.unreduced",
    "kanefe.fe_model",
    "kanefe.integrate",
    "kanefe.kane.assemble",
    "kanefe.states.constraints",
    "kanefe.literal.consistent_start",
    "kanefe.literal.loop_closure",
    "kanefe.loads.controller",
    "kanefe.loads.joint_load",
    "kanefe.loads.point_load",
    "kanefe.results",
    "difflib",
    "platform",
)


def test_a_first_right_hand_side_imports_nothing_that_the_scene_has_not() -> None:
    loaded = loaded_by(SPATIAL)
    assert "kanefe.order_n.route" in loaded
    assert not [name for name in loaded if name.startswith(NOT_OF_RIGID)]


def test_a_run_of_a_flexible_arm_imports_no_contacts_and_no_constraints() -> None:
    loaded = loaded_by(RUN + BEAMS + "run(body)\nimport sys\nprint(*sorted(sys.modules))")
    assert "kanefe.results.channels" in loaded
    assert not [name for name in loaded if name.startswith(NOT_OF_TREES)]


def test_a_run_with_a_spring_imports_no_contacts() -> None:
    spring = 'scene.add_spring("spring", scene.ground, arm.frame(at=(1, 0, 0)), stiffness=10.0, rest_length=0.5)\n'
    run = "scene.simulate((0.0, 0.01))\nprint(*sorted(sys.modules))"
    loaded = loaded_by(SPATIAL.partition("model =")[0] + spring + run)
    assert "kanefe.loads.spring" in loaded
    of_contacts = "kanefe.contact.", "kanefe.kernels.contact.laws", "kanefe.literal.impulses"
    assert not [name for name in loaded if name.startswith(of_contacts)]


def test_a_worker_of_a_study_over_springs_at_joints_imports_no_scipy() -> None:
    """Each process of a study pays for its imports, and scipy takes as long as some hundred short runs."""
    spring = "kf.Revolute('z', forces=kf.CoordinateForce(stiffness=9.0, damping=0.1))"
    scene = f"scene = kf.System()\nscene.add_rigid_body('weight', 1.0, 0.1, joint={spring})\n"
    imports = "import sys, kanefe.studies.workers.work\nimport kanefe as kf\n"
    loaded = loaded_by(f"{imports}{scene}scene.simulate((0.0, 0.1))\nprint(*sys.modules)")
    assert "kanefe.studies.workers.work" in loaded
    assert not [name for name in loaded if name.startswith("scipy")]


def test_an_equilibrium_imports_no_contacts_no_runs_and_no_other_analysis() -> None:
    rest = "kf.equilibrium(scene)\nprint(*sorted(sys.modules))"
    spring = "scene.add_rigid_body('weight', 1.0, joint=kf.Prismatic('z', forces=kf.CoordinateForce(stiffness=9.0)))\n"
    loaded = loaded_by(SPATIAL.partition("arm =")[0] + spring + rest)
    assert "kanefe.linear.equilibrium.equilibria" in loaded
    others = ("floquet", "frequency_response", "linearisation", "over_speed", "sampled", "stability")
    not_of_rest = ("kanefe.contact.contact", "kanefe.contact.rigid", "kanefe.integrate.run", "scipy.optimize")
    not_of_rest += tuple(f"kanefe.linear.{name}" for name in others)
    found = [name for name in loaded if name.startswith(not_of_rest) and "run_checks" not in name]
    assert not found, found


def test_public_names_load_nothing_heavy_either() -> None:
    done = python(
        "import sys, kanefe\n"
        "for name in kanefe.__all__: getattr(kanefe, name)\n"
        "print(*sorted({name.partition('.')[0] for name in sys.modules}))"
    )
    assert done.returncode == 0, done.stderr
    assert not set(done.stdout.split()) & set(HEAVY)


def test_the_block_blocks() -> None:
    done = python(BLOCK + "import h5py")
    assert "h5py is blocked" in done.stderr


def test_a_scene_of_beams_runs_without_the_heavy_packages() -> None:
    done = python(BLOCK + RUN + BEAMS + "run(body)\nprint('end')")
    assert done.returncode == 0, done.stderr
    assert done.stdout == "end\n"


def test_a_scene_with_a_body_from_its_file_runs_without_the_heavy_packages(tmp_path: Path) -> None:
    path = str(tmp_path / "arm.npz")
    made = python(RUN + BEAMS + "import sys\nbody.save(sys.argv[1])\nprint(*run(body)[-1].tolist())", path)
    assert made.returncode == 0, made.stderr
    # in a process that never sees kanefe_fem
    loaded = python(
        BLOCK + RUN + "import sys\n"
        "print(*run(kf.FlexibleBody.load(sys.argv[1]))[-1].tolist())\n"
        "assert not any(name.startswith('kanefe_fem') for name in sys.modules)",
        path,
    )
    assert loaded.returncode == 0, loaded.stderr
    assert loaded.stdout == made.stdout  # the same numbers, bit for bit


@pytest.mark.parametrize(
    ("call", "package"),
    [("result.save('run.h5')", "h5py"), ("result.plot()", "matplotlib")],
)
def test_what_needs_a_missing_package_says_so(call: str, package: str, tmp_path: Path) -> None:
    code = (
        f"import os; os.chdir({str(tmp_path)!r})\n"
        "scene = kf.System(); scene.add_rigid_body('b', 1.0, 0.1, joint=kf.Revolute('z', speed=1.0))\n"
        "result = scene.simulate((0.0, 0.1))\n"
        f"try:\n    {call}\nexcept kf.MissingDependency as error:\n    print(error)"
    )
    done = python(BLOCK + "import kanefe as kf\n" + code)
    assert done.returncode == 0, done.stderr
    assert f"needs {package}, which is not installed. Remedy:" in done.stdout
    assert not list(tmp_path.iterdir())  # nothing half-written


def test_a_package_of_public_names_is_there_at_once():
    code = "import kanefe as kf; print(kf.studies.peak.__name__, 'studies' in kf.__all__)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=surroundings(), check=False)
    assert done.stdout == "peak False\n", done.stderr
