"""Floquet's modes, against transition matrices over a period and the stability chart of Mathieu's equation."""

import warnings

import numpy as np
import pytest
import scipy.linalg
import scipy.special
from scipy.integrate import solve_ivp

import kanefe as kf
from kanefe.linear.modes.hill import _motions, hill_matrix
from linear_scenes import GRAVITY, governor


def shaken(amplitude: float, rate: float, com: float, damping: float = 0.0) -> kf.System:
    """Return a point mass on a massless rod whose pivot is shaken up and down; the centre of mass above or below it."""
    scene = kf.System(gravity=GRAVITY)
    a, w = amplitude, rate
    motion = kf.Motion(
        lambda t: a * np.cos(w * t), lambda t: -a * w * np.sin(w * t), lambda t: -a * w * w * np.cos(w * t)
    )
    pivot = scene.add_frame("pivot", joint=kf.Prismatic("z", motion=motion))
    hinge = kf.Revolute("y", forces=kf.CoordinateForce(damping=damping))
    scene.add_rigid_body("rod", 1.0, com=(0, 0, com), parent=pivot, joint=hinge)
    return scene


def transition(rates, period: float, size: int) -> np.ndarray:
    """Return the multipliers of ``dx/dt = A(t) x``, by a run for each unit start."""
    ends = [
        solve_ivp(lambda t, x: rates(t) @ x, (0.0, period), e, method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
        for e in np.eye(size)
    ]
    return scipy.linalg.eigvals(np.array(ends).T)


@pytest.mark.parametrize(("amplitude", "rate", "com"), [(0.05, 100.0, 0.5), (0.05, 50.0, 0.5), (0.05, 8.9, -0.5)])
def test_a_shaken_pendulum_is_that_of_mathieu(amplitude, rate, com):
    """Upright it stands if shaken fast enough; hanging it is fed where the shaking is twice its frequency."""
    found = kf.floquet(shaken(amplitude, rate, com), period=2.0 * np.pi / rate)
    exact = transition(
        lambda t: np.array(((0.0, 1.0), ((9.81 - amplitude * rate**2 * np.cos(rate * t)) / com, 0.0))),
        2.0 * np.pi / rate,
        2,
    )
    for value in found.multipliers:
        assert np.abs(exact - value).min() < 1e-8
    assert found.is_stable == bool(np.abs(exact).max() < 1.0 + 1e-8)


def test_the_edge_of_the_chart_is_a_period_of_two():
    """X'' + (a - 2 q cos 2 t) x = 0 is on the edge where a is a characteristic value: the multiplier is -1 there."""
    q, rate = 0.1, 8.0
    a = scipy.special.mathieu_b(1, q)
    # with t' = rate t / 2:  a = 4 g / (l rate^2),  2 q = 4 amplitude / l
    length = 4.0 * 9.81 / (a * rate**2)
    modes = kf.floquet(shaken(0.5 * q * length, rate, -length), period=2.0 * np.pi / rate)
    # two equal multipliers are known to the root of round-off
    assert modes.multipliers == pytest.approx(-1.0, abs=1e-5)
    assert [part[0] for part in modes.harmonics(0)[:2]] in ([0, -1], [-1, 0])


def bladed(speed: float, springs: tuple[float, float] = (200.0, 900.0), gravity: float = 0.0) -> kf.System:
    """Return two hinged blades on a hub that turns on a support with two stiffnesses."""
    scene = kf.System(gravity=(0.0, -gravity, 0.0))
    along_x, along_y = (kf.CoordinateForce(stiffness=k, damping=1.0) for k in springs)
    slide = scene.add_frame("slide", joint=kf.Prismatic("x", forces=along_x))
    seat = scene.add_rigid_body("seat", 2.0, 0.1, parent=slide, joint=kf.Prismatic("y", forces=along_y))
    hub = scene.add_rigid_body("hub", 1.0, 0.1, parent=seat, joint=kf.Revolute("z", motion=kf.Motion.steady(speed)))
    for i, side in enumerate((1.0, -1.0)):
        lag = kf.Revolute("z", forces=kf.CoordinateForce(stiffness=30.0, damping=0.05))
        scene.add_rigid_body(
            f"blade{i}", 0.5, 0.02, com=(side * 0.4, 0, 0), at=(side * 0.1, 0, 0), parent=hub, joint=lag
        )
    return scene


def test_two_blades_on_a_soft_support_are_told_and_found():
    speed = 9.0
    frozen = kf.linearise(bladed(speed))
    assert frozen.change > 0.01
    with pytest.warns(kf.AccuracyWarning, match=r"frozen at t = 0 s.*Remedy: kanefe\.floquet"):
        frozen.modes()
    found = kf.floquet(bladed(speed))
    period = 2.0 * np.pi / speed
    assert found.period == pytest.approx(period)
    model = bladed(speed).freeze()
    # A is smooth over a turn: its Fourier series from 25 azimuths is A to 1e-10
    orders = np.fft.fftfreq(25, 1.0 / 25)
    terms = np.fft.fft([kf.linearise(model, t=period * i / 25).A for i in range(25)], axis=0) / 25
    waves = lambda t: np.einsum("k,kij->ij", np.exp(1j * speed * t * orders), terms).real  # noqa: E731
    exact = transition(waves, period, 8)
    listed = np.concatenate((found.multipliers, found.multipliers.conj()))
    for value in exact:
        assert np.abs(listed - value).min() < 1e-7
    told = str(found)
    assert "multiplier" in told
    assert "+1:" in told


def test_without_periodic_terms_the_modes_are_those_of_one_azimuth():
    """On a support that is alike in both directions nothing but names changes where the arm alone moves."""
    found = kf.equilibrium(governor(6.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        frozen = found.linearise().modes()
    modes = kf.floquet(governor(6.0), start=found)
    np.testing.assert_allclose(modes.eigenvalues, frozen.eigenvalues, atol=1e-9)
    assert modes.shares.max(axis=0) == pytest.approx(1.0)


def test_blades_under_gravity_swing_about_a_motion_that_is_found():
    """The swing of the blades is found by harmonics: a run that starts in it comes back to it after a turn."""
    speed = 9.0
    scene = bladed(speed, gravity=9.81)
    modes = kf.floquet(scene)
    small = modes.small
    start = np.concatenate((small.q, small.u))
    assert np.abs(start).max() > 1e-2
    result = scene.simulate((0.0, modes.period), start=start, method="dop853", rtol=1e-9, output_step=modes.period)
    np.testing.assert_allclose(result.at(modes.period).state, start, atol=1e-6 * np.abs(start).max())


def test_a_slow_vibration_beside_a_fast_one_is_no_rigid_motion_and_a_free_slide_is_one():
    scene = bladed(9.0, (0.0, 900.0))
    for name, stiffness in (("slow", 2.5e-5), ("fast", 1e10)):  # 0.005 rad/s, a 2e7th of the other
        spring = kf.CoordinateForce(stiffness=stiffness, damping=1e-6)
        scene.add_rigid_body(name, 1.0, joint=kf.Prismatic("z", forces=spring))
    modes = kf.floquet(scene)
    rigid, slow = np.flatnonzero(modes.is_rigid), np.flatnonzero(modes.participation["slow"] > 0.99)
    assert len(rigid) == len(slow) == 1
    assert modes.participation["seat"][rigid[0]] > 0.4  # the hub goes with it
    assert modes.frequencies[slow] == pytest.approx(0.005 / 2 / np.pi, rel=1e-6)


def test_a_campbell_diagram_of_a_periodic_scene_is_that_of_floquet():
    diagram = kf.campbell(bladed, [6.0, 9.0], modes=3, balance=False)
    assert all(isinstance(modes, kf.FloquetModes) for modes in diagram.modes)
    at_9 = kf.floquet(bladed(9.0))
    listed = np.concatenate((at_9.eigenvalues, at_9.eigenvalues.conj()))
    turns = 2.0 * np.pi / at_9.period
    for value in diagram.eigenvalues[1]:
        apart = listed - value
        apart = apart - 1j * turns * np.round(apart.imag / turns)
        assert np.abs(apart).min() < 1e-8


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: kf.floquet(bladed(9.0), period=0.3), "not the same after 0.3 s.*Remedy: period="),
        (lambda: kf.floquet(bladed(9.0), period=-1.0), "must be above zero s"),
        (lambda: kf.floquet(shaken(0.05, 50.0, 0.5)), "nothing turns at the start"),
    ],
)
def test_what_is_wrong_is_named(call, words):
    with pytest.raises(kf.ModelError, match=words):
        call()


def test_motions_of_cosines_and_sines_are_those_of_harmonics() -> None:
    rng = np.random.default_rng(1)
    reach, size = 3, 4
    harmonics = np.fft.fft(rng.standard_normal((5, size, size)), axis=0) / 5
    H = hill_matrix(harmonics, 2.0, reach)
    values, shapes = _motions(H, reach)
    vectors = shapes.reshape(len(H), -1)
    np.testing.assert_allclose(H @ vectors, vectors * values, atol=1e-12 * np.abs(H).max())  # some 20 entries a row
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=0), 1.0, rtol=1e-12)
    assert np.linalg.matrix_rank(vectors) == len(H)
    expected = np.linalg.eigvals(H)
    for value in values:
        assert np.abs(expected - value).min() < 1e-11 * np.abs(H).max()
