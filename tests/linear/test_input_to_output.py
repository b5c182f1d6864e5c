"""H2 norms and margins by closed forms, and of stable, lightly damped beams where python-control has none."""

import numpy as np
import pytest
import scipy.integrate
import scipy.signal

import kanefe as kf
from kanefe.errors import ModelError
from kanefe_fem import Material, Rectangle, beam_body, straight_beam


def oscillator(stiffness: float = 200.0, damping: float = 4.0, mass: float = 2.0) -> kf.System:
    scene = kf.System()
    forces = kf.CoordinateForce(stiffness=stiffness, damping=damping)
    scene.add_point("a", mass, joint=kf.Prismatic("x", forces=forces))
    return scene


def two_masses() -> kf.System:
    scene = oscillator()
    held = kf.CoordinateForce(stiffness=150.0, damping=1.0)
    scene.add_point("b", 1.0, parent=scene.body("a"), joint=kf.Prismatic("x", forces=held))
    return scene


def beam(modes: int) -> kf.Linearisation:
    """A cantilever with 1 % of damping in each mode; it also has axial modes, which a force along y does not move."""
    aluminium = Material(E=70e9, nu=0.33, rho=2700.0)
    line = straight_beam(2.0, Rectangle(width=0.01, height=0.01), aluminium, elements=60, planar=True)
    ends = {"root": "clamped", "tip": "rigid"}
    scene = kf.System()
    scene.add_flexible_body("arm", beam_body(line, ends, kf.CraigBampton(modes=modes), kf.ModalDamping(0.01)))
    return kf.equilibrium(scene).linearise(inputs="force arm/tip y", outputs="position arm/tip y")


def test_the_norm_of_one_oscillator_is_its_closed_form():
    """White noise of unit intensity moves it by 1 / sqrt(2 c k), at a rate of 1 / sqrt(2 c m)."""
    small = kf.linearise(oscillator(), inputs="force a x", outputs=("position a x", "velocity a x", "acceleration a x"))
    place, rate = 1.0 / np.sqrt(2.0 * 4.0 * 200.0), 1.0 / np.sqrt(2.0 * 4.0 * 2.0)
    assert small.h2_norm("position a x") == pytest.approx(place, rel=1e-12)
    assert small.h2_norm("velocity a x", "force a x") == pytest.approx(rate, rel=1e-12)
    assert small.h2_norm("acceleration a x") == np.inf  # it follows the force at once
    both = kf.linearise(oscillator(), inputs="force a x", outputs=("position a x", "velocity a x"))
    assert both.h2_norm() == pytest.approx(np.hypot(place, rate), rel=1e-12)
    with pytest.raises(ModelError, match="there is no channel 'posit'"):
        both.h2_norm("posit")


def test_what_does_not_decay_has_no_norm_unless_it_does_not_matter():
    drift = kf.linearise(oscillator(0.0), inputs="force a x", outputs=("position a x", "velocity a x"))
    assert drift.h2_norm("position a x") == np.inf
    assert drift.h2_norm("velocity a x") == pytest.approx(1.0 / np.sqrt(2.0 * 4.0 * 2.0), rel=1e-12)
    rigid = kf.linearise(oscillator(0.0, 0.0), inputs="force a x", outputs="position a x")
    assert rigid.h2_norm() == np.inf
    scene = oscillator()
    scene.add_rigid_body("wheel", 1.0, 0.1, joint=kf.Revolute("z", motion=kf.Motion.steady(3.0)))
    driven = kf.linearise(scene, inputs="force a x", outputs="position a x")
    assert driven.h2_norm() == pytest.approx(0.025, rel=1e-12)


@pytest.mark.parametrize("modes", [4, 30])
def test_a_beam_has_the_norm_of_its_modes_and_no_gain_margin(modes):
    """python-control 0.10.2: inf, and an error or 1e13; force and place are of one point, so no phase of -180."""
    small = beam(modes)
    # the norm is the integral of the response over the frequency; trapezia on a grid finer than each resonance
    at = np.unique(
        np.concatenate(
            [
                np.geomspace(1e-2, 1e5, 2000),
                *(f * (1.0 + 0.01 * np.sinh(np.linspace(-5.0, 5.0, 201)) / 2.0) for f in small.modes().frequencies),
            ]
        )
    )
    at = at[at > 0.0]
    H = small.frequency_response(at).response[:, 0, 0]
    integral = 2.0 * scipy.integrate.trapezoid(np.abs(H) ** 2, at) + 2.0 * at[0] * abs(H[0]) ** 2
    assert small.h2_norm() == pytest.approx(np.sqrt(integral), rel=2e-3)
    found = small.margins(gain=100.0)
    assert (found.gain, found.reduction, found.is_stable) == (np.inf, 0.0, True)
    assert 0.0 < found.phase < 0.2
    crossing = small.frequency_response([found.phase_frequency]).response[0, 0, 0]
    assert 100.0 * abs(crossing) == pytest.approx(1.0, rel=1e-9)
    assert np.pi - abs(np.angle(crossing)) == pytest.approx(found.phase, rel=1e-6)


@pytest.mark.parametrize("gain", [5.0, 40.0, 400.0, -80.0])
def test_margins_are_those_of_the_polynomials_of_a_small_system(gain):
    """Force on the first of two masses, place of the second: the phase passes -180 degrees between the modes."""
    small = kf.linearise(two_masses(), inputs="force a x", outputs="position b x")
    A, b, c = small.A, gain * small.B[:, 0], small.C[0]
    D = np.poly(A)
    N = np.poly(A - np.outer(b, c)) - D
    flip = lambda p: p * (-1.0) ** np.arange(len(p) - 1, -1, -1)  # noqa: E731
    odd = np.polymul(N, flip(D))
    odd = np.polysub(odd, flip(odd))  # of s: twice the part that is imaginary on the axis
    roots = np.roots(odd)
    w = np.unique(np.abs(roots[np.abs(roots.real) < 1e-6 * (1.0 + np.abs(roots))].imag).round(9))
    L = (np.polyval(N, 1j * w) / np.polyval(D, 1j * w)).real
    factors = -1.0 / L[L < -1e-12]
    found = small.margins(gain=gain)
    assert found.gain == pytest.approx(min(factors[factors > 1.0], default=np.inf), rel=1e-6)
    assert found.reduction == pytest.approx(max(factors[factors <= 1.0], default=0.0), rel=1e-6)
    assert found.is_stable == bool(np.all(np.linalg.eigvals(A - np.outer(b, c)).real < 0.0))
    if np.isfinite(found.gain):  # there the closed loop is on the verge
        closed = np.linalg.eigvals(A - found.gain * np.outer(b, c))
        assert abs(closed.real).min() < 1e-6
        assert abs(closed[np.argmin(abs(closed.real))].imag) == pytest.approx(
            2 * np.pi * found.gain_frequency, abs=1e-5
        )
    if np.isfinite(found.phase):
        at = 2j * np.pi * found.phase_frequency
        size = abs(np.polyval(N, at) / np.polyval(D, at))
        assert size == pytest.approx(1.0, rel=1e-8)


LAG = 0.02
"""Time constant of each of two lags in a row, s."""

TWO_LAGS = ([[-1.0 / LAG, 0.0], [1.0 / LAG, -1.0 / LAG]], [[1.0 / LAG], [0.0]], [[0.0, 1.0]], [[0.0]])


def test_a_controller_with_states_is_part_of_the_loop():
    """``g / (2 s (1 + T s)^2)``: the phase is -180 degrees at 1/T, where the size is g T / 4."""
    rigid = kf.linearise(oscillator(0.0, 0.0), inputs="force a x", outputs="velocity a x")
    g = 30.0
    found = rigid.margins(gain=g, controller=TWO_LAGS)
    assert found.gain == pytest.approx(4.0 / (g * LAG), rel=1e-9)
    assert found.gain_frequency == pytest.approx(1.0 / (2.0 * np.pi * LAG), rel=1e-9)
    w = 2.0 * np.pi * found.phase_frequency
    assert g / (2.0 * w * (1.0 + (LAG * w) ** 2)) == pytest.approx(1.0, rel=1e-9)
    assert found.phase == pytest.approx(np.pi / 2.0 - 2.0 * np.arctan(LAG * w), rel=1e-9)
    assert found.is_stable
    assert not rigid.margins(gain=1.01 * g * found.gain, controller=TWO_LAGS).is_stable
    # a constant one is a gain, and states in other units are the same
    assert str(rigid.margins(controller=([], [], [], [[g]]))) == str(rigid.margins(gain=g))
    A, B, C, D = (np.array(part) for part in TWO_LAGS)
    units = np.array((1e9, 1e-6))
    other = (A * units[:, None] / units, B * units[:, None], C / units, D)
    assert rigid.margins(gain=g, controller=other).gain == pytest.approx(found.gain, rel=1e-9)


def test_a_controller_with_an_integral_has_the_margins_of_its_closed_loop():
    """PI control of the second of two masses: with the gain margin the closed loop is on the verge."""
    small = kf.linearise(two_masses(), inputs="force a x", outputs="position b x")
    proportional, integral = 2.0, 3.0
    found = small.margins(controller=([[0.0]], [[1.0]], [[integral]], [[proportional]]))

    def closed(factor: float) -> np.ndarray:
        b, c = small.B, small.C
        return np.linalg.eigvals(
            np.block([[small.A - factor * proportional * b @ c, -factor * integral * b], [c, np.zeros((1, 1))]])
        )

    assert found.is_stable == bool(np.all(closed(1.0).real < 0.0))
    verge = closed(found.gain)
    at = np.argmin(abs(verge.real))
    assert abs(verge[at].real) < 1e-6
    assert abs(verge[at].imag) == pytest.approx(2.0 * np.pi * found.gain_frequency, abs=1e-5)


@pytest.mark.parametrize(
    ("controller", "said"),
    [
        (3.0, "float is no controller"),
        (([[1.0]], [[1.0]], [[1.0]]), "tuple is no controller"),
        (([["a"]], [[1.0]], [[1.0]], [[0.0]]), "are no numbers"),
        (([[-1.0]], [[1.0, 2.0]], [[1.0]], [[0.0]]), r"one input and one output: .* not \(1, 1\), \(1, 2\)"),
        (([[np.nan]], [[1.0]], [[1.0]], [[0.0]]), "must be finite"),
        (scipy.signal.StateSpace([[0.5]], [[1.0]], [[1.0]], [[0.0]], dt=0.01), r"is sampled \(dt = 0.01 s\)"),
    ],
)
def test_what_is_no_controller_is_named(controller, said):
    rigid = kf.linearise(oscillator(0.0, 0.0), inputs="force a x", outputs="velocity a x")
    with pytest.raises(ModelError, match=f"margins: .*{said}.* Remedy: "):
        rigid.margins(controller=controller)


def test_margins_name_what_they_lack():
    small = kf.linearise(oscillator(damping=0.0), inputs="force a x", outputs=("position a x", "velocity a x"))
    with pytest.raises(ModelError, match=r"a motion at 1\.59155 Hz is undamped"):
        small.margins("position a x")
    with pytest.raises(ModelError, match=r"has 2 and 1\. Remedy: margins\(output"):
        small.margins()
    rigid = kf.linearise(oscillator(0.0, 0.0), inputs="force a x", outputs="velocity a x")
    assert str(rigid.margins(gain=10.0)).startswith("the closed loop is stable; gain margin inf")
    assert rigid.margins(gain=10.0).phase == pytest.approx(np.pi / 2.0)  # 10 / (2 s)


@pytest.mark.parametrize("modes", [4, 8, 20, 30])
def test_python_control_finds_the_norm_of_the_modal_form(modes):
    control = pytest.importorskip("control")
    small = beam(modes)
    space = small.to_control(modal=True)
    assert space.nstates < len(small.A)
    assert control.norm(space, 2) == pytest.approx(small.h2_norm(), rel=1e-9)
    at = [0.3, 2.06, 40.0]
    wanted = small.frequency_response(at).response[:, 0, 0]
    np.testing.assert_allclose(space(2j * np.pi * np.array(at)), wanted, rtol=1e-8)
    rigid = kf.linearise(oscillator(0.0, 0.0), inputs="force a x", outputs="position a x")
    with pytest.raises(ModelError, match="modes coincide"):
        rigid.to_control(modal=True)
