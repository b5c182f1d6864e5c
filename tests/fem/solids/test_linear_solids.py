"""Linear analysis of bodies from meshes, reduced and stiffened by their spin: against D03a and runs."""

import numpy as np
import pytest
import scipy.linalg

import kanefe as kf
from kanefe.checks.verification.references import load_references
from kanefe_fem import Material, solid_body
from kanefe_fem.mesh.simple import box_mesh
from linear_scenes import run_beside

pytestmark = pytest.mark.fenicsx

TWO_PI = 2.0 * np.pi


def test_a_campbell_diagram_of_a_blade_from_a_mesh_d03a():
    """Flap and chord of one body about its stretched steady state."""
    side = 1.0 / 150.0
    mesh = box_mesh((1.0, side, side), (75, 1, 1), "hexahedron", start=(0.0, -side / 2, -side / 2))
    material = Material(E=12.0 / side**4, nu=0.0, rho=1.0 / side**2)  # EI = rho A = 1
    body = solid_body(
        mesh, material, {"root": "clamped", "tip": "rigid"}, reduction=kf.CraigBampton(modes=20), stiffening="inertial"
    )

    def build(speed: float) -> kf.System:
        scene = kf.System()
        scene.add_flexible_body("blade", body, joint=kf.Revolute("z", motion=kf.Motion.steady(speed)))
        return scene

    reference = load_references()["D03a"].values
    speeds = [float(name.split("gamma=")[1]) for name in reference]
    diagram = kf.campbell(build, speeds, modes=6)
    exact = np.array([np.sort(case["flap"] + case["chord"]) for case in reference.values()])
    # 75 elements are 2.7e-4 too stiff for the third pair of modes
    np.testing.assert_allclose(np.sort(TWO_PI * diagram.frequencies, axis=1), exact, rtol=5e-4)
    assert diagram.correlations.min() > 0.99
    assert not diagram.grows.any()
    # flap is faster than chord by the spin: w_flap^2 = w_chord^2 + W^2
    squares = np.sort((TWO_PI * diagram.frequencies) ** 2, axis=1)
    np.testing.assert_allclose(squares[:, 1] - squares[:, 0], diagram.speeds**2, rtol=1e-3, atol=1e-4)
    steady = kf.equilibrium(build(12.0))
    assert steady.deflection("blade", "tip")[0] == pytest.approx(12.0**2 * side**2 / 36.0, rel=1e-3)


def spun_blade(stiffening: str) -> kf.System:
    """Return a soft blade with a weight at its tip, set at an angle on a hub that spins: it bends, and is stiffened."""
    mesh = box_mesh((0.5, 0.04, 0.02), (8, 1, 1), "hexahedron", start=(0.0, -0.02, -0.01))
    body = solid_body(
        mesh,
        Material(E=2e7, nu=0.3, rho=1000.0),
        {"root": "clamped", "tip": "rigid"},
        reduction=kf.CraigBampton(modes=2),
        stiffening=stiffening,
    )
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    hub = scene.add_frame("hub", joint=kf.Revolute("z", motion=kf.Motion.steady(12.0)))
    pitch = (np.cos(0.3), np.sin(0.3), 0.0, 0.0)
    blade = scene.add_flexible_body("blade", body, parent=hub, at=(0.1, 0.02, 0.0), orientation=pitch)
    scene.add_rigid_body("weight", 0.1, 1e-5, parent=blade.interface("tip"))
    return scene


def test_a_run_beside_the_bent_steady_state_is_what_a_says():
    found = kf.equilibrium(spun_blade("full"))
    small = found.linearise()
    assert small.is_exact
    assert np.abs(found.deflection("blade", "tip")[1:3]).max() > 5e-3
    stop, size = 0.05, 1e-5
    expected = scipy.linalg.expm(small.A * stop)
    scale = np.abs(expected).max(axis=0)
    for i in (0, 1, 2, small.position_count + 1):
        x = size / scale[i] * np.eye(len(small.A))[i]
        beside = 0.5 * (run_beside(small, x, stop) - run_beside(small, -x, stop)) * scale[i] / size
        np.testing.assert_allclose(beside / scale[i], expected[:, i] / scale[i], atol=1e-5)


def test_stiffening_by_a_spin_raises_frequencies():
    stiff, soft = (kf.equilibrium(spun_blade(level)).linearise().modes().frequencies for level in ("full", "none"))
    assert stiff[0] > 1.2 * soft[0]
