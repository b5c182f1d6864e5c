"""Compiled steps over impacts against the literal equations, and the work of their impulses."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from draws import in_parts
from kanefe import shapes
from kanefe.equations.model import Model
from kanefe.integrate.run_checks.bending_check import bends_in_kernels
from kanefe.integrate.run_checks.contact_check import StepsChecked
from kanefe.integrate.stepper import StepFailure
from kanefe.kernels.impacts.march import Ending, Told
from kanefe.literal.impact_steps import stepped
from kanefe.order_n.impact_steps import ImpactSteps
from kanefe.order_n.route import OrderN
from kanefe.tree.contact_steps import Stepped
from kanefe.tree.model_data import QUADRATURES
from rigid_scenes import rigid_scene, rigid_state
from scenes import lattice_body

G = 9.81
NO_OUTPUT = np.array([np.inf])
FAR = 1e9  # m: nothing counts as too deep


def free_steps(model: Model) -> ImpactSteps:
    """Return compiled steps that do not mind how deep a random state begins."""
    steps = model.route.impact_steps(np.zeros(Told.number_count), FAR, bends_in_kernels([], 0))
    assert isinstance(steps, ImpactSteps)
    return steps


def compared(model: Model, steps: ImpactSteps, t: float, y: np.ndarray, h: float) -> Stepped | None:
    """Compare a step; None where it is left to the literal equations."""
    wanted = stepped(model, t, y, h)
    ended, count, _ = steps.go_on(t, y, h, t + 10.0 * h, 1, NO_OUTPUT, y[None].copy())
    if ended == Ending.LEFT:
        return None
    assert (ended, count) == (Ending.DONE, 1)
    _, _, end, own = steps.last
    assert end == t + h
    q, u, rest = np.split(own - wanted.y, [model.coordinate_count, model.coordinate_count + model.free_count])
    fastest = np.abs(model.parts(wanted.y)[1]).max()
    # impulses solve their problem to 1e-12 of the largest, and loops close to as much, over what rows lack to depend
    np.testing.assert_allclose(np.append(q, u), 0.0, atol=1e-8 * max(1.0, fastest))
    np.testing.assert_allclose(rest, 0.0, atol=1e-8 * max(1.0, fastest**2))
    assert steps.tried.closed == wanted.closed
    return wanted


@pytest.mark.parametrize("part", in_parts(20, short=1))
def test_steps_of_random_scenes_are_those_of_the_literal_equations(part):
    """Two steps of 200 scenes with flexible bodies, loops, drives, belts and all laws of friction."""
    closed, left = 0, 0
    for seed in range(10 * part, 10 * part + 10):
        model = rigid_scene(seed)
        try:
            y = model.route.projected(0.2, rigid_state(model, 10 * seed + 5))
        except kf.SimulationError:  # cranks that do not reach each other
            continue
        y, steps = np.append(y, np.zeros(QUADRATURES)), free_steps(model)
        for t in (0.2, 0.201):
            found = compared(model, steps, t, y, 1e-3)
            left += found is None
            closed += found is not None and len(found.closed) > 0
            y = stepped(model, t, y, 1e-3).y
    assert closed >= (3 if part == 0 else 0)
    assert left <= 3  # beside singular positions of the cranks


def table() -> kf.System:
    """Return a table on three legs that slides and turns."""
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    start = kf.Free(velocity=(9.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, 7.0))
    body = scene.add_rigid_body("table", 2.0, (0.02, 0.03, 0.04), joint=start, at=(0, 0, 0.05))
    feet = [(0.2 * np.cos(a), 0.2 * np.sin(a), -0.05) for a in (0.0, 2.1, 4.2)]
    legs = scene.add_surface("legs", body, shapes.Points(feet))
    scene.add_contact("c", legs, floor, normal=kf.Rigid(0.3), friction=kf.Coulomb(0.5))
    return scene


def literally(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(OrderN, "impact_steps", lambda self, *given: None)


def test_a_thousand_steps_of_a_slide_are_those_of_the_literal_equations(monkeypatch):
    """Also the outputs, which are between the steps."""
    options = {"method": "moreau-jean", "step": 1e-3, "output_step": 2.3e-3}

    def ball() -> kf.System:
        scene = kf.System(gravity=(0, 0, -G))
        floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
        start = kf.Free((0.0, 0.0, 0.1), velocity=(9.0, 0.0, 0.0), angular_velocity=(1.0, -40.0, 7.0))
        body = scene.add_rigid_body("ball", 2.0, (0.02, 0.02, 0.03), joint=start)
        skin = scene.add_surface("skin", body, shapes.Sphere(0.1))
        scene.add_contact("c", skin, floor, normal=kf.Rigid(0.3), friction=kf.Coulomb(0.2))
        return scene

    own = ball().simulate((0.0, 1.0), **options)
    literally(monkeypatch)
    wanted = ball().simulate((0.0, 1.0), **options)
    assert own.statistics["steps"] == wanted.statistics["steps"] == wanted.statistics["steps_in_python"] == 1000
    assert "steps_in_python" not in own.statistics
    assert own.contact("c").status[-1] == "slips"
    # a thousand times round-off of 10 m and 100 J
    np.testing.assert_allclose(own.run.states, wanted.run.states, rtol=0.0, atol=1e-11)


def test_a_flexible_arm_on_a_stop_is_that_of_the_literal_equations(monkeypatch):
    """Also how far it was bent, at any of its steps."""

    def arm() -> kf.Result:
        scene = kf.System(gravity=(0, 0, -0.5 * G))
        stop = scene.add_surface("stop", scene.ground, shapes.Plane("z"), at=(0, 0, -0.03))
        body = scene.add_flexible_body("arm", lattice_body(1), joint=kf.Revolute("y", speed=1.0))
        scene.add_contact("tip", body.interface("tip"), stop, normal=kf.Rigid(0.3), friction=kf.Coulomb(0.3))
        return scene.simulate((0.0, 0.1), method="moreau-jean", step=5e-4, output_step=0.02)

    own = arm()
    literally(monkeypatch)
    wanted = arm()
    assert own.energy.dissipated[-1] > 0.01
    np.testing.assert_allclose(own.run.states, wanted.run.states, rtol=0.0, atol=1e-9)
    name, angle, _, where, when, length, _ = own.statistics["bending"]
    of_literal = wanted.statistics["bending"]
    assert [name, where, when] == [of_literal[0], of_literal[3], of_literal[4]]
    np.testing.assert_allclose((angle, length), (of_literal[1], of_literal[5]), rtol=1e-9)


def test_functions_in_python_have_steps_in_python_which_is_told():
    scene = table()
    scene.add_force(scene.body("table"), lambda t: (np.cos(t), 0.0, 0.0))
    result = scene.simulate((0.0, 0.02), method="moreau-jean", step=1e-3)
    assert result.statistics["steps_in_python"] == result.statistics["steps"] == 20


def test_what_begins_too_deep_breaks_a_law():
    model = table().freeze()
    checked = StepsChecked(model)
    steps = model.route.impact_steps(checked.told, checked.too_deep, bends_in_kernels([], 0))
    y = np.append(model.route.start(0.0), np.zeros(QUADRATURES))
    y[2] -= 0.01
    ended, count, _ = steps.go_on(0.0, y, 1e-3, 1.0, 5, NO_OUTPUT, y[None].copy())
    assert (ended, count) == (Ending.BROKEN, 0)
    with pytest.raises(StepFailure, match=r"'c': penetrated by 0\.01 m, more than the error of steps"):
        checked.check(steps.tried)


def thrown(seed: int) -> kf.System:
    """Return a box that is thrown onto a rough floor."""
    rng = np.random.default_rng(seed)
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    e = rng.standard_normal(4)
    size, mass = rng.uniform(0.05, 0.3, 3), rng.uniform(0.3, 3.0)
    inertia = mass / 12.0 * (size @ size - size**2)
    start = kf.Free(
        position=(0, 0, np.linalg.norm(size) / 2 + 0.05),
        orientation=e / np.linalg.norm(e),
        velocity=rng.standard_normal(3),
        angular_velocity=5.0 * rng.standard_normal(3),
    )
    box = scene.add_surface("skin", scene.add_rigid_body("box", mass, inertia, joint=start), shapes.Box(size))
    law, friction = kf.Rigid(rng.uniform(0.0, 0.9)), kf.Coulomb(rng.uniform(0.05, 1.2))
    scene.add_contact("c", box, floor, normal=law, friction=friction)
    return scene


def pendulums(count: int) -> list[kf.System]:
    """Return double pendulums whose tip may strike a rough floor, where Kane and Levinson found energy made."""
    rng, found = np.random.default_rng(0), []
    for _ in range(count):
        limits = (0.3, 1.0), (0.1, 1.5), (-1.2, 1.2), (-1.5, 1.5), (-3.0, 3.0), (-3.0, 3.0)
        e, mu, first, second, rate_1, rate_2 = (rng.uniform(*one) for one in limits)
        scene = kf.System()
        floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
        rod: dict = {"mass": 1.0, "inertia": (1 / 12, 1 / 12, 1e-4), "com": (0, 0, -0.5)}
        height = np.cos(first) + np.cos(first + second) + 0.005
        hinges = kf.Revolute("y", position=first, speed=rate_1), kf.Revolute("y", position=second, speed=rate_2)
        upper = scene.add_rigid_body("upper", **rod, at=(0, 0, height), joint=hinges[0])
        lower = scene.add_rigid_body("lower", **rod, at=(0, 0, -1.0), parent=upper, joint=hinges[1])
        tip = lower.frame(at=(0, 0, -1.0))
        scene.add_contact("tip", tip, floor, normal=kf.Rigid(e), friction=kf.Coulomb(mu))
        found.append(scene)
    return found


def taken_at_least(scene: kf.System, end: float) -> tuple[float, kf.Result]:
    """Return the least energy that a step takes, of the kinetic energy at the start, and the run."""
    result = scene.simulate((0.0, end), method="moreau-jean", step=1e-3, output_step=1e-3)
    assert result.status.is_finished, str(result.status)
    return float(np.diff(result.energy.dissipated).min() / result.energy.kinetic[0]), result


@pytest.mark.parametrize("part", in_parts(5, short=1))
def test_impulses_on_double_pendulums_make_no_energy(part):
    """Of 150, 68 are struck, of which 8 would leave with more energy by Newton's law, one with 79 times as much."""
    for scene in pendulums(30 * part + 30)[30 * part :]:
        least, _ = taken_at_least(scene, 0.2)
        assert least > -1e-9  # to which the problem of the impulses is solved


@pytest.mark.parametrize("part", in_parts(6, short=1))
def test_impulses_on_thrown_boxes_make_no_energy(part):
    for seed in range(10 * part, 10 * part + 10):
        least, _ = taken_at_least(thrown(seed), 1.0)
        assert least > -1e-9


def test_restitution_is_lowered_by_no_more_than_it_must(monkeypatch):
    """The impact that would make the most energy then takes none, in both routes."""
    scene = pendulums(73)[72]
    for _ in range(2):
        least, result = taken_at_least(scene.copy(), 0.2)
        assert result.statistics["restitution_lowered"] == 1
        energy = result.energy.kinetic
        assert least > -1e-9
        # a millionth of the restitution, of an impact that would give 79 times the energy
        assert result.energy.dissipated[-1] / energy[0] < 1e-3
        literally(monkeypatch)


def test_a_run_goes_on_from_a_checkpoint_as_deep_as_its_impact_was(tmp_path):
    """How far steps may have entered a surface is known from the impacts before."""
    options = {"method": "moreau-jean", "step": 1e-3, "output_step": 0.01}
    path = tmp_path / "run.npz"
    whole = thrown(3).simulate((0.0, 1.0), **options)
    part = thrown(3).simulate((0.0, 1.0), checkpoint=path, most_steps=800, **options)
    assert not part.status.is_finished
    resumed = thrown(3).simulate((0.0, 1.0), resume=path, **options)
    assert resumed.status.is_finished, str(resumed.status)
    np.testing.assert_array_equal(resumed.run.states, whole.run.states)


@pytest.mark.parametrize("seed", [0, 2])
def test_what_rests_is_told_to_stick_and_to_be_carried(seed):
    """Whether it does is not for round-off to say, which is all that moves."""
    result = thrown(seed).simulate((0.0, 2.0), method="moreau-jean", step=1e-3, output_step=7e-3)
    history = result.contact("c")
    rests = result.times > 1.9
    assert set(history.status[rests]) == {"sticks"}
    # the weight, carried by four corners, whose shares are solved for
    np.testing.assert_allclose(history.normal[rests], result.run.model.bodies[0].rigid.mass * G, rtol=1e-9)
