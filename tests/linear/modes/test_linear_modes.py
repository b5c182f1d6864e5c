"""Modes, Campbell diagrams and frequency responses against closed forms."""

import sys

import numpy as np
import pytest

import kanefe as kf
from kanefe.checks.verification.references import load_references
from kanefe.checks.verification.rotors import point_on_springs
from kanefe.errors import MissingDependency, ModelError
from linear_scenes import GRAVITY, cart_and_rod
from scenes import lattice_body


def oscillator(stiffness: float = 200.0, damping: float = 4.0, mass: float = 2.0) -> kf.System:
    scene = kf.System()
    spring = kf.CoordinateForce(stiffness=stiffness, damping=damping)
    scene.add_rigid_body("cart", mass, joint=kf.Prismatic("x", forces=spring))
    return scene


def test_one_oscillator():
    modes = kf.linearise(oscillator()).modes()
    assert modes.natural_frequencies == pytest.approx([10.0 / 2 / np.pi])
    assert modes.damping_ratios == pytest.approx([0.1])
    assert modes.frequencies == pytest.approx([10.0 * np.sqrt(0.99) / 2 / np.pi])
    assert modes.shape("cart")[0, :3] == pytest.approx(np.array((1, 0, 0)) / np.sqrt(2.0))
    assert modes.participation["cart"] == pytest.approx([1.0])
    # damping in the last column before what moves, %
    assert str(modes).splitlines()[1].split()[3:] == ["10", "cart", "100", "%"]


def test_more_than_critical_damping_is_two_decays():
    modes = kf.linearise(oscillator(damping=50.0)).modes()  # s^2 + 25 s + 100
    assert np.sort(modes.eigenvalues.real) == pytest.approx([-20.0, -5.0])
    assert modes.frequencies == pytest.approx([0.0, 0.0])
    assert modes.is_stable
    assert "decays" in str(modes)


def test_rigid_motions_are_listed_apart():
    scene = kf.System(gravity=(0, 0, -9.81))
    cart = scene.add_rigid_body("cart", 2.0, joint=kf.Prismatic("x"))
    spring = kf.CoordinateForce(stiffness=200.0)
    scene.add_rigid_body("block", 2.0, parent=cart, joint=kf.Prismatic("x", forces=spring))
    scene.add_rigid_body("top", 1.0, 0.1, com=(0, 0, 1), joint=kf.Revolute("y"))
    lines = str(kf.linearise(scene).modes()).splitlines()
    assert lines[:2] == ["rigid motions (without restoring force):", "   0  cart 50 %, block 50 %"]
    assert "frequency [Hz]      [rad/s]" in lines[2]
    assert ["diverges" in line and "(unstable)" in line for line in lines[3:]] == [True, False, False]
    assert "decays" in lines[4]
    assert "2.25079      14.1421" in lines[5]  # sqrt(k / 1 kg), the reduced mass
    assert "rigid" not in str(kf.linearise(oscillator()).modes())


def test_low_modes_beside_high_ones_keep_their_digits():
    """1e7 rad/s and 1 rad/s in one scene: of the squares of the largest, round-off is a hundredth of the smallest."""
    scene = kf.System()
    for name, rate in (("slow", 1.0), ("fast", 1e7)):
        scene.add_rigid_body(name, 2.0, joint=kf.Prismatic("x", forces=kf.CoordinateForce(2.0 * rate**2)))
    assert kf.linearise(scene).modes().eigenvalues.imag == pytest.approx([1.0, 1e7], rel=1e-12)


@pytest.mark.parametrize("axis", range(3))
def test_a_free_body_spins_steadily_but_about_its_middle_axis(axis):
    """Euler: lambda^2 = -(J - I1)(J - I2) W^2 / I1 I2, I1 and I2 across the axis of J."""
    inertia, speed = np.array((2.0, 3.0, 4.0)), 3.0
    scene = kf.System()
    w = speed * np.eye(3)[axis]
    scene.add_rigid_body("body", 1.0, inertia, joint=kf.Spherical(angular_velocity=w))
    modes = kf.linearise(scene).modes()
    a, b = np.delete(inertia, axis)
    square = -(inertia[axis] - a) * (inertia[axis] - b) / (a * b) * speed**2
    # seen from the body, rotations besides turn with the spin
    expected = np.sqrt(complex(square))
    assert np.abs(modes.eigenvalues - expected).min() < 1e-8
    assert np.abs(modes.eigenvalues - 1j * speed).min() < 1e-6
    assert modes.is_stable == (axis != 1)


@pytest.mark.parametrize("speed", [2.0, 12.0])
def test_a_disc_that_rolls_upright(speed):
    """A thin disc: lambda^2 = -(3 W^2 - g / r) / (5 / 4); it falls below W^2 = g / 3 r."""
    radius, mass = 0.3, 2.0
    inertia = mass * radius**2 * np.array((0.25, 0.5, 0.25))
    scene = kf.System(gravity=GRAVITY)
    # frames that do not spin: in them the motion is steady
    hub = scene.add_frame("hub", joint=kf.Translation(position=(0, 0, radius), velocity=(speed * radius, 0, 0)))
    yaw = scene.add_frame("yaw", parent=hub, joint=kf.Revolute("z"))
    lean = scene.add_frame("lean", parent=yaw, joint=kf.Revolute("x"))
    disc = scene.add_rigid_body("disc", mass, inertia, parent=lean, joint=kf.Revolute("y", speed=speed))
    axle = disc.frame(orientation=(np.sqrt(0.5), np.sqrt(0.5), 0, 0))
    scene.add_rolling_wheel("roll", axle, radius)
    small = kf.linearise(scene)
    values = small.modes().eigenvalues
    expected = np.sqrt(complex((9.81 / radius - 3 * speed**2) / 1.25))
    assert np.abs(values - expected).min() < 1e-6 * abs(expected)
    assert small.modes().is_stable == (speed**2 > 9.81 / radius / 3)
    with pytest.raises(ModelError, match=r"rolls.*Remedy: A, or modes"):
        _ = small.stiffness


def test_shapes_of_a_flexible_body_are_those_of_its_nodes():
    scene = kf.System()
    body = lattice_body(1)
    arm = scene.add_flexible_body("arm", body, joint=kf.Revolute("z", position=0.7))
    scene.add_rigid_body("tool", 0.3, 0.01, parent=arm.interface("tip"))
    modes = kf.linearise(scene).modes()
    model = modes.linearisation.model
    assert modes.is_rigid[0]
    assert sum(modes.participation.values()) == pytest.approx(np.ones(len(modes.eigenvalues)))
    # the positions of nodes beside the state, by differences
    step, mode = 1e-6, 2
    z = modes.tangents[:, mode].real
    places = []
    for sign in (1, -1):
        q = model.advance(model.initial_coordinates, sign * step * z)
        y = np.concatenate((q, np.zeros(model.free_count)))
        frame = model.kinematics("arm", 0.0, y)
        eta = q[model.flexible_terms("arm").eta]
        places.append(frame.position + (body.nodes + body.node_displacements(eta)) @ frame.rotation.T)
    expected = (places[0] - places[1]) / (2 * step)
    np.testing.assert_allclose(modes.displacements("arm", mode).real, expected, atol=1e-7 * np.abs(expected).max())
    np.testing.assert_allclose(modes.shape("tool"), modes.shape("arm", "tip"), atol=1e-12)
    with pytest.raises(ModelError, match="there is no mode 99"):
        modes.displacements("arm", 99)


def test_campbell_of_an_asymmetric_rotor():
    """D04b: two modes of 100 and 120 rad/s; between, the lower one grows."""
    diagram = kf.campbell(point_on_springs, np.arange(0.0, 145.0, 5.0), modes=2)
    for spin, pairs in load_references()["D04b"].values["lam"].items():
        row = diagram.eigenvalues[int(float(spin) / 5)]
        expected = sorted(pairs, key=lambda pair: pair[1])
        np.testing.assert_allclose(np.column_stack((row.real, row.imag)), expected, atol=1e-6)
    inside = (diagram.speeds > 100.0) & (diagram.speeds < 120.0)
    assert diagram.grows[:, 0].tolist() == inside.tolist()
    assert not diagram.grows[:, 1].any()
    assert [found.speed for found in diagram.critical_speeds(order=0)] == pytest.approx([100.0, 120.0], rel=1e-9)


def whirling(speed: float) -> kf.System:
    """A round rotor, whose forward whirl seen from it stands still at 100 rad/s."""
    scene = kf.System()
    shaft = scene.add_frame("shaft", joint=kf.Revolute("z", motion=kf.Motion.steady(speed)))
    slide = scene.add_frame("slide", parent=shaft, joint=kf.Prismatic("x", forces=kf.CoordinateForce(2e4)))
    scene.add_point("point", 2.0, parent=slide, joint=kf.Prismatic("y", forces=kf.CoordinateForce(2e4)))
    return scene


def test_a_whirl_is_followed_through_zero():
    """Seen from the rotor it has 100 - W: negative beyond 100 rad/s, and no mode jumps."""
    speeds = np.array((10.0, 60.0, 95.0, 130.0, 160.0))
    diagram = kf.campbell(whirling, speeds, modes=2)
    np.testing.assert_allclose(diagram.eigenvalues.imag[:, 0], 100.0 - speeds, atol=1e-9)
    np.testing.assert_allclose(diagram.eigenvalues.imag[:, 1], 100.0 + speeds, atol=1e-9)
    for grid in (diagram, kf.campbell(whirling, [10.0, 160.0]), kf.campbell(whirling, [10.0, 100.0, 160.0])):
        ((standing,), (crossing,)) = grid.critical_speeds(order=0), grid.critical_speeds(order=1)
        assert (standing.speed, standing.column) == (pytest.approx(100.0, rel=1e-9), 0)
        assert (crossing.speed, crossing.column, crossing.sense) == (pytest.approx(50.0, rel=1e-9), 0, "forward")
    assert diagram.correlations.min() > 0.99


def test_modes_that_cross_keep_their_columns():
    def build(speed: float) -> kf.System:
        scene = kf.System()
        scene.add_frame("rotor", joint=kf.Revolute("z", motion=kf.Motion.steady(speed)))
        for name, rate in (("falls", 20.0 - speed), ("still", 10.5)):
            spring = kf.CoordinateForce(stiffness=rate**2, damping=0.02 * rate)
            scene.add_rigid_body(name, 1.0, joint=kf.Prismatic("x", forces=spring))
        return scene

    diagram = kf.campbell(build, np.arange(0.0, 17.0, 4.0), modes=2)
    frequencies = 2 * np.pi * diagram.frequencies / np.sqrt(1 - 0.01**2)
    np.testing.assert_allclose(frequencies[:, 0], 10.5)
    np.testing.assert_allclose(frequencies[:, 1], 20.0 - diagram.speeds)
    np.testing.assert_allclose(diagram.damping_ratios, 0.01)


def flat_whirling() -> kf.System:
    scene = oscillator()
    scene.add_frame("rotor", joint=kf.Revolute("z", motion=kf.Motion.steady(9.0)))
    return scene


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"speeds": [1.0]}, "two or more that ascend"),
        ({"speeds": [2.0, 1.0]}, "two or more that ascend"),
        ({"modes": 0}, "modes must be a whole number"),
        ({"modes": 9}, "has 2 modes that oscillate at 0 rad/s, not 9. Remedy: modes=2"),
        ({"build": 3}, "needs a function of the speed"),
        ({"build": lambda speed: point_on_springs(1.0) if speed < 5 else flat_whirling()}, "same coordinates"),
        ({"build": lambda speed: oscillator(), "modes": 1}, "nothing rotates in the scene of campbell at 10 rad/s"),
    ],
)
def test_what_is_wrong_with_a_campbell_diagram_is_named(options, words):
    given = {"build": point_on_springs, "speeds": [0.0, 10.0], "modes": 2} | options
    with pytest.raises(ModelError, match=words):
        kf.campbell(given.pop("build"), given.pop("speeds"), **given)


def test_the_frequency_response_of_an_oscillator():
    small = kf.linearise(oscillator(), inputs="force cart x", outputs=["position cart x", "acceleration cart x"])
    f = np.array((0.0, 1.0, 10.0 / 2 / np.pi, 5.0))
    response = small.frequency_response(f)
    s = 2j * np.pi * f
    exact = 1.0 / (2.0 * s**2 + 4.0 * s + 200.0)
    np.testing.assert_allclose(response.response[:, 0, 0], exact, rtol=1e-10)
    np.testing.assert_allclose(response.response[:, 1, 0], s**2 * exact, atol=1e-11)
    assert response.phase[2, 0, 0] == pytest.approx(-np.pi / 2)
    assert response.magnitude[0, 0, 0] == pytest.approx(1 / 200)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: kf.linearise(oscillator()).frequency_response([1.0]), "has no inputs"),
        (lambda: kf.linearise(oscillator(), inputs="force cart", outputs=[]).frequency_response([1.0]), "no outputs"),
        (lambda: kf.linearise(oscillator(), inputs="force cart").frequency_response([-1.0]), "not negative"),
        (lambda: kf.linearise(oscillator(0.0, 0.0, 1.0), inputs="force cart").frequency_response([0.0]), "infinite"),
    ],
)
def test_what_is_wrong_with_a_frequency_response_is_named(call, words):
    with pytest.raises(ModelError, match=words):
        call()


def test_pictures_are_written(tmp_path):
    diagram = kf.campbell(point_on_springs, np.arange(80.0, 145.0, 10.0), modes=2)
    figure = diagram.plot(tmp_path / "campbell.png", orders=(0.0, 1.0))
    assert (tmp_path / "campbell.png").stat().st_size > 10_000
    labels = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert labels == ["mode 1", "mode 2", "unstable", "critical speed"]
    circles = [line.get_xdata()[0] for line in figure.axes[0].get_lines() if line.get_marker() == "o"]
    assert circles == pytest.approx([100.0, 120.0])
    falling = kf.campbell(whirling, [60.0, 95.0, 130.0], modes=2).plot().axes[0].get_lines()[0]
    assert falling.get_xdata() == pytest.approx([60.0, 95.0, 100.0, 130.0])
    assert 2 * np.pi * falling.get_ydata() == pytest.approx([40.0, 5.0, 0.0, 30.0], abs=1e-9)
    small = kf.linearise(cart_and_rod(), inputs="force cart x", outputs="position cart x")
    figure = small.frequency_response(np.geomspace(0.1, 10, 50)).plot(tmp_path / "response.png")
    assert [ax.get_ylabel() for ax in figure.axes] == ["magnitude", "phase [degrees]"]
    with pytest.raises(ModelError, match="orders must be"):
        diagram.plot(orders=(-1.0,))


def test_python_control_gets_the_names():
    control = pytest.importorskip("control")
    small = kf.linearise(cart_and_rod(), inputs="force cart x", outputs="position cart x")
    space = small.to_control()
    assert isinstance(space, control.StateSpace)
    assert (space.input_labels, space.output_labels) == (list(small.input_names), list(small.output_names))
    assert space.state_labels == list(small.state_names)
    np.testing.assert_array_equal(space.A, small.A)
    response = small.frequency_response([2.0]).response[0, 0, 0]
    assert space(2j * np.pi * 2.0) == pytest.approx(response)


def test_a_missing_python_control_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "control", None)
    monkeypatch.delitem(sys.modules, "kanefe.linear._control", raising=False)
    with pytest.raises(MissingDependency, match=r"to_control needs control.*pip install 'kanefe\[control\]'"):
        kf.linearise(oscillator()).to_control()


def test_shapes_bear_entries_that_are_nearly_nothing():
    scene = kf.System()
    # a cart that nearly nothing holds, and one on it that vibrates against it
    held = kf.CoordinateForce(stiffness=1e-40)
    below = scene.add_rigid_body("below", 2.0, joint=kf.Prismatic("x", forces=held))
    spring = kf.CoordinateForce(stiffness=300.0, damping=2.0)
    scene.add_rigid_body("above", 1.0, parent=below, joint=kf.Prismatic("x", forces=spring))
    modes = kf.linearise(scene).modes()
    assert list(modes.is_rigid) == [True, False]
    # momentum stays zero: the speeds are as 1 to -2, the energies as 1 to 2
    assert modes.participation["above"] == pytest.approx([1.0 / 3.0, 2.0 / 3.0], rel=1e-9)
