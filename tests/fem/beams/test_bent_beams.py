"""Beams that stiffen: with a mass on the tip, about a start that is no balance, and bent far beyond small slopes."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
from numpy.polynomial import Polynomial

import kanefe as kf
from kanefe.linear.unsettled import UnsettledWarning
from kanefe.tree.bent import bent_too_far
from kanefe.tree.stiffening_check import StiffeningWarning
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

SECTION = Rectangle(0.01, 0.01)
BEAM = straight_beam(  # EI = rho A = L = 1
    1.0, SECTION, Material(E=1.0 / SECTION.I_y, nu=0.3, rho=1e4), elements=10, planar=True
)
TIP_MASS, SPIN = 1.0, 3.0


def arm(stiffening: str, modes: int = 4) -> kf.FlexibleBody:
    return beam_body(
        BEAM, {"root": "clamped", "tip": "rigid"}, reduction=kf.CraigBampton(modes=modes), stiffening=stiffening
    )


def spun(body: kf.FlexibleBody) -> tuple[kf.System, kf.Frame, kf.Frame]:
    scene = kf.System()
    beam = scene.add_flexible_body("beam", body, joint=kf.Revolute("z", motion=kf.Motion.steady(SPIN)))
    tip = scene.add_rigid_body("tip", TIP_MASS, parent=beam.interface("tip"))
    return scene, beam, tip


def chord_frequencies() -> np.ndarray:
    """Return the frequencies in rad/s of the Euler-Bernoulli beam in its plane of rotation, by Ritz in polynomials."""
    x = Polynomial([0.0, 1.0])
    shapes = [x**n for n in range(2, 12)]
    tension = 0.5 * SPIN**2 * (1.0 - x**2) + TIP_MASS * SPIN**2

    def over(integrand: Polynomial) -> float:
        return float(integrand.integ()(1.0))

    M = np.array([[over(a * b) + TIP_MASS * a(1.0) * b(1.0) for b in shapes] for a in shapes])
    K = [[over(a.deriv(2) * b.deriv(2) + tension * a.deriv() * b.deriv()) for b in shapes] for a in shapes]
    return np.sqrt(scipy.linalg.eigvalsh(np.array(K) - SPIN**2 * M, M))


def test_a_mass_on_the_tip_stiffens_the_beam_that_spins() -> None:
    """The start is not stretched: small motions are about the balance of the spin all the same."""
    found = 2 * np.pi * kf.linearise(spun(arm("full"))[0]).modes().frequencies[:2]
    # shear and rotary inertia of 1 : 100, and the stretch of 1e-4: some 1e-4 each
    np.testing.assert_allclose(found, chord_frequencies()[:2], rtol=1e-3)


def test_what_stiffens_by_its_own_inertia_alone_is_told_of_what_it_carries() -> None:
    scene, beam, _ = spun(arm("inertial"))
    scene.add_force(beam.interface("tip"), (0.0, 1.0, 0.0))
    with pytest.warns(StiffeningWarning, match=r"'beam' has .* of body 'tip' at interface 'tip', the force on .*full"):
        scene.freeze()


def test_a_start_that_is_not_brought_to_balance_is_told_of(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("kanefe.linear.settled.ITERATIONS", 1)
    with pytest.warns(UnsettledWarning, match="equilibrium"):
        kf.linearise(spun(arm("full"))[0])


def test_a_body_bent_too_far_is_named_with_its_slope() -> None:
    scene = kf.System()
    beam = scene.add_flexible_body("beam", arm("full"), joint=kf.Revolute("z"))
    scene.add_force(beam.interface("tip"), lambda t: (0.0, 3.0 * t, 0.0), follows=True)
    with pytest.warns(kf.SimulationWarning):
        status = scene.simulate((0.0, 1.0), method="dop853").status
    assert status.kind == "failed"
    assert "'beam' is bent by slopes of 0." in status.reason
    assert "chain" in status.remedy
    assert "fewer modes" in status.remedy


@pytest.mark.parametrize("force", [5.418940176156, 10.818126309390207, 14.70926667743175], ids="{:.0f} N".format)
def test_round_off_of_modes_that_nothing_loads_is_no_lack_of_balance(force: float) -> None:
    aluminium = Material(E=70e9, nu=0.33, rho=2700.0)
    beam = straight_beam(1.0, SECTION, aluminium, elements=8)
    ends = {"root": "clamped", "tip": "rigid"}
    body = beam_body(beam, ends, reduction=kf.CraigBampton(modes=4), stiffening="full")
    scene = kf.System()
    member = scene.add_flexible_body("beam", body, joint=kf.Fixed())
    scene.add_rigid_body("tip", 1.0, 1e-3, parent=member.interface("tip"))
    scene.add_force(member.interface("tip"), (0.0, force, 0.0))
    bent = force / (3.0 * aluminium.E * SECTION.I_z)
    assert kf.equilibrium(scene).deflection("beam", "tip")[1] == pytest.approx(bent, rel=1e-3)


def test_small_bending_is_not_taken_for_too_much() -> None:
    scene = kf.System()
    scene.add_flexible_body("beam", arm("full"), joint=kf.Revolute("z"))
    model = scene.freeze()
    terms, tip = model.flexible_terms("beam"), arm("full").interface("tip")
    k = terms.body.free_count
    bent = np.linalg.solve(terms.body.stiffness[:k, :k], tip.motion[1, :k])
    q, u = model.initial_coordinates.copy(), model.initial_speeds
    told = []
    for slope in (0.0, 0.05, 0.5):
        q[terms.eta] = slope * bent / (tip.motion[5, :k] @ bent)
        told.append(bent_too_far(model.route, 0.0, q, u))
    assert told[:2] == ["", ""]
    assert "slopes of 0.5 rad" in told[2]
