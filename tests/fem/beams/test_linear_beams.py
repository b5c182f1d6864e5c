"""Linear analysis of scenes of beams, against references of B09, D03a, D04a, D05, E02a and G05.

The verification cases B03a, B04a, D03a, D04a, D04b, D05 and G05 are themselves made of `linearise` and `equilibrium`.
"""

import numpy as np
import pytest

import kanefe as kf
from kanefe.checks.verification.references import load_references
from kanefe_fem.beams.body import beam_body, straight_beam
from kanefe_fem.beams.sections import Rectangle, SolidCircle
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.verification.beam_frequencies import unit_beam
from kanefe_fem.verification.beam_statics import beam_bar
from kanefe_fem.verification.stiffened_beams import thin_beam
from steel_beams import STEEL

TWO_PI = 2.0 * np.pi


@pytest.mark.parametrize("count", ["0", "4"])
def test_a_reduced_beam_b09(count):
    scene = kf.System()
    scene.add_flexible_body("beam", unit_beam(32, {"root": "clamped", "tip": "rigid"}, modes=int(count)))
    expected = load_references()["B09"].values[count]["cantilever"]
    found = TWO_PI * kf.linearise(scene).modes().frequencies[: len(expected)]
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def blade(stiffening: str, modes: int = 14) -> kf.FlexibleBody:
    return beam_body(thin_beam(20), {"root": "clamped"}, reduction=kf.CraigBampton(modes=modes), stiffening=stiffening)


@pytest.mark.parametrize(("axis", "kind"), [("y", "flap"), ("z", "chord")])
def test_a_rotating_blade_d03a(axis, kind):
    """The Campbell diagram of the blade about its stretched steady state."""
    body = blade("inertial")

    def build(speed: float) -> kf.System:
        scene = kf.System()
        scene.add_flexible_body("blade", body, joint=kf.Revolute(axis, motion=kf.Motion.steady(speed)))
        return scene

    reference = load_references()["D03a"].values
    speeds = sorted(float(name.split("gamma=")[1]) for name in reference)
    diagram = kf.campbell(build, speeds, modes=3)
    exact = {float(name.split("gamma=")[1]): case[kind] for name, case in reference.items()}
    # the bar stretches by (speed / 1e4)^2; elements of 1/20 give the third frequency to 1e-4, as the case has it
    np.testing.assert_allclose(TWO_PI * diagram.frequencies, [exact[speed] for speed in speeds], rtol=1e-3)
    np.testing.assert_allclose(TWO_PI * diagram.frequencies[:, 0], [exact[s][0] for s in speeds], rtol=1e-4)


def test_a_blade_without_stiffening_leaves_its_place_d05():
    body = beam_body(thin_beam(10), {"root": "clamped"}, reduction=kf.CraigBampton(modes=4))

    def build(speed: float) -> kf.System:
        scene = kf.System()
        scene.add_flexible_body("blade", body, joint=kf.Revolute("z", motion=kf.Motion.steady(speed)))
        return scene

    diagram = kf.campbell(build, np.linspace(0.0, 5.0, 11), modes=1)
    first = float(load_references()["D05"].values["0"][0])
    squares = (TWO_PI * diagram.frequencies[:8, 0]) ** 2
    np.testing.assert_allclose(squares, first**2 - diagram.speeds[:8] ** 2, atol=1e-4)
    assert diagram.grows[:, 0].tolist() == (diagram.speeds > first).tolist()
    (critical,) = diagram.critical_speeds(order=0)
    assert critical.speed == pytest.approx(first, rel=1e-5)  # ten elements


def test_a_whirling_shaft_d04a():
    """Backward and forward whirl, seen from the shaft: followed over the speed, each in its column."""
    beams = straight_beam(
        1.0, SolidCircle(0.05), Material(E=210e9, nu=0.3, rho=7850.0), elements=24, theory="euler-bernoulli"
    )
    supports = {"root": kf.Interface(fixed=("x", "y", "z", "rx")), "tip": kf.Interface(fixed=("y", "z"))}
    body = beam_body(beams, supports, reduction=kf.CraigBampton(modes=12), stiffening="inertial")

    def build(speed: float) -> kf.System:
        scene = kf.System()
        scene.add_flexible_body("shaft", body, joint=kf.Revolute("x", motion=kf.Motion.steady(speed)))
        return scene

    whirl = {float(spin): pairs for spin, pairs in load_references()["D04a"].values["whirl"].items()}
    speeds = sorted(whirl)
    diagram = kf.campbell(build, speeds, modes=4)
    found = np.sort(TWO_PI * diagram.frequencies, axis=1)
    expected = [np.sort(np.concatenate([pair["rotframe"] for pair in whirl[speed][:2]])) for speed in speeds]
    np.testing.assert_allclose(found, expected, rtol=1e-4)
    slopes = np.diff(diagram.eigenvalues.imag, axis=0) / np.diff(speeds)[:, None]
    # each goes on falling or rising with the speed, none jumps to another
    assert np.all(np.abs(np.abs(slopes) - 1.0) < 0.02)
    assert np.all(np.sign(slopes) == np.sign(slopes[0]))


def test_a_spinning_bar_stretches_e02a():
    values = load_references()["E02a"].values
    scene = kf.System()
    bar = beam_bar({"root": "clamped", "tip": "rigid"})
    scene.add_flexible_body("bar", bar, joint=kf.Revolute("y", motion=kf.Motion.steady(100.0)))
    found = kf.equilibrium(scene)
    assert found.deflection("bar", "tip")[0] == pytest.approx(values["tip_softened"], rel=1e-6)
    assert found.imbalance.ratio < 1e-9


def test_an_elastica_bends_g05():
    """A cantilever in eight linear bodies under a tip load of EI / L^2."""
    body = beam_body(
        thin_beam(2, 1.0 / 8),
        {"root": "clamped", "tip": "rigid"},
        reduction=kf.CraigBampton(modes=0),
        stiffening="full",
    )
    scene = kf.System()
    last = scene.add_flexible_body("0", body)
    for number in range(1, 8):
        last = scene.add_flexible_body(str(number), body, parent=last.interface("tip"))
    scene.add_force(last.interface("tip"), (0.0, 1.0, 0.0))
    found = kf.equilibrium(scene)
    place = found.position("7", "tip")
    values = load_references()["G05"].values["1"]
    # the tolerance of the case
    assert place[:2] == pytest.approx((values["x_over_L"], values["deflection_over_L"]), abs=1e-4)
    assert found.iterations < 10
    K = found.linearise().stiffness
    np.testing.assert_allclose(K, K.T, atol=1e-8 * np.abs(K).max())


def steel_chain(count: int, force: float, stiffening: str = "none") -> kf.System:
    """Return a steel cantilever of 2 m by 50 x 100 mm in linear bodies, with a force across its tip."""
    model = straight_beam(2.0 / count, Rectangle(0.05, 0.1), STEEL, elements=4)
    ends = {"root": "clamped", "tip": "rigid"}
    body = beam_body(model, ends, reduction=kf.CraigBampton(modes=4), stiffening=stiffening)
    scene = kf.System()
    last = scene.add_flexible_body("0", body)
    for number in range(1, count):
        last = scene.add_flexible_body(str(number), body, parent=last.interface("tip"))
    scene.add_force(last.interface("tip"), (0.0, 0.0, force))
    return scene


@pytest.mark.parametrize("force", [1.0, 1000.0])
def test_a_stiff_cantilever_in_four_bodies_is_balanced(force):
    """Along their axes the bodies carry next to nothing: what is left there is small against round-off of places."""
    found = kf.equilibrium(steel_chain(4, force))
    area, inertia = 0.05 * 0.1, 0.05 * 0.1**3 / 12.0
    sag = force * (2.0**3 / (3.0 * STEEL.E * inertia) + 2.0 / (5.0 / 6.0 * STEEL.E / (2.0 * 1.3) * area))
    # the chain bends less than the straight beam by the square of sag / length
    assert found.position("3", "tip")[2] == pytest.approx(sag, rel=1e-8 + sag**2)


def test_statics_of_a_bent_stiffened_chain_asks_for_no_mass_matrix():
    """Where slopes are large its mass matrix may have lost positive definiteness; the elastica is met all the same."""
    found = kf.equilibrium(steel_chain(2, 1e5, "inertial"))
    load = 1e5 * 2.0**2 / (STEEL.E * 0.05 * 0.1**3 / 12.0)
    # two linear bodies meet the elastica to 0.5 %, shear adds 0.2 %
    assert found.position("1", "tip")[2] / 2.0 == pytest.approx(elastica_tip(load), rel=1e-2)


def elastica_tip(load: float) -> float:
    """Return the deflection over the length of a cantilever with a dead tip force of load EI / L^2.

    theta'' = -load cos(theta) from theta(0) = 0 and theta'(1) = 0 (Timoshenko & Gere, "Theory of Elastic Stability").
    """
    from scipy.integrate import solve_ivp
    from scipy.optimize import brentq

    def end(slope: float) -> np.ndarray:
        rates = lambda s, y: (y[1], -load * np.cos(y[0]), np.sin(y[0]))  # noqa: E731
        return solve_ivp(rates, (0.0, 1.0), (0.0, slope, 0.0), rtol=1e-10, atol=1e-12).y[:, -1]

    return float(end(brentq(lambda slope: end(slope)[1], 0.0, 2.0 * load))[2])


def test_the_frequency_response_of_a_beam_at_rest_is_its_flexibility():
    """At 0 Hz a tip force of 1 N bends the cantilever by L^3 / 3 EI."""
    scene = kf.System()
    scene.add_flexible_body("beam", unit_beam(10, {"root": "clamped", "tip": "rigid"}))
    small = kf.linearise(scene, inputs="force beam/tip y", outputs=["position beam/tip y", "deflection beam/tip y"])
    response = small.frequency_response([0.0]).response[0, :, 0]
    np.testing.assert_allclose(response, 1.0 / 3.0, rtol=1e-6)
