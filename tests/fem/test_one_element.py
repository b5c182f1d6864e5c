"""Bodies of one element whose nodes all belong to interfaces: their constraint modes are all their motions."""

import numpy as np
import pytest

import kanefe as kf
from kanefe_fem import Material, Rectangle, beam_body, box_mesh, solid_body, straight_beam

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
SECTION = Rectangle(0.05, 0.02)
ENDS = {"root": "clamped", "tip": "rigid"}


def chain(bodies: int, stiffening: str = "none") -> tuple[kf.System, kf.Frame]:
    model = straight_beam(1.0 / bodies, SECTION, STEEL, elements=1, theory="euler-bernoulli")
    body = beam_body(model, ENDS, reduction=kf.CraigBampton(modes=4), stiffening=stiffening)
    scene, parent = kf.System(), None
    for i in range(bodies):
        parent = scene.add_flexible_body(f"part {i}", body, parent=parent, joint=kf.Fixed()).interface("tip")
    return scene, parent


def test_statics_of_beams_are_exact():
    """P L^3 / 3 EI at the tip of one element; small against the length (1e-5), so that it is linear to 1e-9."""
    scene, tip = chain(1)
    scene.add_force(tip, (0, 0, 1.0))
    moved = kf.equilibrium(scene).deflection("part 0", "tip")[2]
    assert moved == pytest.approx(1.0 / (3.0 * 210e9 * 0.05 * 0.02**3 / 12.0), rel=1e-9)


@pytest.mark.parametrize(("bodies", "error"), [(2, 1e-3), (4, 1e-4)])
def test_chains_of_them_are_beams(bodies, error):
    """1.8751^2 sqrt(EI / rho A L^4): elements of a length h are off by (k h)^4 / 1440, and by rotary inertia, 5e-5."""
    scene, _ = chain(bodies)
    exact = 1.8751041**2 * np.sqrt(210e9 * 0.02**2 / 12.0 / 7850.0) / (2.0 * np.pi)
    assert kf.linearise(scene).modes().frequencies[0] == pytest.approx(exact, rel=error)


def test_chains_of_them_buckle():
    """pi^2 EI / 4 L^2; a cubic element is off by some (k h)^4 / 1440, 2e-5."""
    scene, tip = chain(4, "full")
    scene.add_force(tip, (-1.0, 0, 0))
    exact = np.pi**2 / 4.0 * 210e9 * 0.05 * 0.02**3 / 12.0
    assert kf.buckling(scene).factors[0] == pytest.approx(exact, rel=1e-4)


@pytest.mark.fenicsx
def test_a_brick_between_two_rigid_ends():
    """Linear: all of its eight nodes are of the ends; stretched by E A / L within the hold of its ends (nu = 0)."""
    mesh = box_mesh((1.0, 0.1, 0.1), (1, 1, 1), "hexahedron")
    soft = Material(E=1e6, nu=0.0, rho=1000.0)
    body = solid_body(mesh, soft, ENDS, reduction=kf.CraigBampton(modes=2), order=1, cache=False)
    assert body.free_count == 6
    scene = kf.System()
    member = scene.add_flexible_body("brick", body, joint=kf.Fixed())
    scene.add_force(member.interface("tip"), (1.0, 0, 0))
    assert kf.equilibrium(scene).deflection("brick", "tip")[0] == pytest.approx(1e-4, rel=1e-9)
