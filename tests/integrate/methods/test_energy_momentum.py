"""The energy-momentum method: what it keeps, its order, its symmetry, and what it refuses."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

import kanefe as kf
from bent_bodies import bent
from kanefe.equations.model import Model
from kanefe.equations.start_report import StartWarning
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.energy_momentum import METHOD, flies_freely
from kanefe.integrate.run import integrate
from kanefe.integrate.stepper import StepControl, Stepper
from kanefe.kane.energy import momenta
from kanefe.kernels.steppers.step_commands import Run
from kanefe.states.constraints import constraint_residuals
from kanefe.states.state import State
from loop_scenes import bent_four_bars, four_bar
from order_n_rates import order_n
from run_scenes import check_snapshot
from scenes import lattice_body, random_inertia, random_state

NAME = "energy-momentum"


def top() -> Model:
    """Return a free body with three different moments of inertia, spinning about the middle one: it turns over."""
    scene = kf.System()
    joint = kf.Free(velocity=(0.3, 0.1, -0.2), angular_velocity=(0.01, 2.0, 0.02))
    scene.add_rigid_body("top", 2.0, (1.0, 2.0, 3.0), com=(0.1, 0.2, -0.3), joint=joint)
    return scene.freeze()


def flexible(rate: float = 30.0) -> Model:
    """Return a soft free body that stiffens, a rigid one with a rotor on a sprung hinge, and another free body."""
    scene = kf.System()
    joint = kf.Free(velocity=(0.1, 0.2, 0.0), angular_velocity=(0.4, 1.0, 0.3))
    body = bent(lattice_body(2, {"tip": "rigid"}, reduction=kf.CraigBampton(modes=3)), strength=0.1)
    arm = scene.add_flexible_body("arm", body, joint=joint)
    hinge = kf.Revolute((1, 2, 3), speed=0.5, forces=kf.CoordinateForce(stiffness=3.0, rest=0.1))
    inertia = random_inertia(np.random.default_rng(0), 0.05)
    tip = scene.add_rigid_body("tip", 0.6, inertia, com=(0.1, 0.05, -0.1), joint=hinge, parent=arm.interface("tip"))
    scene.add_rotor(tip, "x", inertia=0.01, rate=rate)
    moon = scene.add_rigid_body("moon", 0.5, 0.1, joint=kf.Free(), at=(0, 1, 0))
    scene.add_spring("string", tip, moon, stiffness=5.0, rest_length=0.5)
    scene.add_bushing("gum", arm.interface("tip"), moon, stiffness=(1, 2, 3, 0.1, 0.2, 0.3))
    return scene.freeze()


def bar(spring: float = 1e6) -> Model:
    """Return a free stiff body whose six modes are of 190 Hz and more, tumbling at 20 rad/s."""
    scene = kf.System()
    joint = kf.Free(velocity=(0.1, 0.2, 0.0), angular_velocity=(1.0, 20.0, 0.3))
    body = lattice_body(3, {}, reduction=kf.CraigBampton(modes=6), spring=spring)
    scene.add_flexible_body("bar", body, joint=joint)
    return scene.freeze()


def pendulum(damping: float = 0.0, torque: float = 0.0) -> Model:
    """Return a double pendulum in gravity with springs, released at rest."""
    scene = kf.System(gravity=(0, 0, -9.81))
    upper = scene.add_rigid_body("upper", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("y"))
    hinge = kf.Revolute("y", forces=kf.CoordinateForce(stiffness=4.0, damping=damping))
    lower = scene.add_rigid_body("lower", 1.0, 0.1, com=(0.5, 0, 0), joint=hinge, parent=upper, at=(1, 0, 0))
    if torque:
        scene.add_motor(lower, torque)
    return scene.freeze()


def kept(model: Model, t: float, y: np.ndarray) -> np.ndarray:
    """Return energy + dissipated - work, momentum and angular momentum."""
    n, m = model.coordinate_count, model.free_count
    energy = model.energy(t, y[: n + m]).total + y[-2] - y[-1]
    return np.concatenate(([energy], *momenta(State(model, t, y[:n], y[n : n + m]))))


def stepper(model: Model, span: float, step: float) -> Stepper:
    return METHOD.make(Dynamics(model), 0.0, span, StepControl(1e-6, 1e-9, step))


def integrated(model: Model, span: float, step: float, outputs: int = 1) -> np.ndarray:
    """Return the states at times evenly spread over a span."""
    found, run = np.empty((outputs, len(model.initial_state) + 2)), stepper(model, span, step)
    assert run.integrate_through(np.linspace(0.0, span, outputs + 1)[1:], found, 10**9) == outputs
    return found


@pytest.mark.parametrize("make", [top, flexible])
def test_free_flight_keeps_energy_and_momenta(make: Callable[[], Model]) -> None:
    model = make()
    assert flies_freely(model)
    steps = 1000
    states = integrated(model, 0.02 * steps, 0.02, outputs=10)
    start = kept(model, 0.0, np.append(model.initial_state, [0.0, 0.0]))
    for i, y in enumerate(states):
        drift = kept(model, 0.02 * steps * (i + 1) / 10, y) - start
        # 1e-13 of the sizes of all energies is what a step is solved to; momenta about a far origin lose some of it
        assert abs(drift[0]) < 1e-11 * start[0]
        assert np.linalg.norm(drift[1:4]) < 1e-11 * np.linalg.norm(start[1:4])
        assert np.linalg.norm(drift[4:]) < 1e-10 * np.linalg.norm(start[4:])


@pytest.mark.parametrize(("damping", "torque"), [(0.0, 0.0), (0.3, 0.0), (0.0, 0.5)])
def test_a_tree_in_gravity_keeps_the_balance_of_energy(damping: float, torque: float) -> None:
    model = pendulum(damping, torque)
    assert not flies_freely(model)
    states = integrated(model, 10.0, 0.01, outputs=20)
    balance = [kept(model, 0.0, y)[0] for y in states]
    # the largest energies are those of the fall by 3 m, 30 J
    np.testing.assert_allclose(balance, 0.0, rtol=0, atol=1e-10)
    assert (states[-1, -2] > 1.0) == (damping > 0.0)
    assert (states[-1, -1] != 0.0) == (torque != 0.0)


@pytest.mark.parametrize("make", [top, flexible, pendulum])
def test_it_is_of_order_two(make: Callable[[], Model]) -> None:
    model = make()
    exact = integrate(model, (0.0, 0.5), rtol=1e-12, method="dop853", output_step=0.5)
    y = np.concatenate((exact.coordinates[-1], exact.speeds[-1]))
    errors = [abs(integrated(model, 0.5, step)[-1, :-2] - y) for step in (5e-3, 2.5e-3)]
    n = model.coordinate_count
    for part in (slice(n), slice(n, None)):
        assert errors[0][part].max() / errors[1][part].max() == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("make", [top, partial(flexible, rate=0.0), bar, pendulum])
def test_a_run_backwards_returns(make: Callable[[], Model]) -> None:
    model = make()
    n, m, step = model.coordinate_count, model.free_count, 0.01
    run, states = stepper(model, 100.0, step), np.empty((1, n + m + 2))
    run.integrate_through(np.array([100.0]), states, 100)
    y = run.state()
    y[n : n + m] *= -1.0
    run.restart(0.0, y)
    run.integrate_through(np.array([100.0]), states, 100)
    back, start = run.state(), model.initial_state
    # 200 steps, each solved to 1e-13 of speeds of 1; with one end's directions in place of means of both it is 1e-8
    np.testing.assert_allclose(back[:n], start[:n], rtol=0, atol=2e-10)
    np.testing.assert_allclose(back[n : n + m], -start[n:], rtol=0, atol=2e-9)


@pytest.mark.parametrize(
    ("spring", "step", "sweeps"), [(1e6, 1e-3, 6.3), (1e6, 5e-3, 11.0), (1e6, 2e-2, 22.0), (1e14, 5e-3, 11.0)]
)
def test_modes_that_steps_do_not_resolve_do_not_hold_it_up(spring: float, step: float, sweeps: float) -> None:
    """Steps of 1 to 24 radians of the lowest mode, or of 60,000, and of up to 0.4 radian of tumbling: few sweeps.

    Without turning modes on it is 7 in the first run, without mixing 27 in the third, and where the energy is weighed
    with accelerations of the sweep before, none of them comes to its end.
    """
    model, steps = bar(spring), 400
    run, states = stepper(model, 1e3, step), np.empty((1, len(model.initial_state) + 2))
    start = kept(model, 0.0, run.state())
    assert run.integrate_through(np.array([1e3]), states, steps) == 0
    assert run.statistics["steps"] == steps
    assert run.statistics["evaluations"] < sweeps * steps
    drift = kept(model, run.t, run.state()) - start
    assert abs(drift[0]) < 1e-12 * start[0]  # a step is solved to 1e-13, and none adds to what the others leave
    assert np.linalg.norm(drift[1:4]) < 1e-12 * np.linalg.norm(start[1:4])
    assert np.linalg.norm(drift[4:]) < 1e-12 * np.linalg.norm(start[4:])


def test_what_is_kept_is_so_at_outputs_after_very_many_steps() -> None:
    """Times of steps are no rounded sums: else outputs would come to lie between steps, where nothing is kept."""
    model, count, step = top(), 100_000, 0.1
    states = integrated(model, count * step, step, outputs=10)
    run = stepper(model, 2.0 * count * step, step)
    assert run.integrate_through(np.array([2.0 * count * step]), np.empty((1, states.shape[1])), count) == 0
    assert run.t == pytest.approx(count * step, rel=3e-16)  # a plain sum is off by 2e-12
    start = kept(model, 0.0, np.append(model.initial_state, [0.0, 0.0]))
    energies = np.array([kept(model, 0.0, y)[0] for y in states])
    np.testing.assert_allclose(energies, start[0], rtol=1e-12)


@pytest.mark.parametrize("make", [top, flexible, pendulum])
def test_the_balance_is_that_of_the_literal_route(make: Callable[[], Model]) -> None:
    model = make()
    n, m = model.coordinate_count, model.free_count
    q, u = random_state(model, 1)
    run = stepper(model, 1.0, 0.1)
    step, arrays = run.step, (run.integers, run.reals, run.vectors, np.zeros((1, 1)))
    step.at[: n + m] = np.concatenate((q, u))
    order_n(model).balance(Run(None, None, *arrays, np.zeros(0), np.zeros((0, 0)), 0, np.zeros(1, int)))
    energy = model.energy(0.0, np.concatenate((q, u)))
    assert step.energy == pytest.approx(energy.total, rel=1e-12)
    assert step.kinetic == pytest.approx(energy.kinetic, rel=1e-12)
    if not step.keeps_momenta:
        return
    linear, angular = momenta(State(model, 0.0, q, u))
    centre = np.array([*step.centre])
    np.testing.assert_allclose([*step.momentum], linear, rtol=0, atol=1e-12)
    about_centre = angular - np.cross(centre, linear)
    np.testing.assert_allclose([*step.spin], about_centre, rtol=0, atol=1e-12)
    # the rows are rigid motions: their kinetic energies are those of the mass and of the inertia about its centre
    R, M = step.rigid[:, n : n + m], model.mass_matrix(0.0, np.concatenate((q, u)))
    xx, xy, xz, yy, yz, zz = step.locked
    expected = np.zeros((6, 6))
    expected[:3, :3] = step.mass * np.eye(3)
    expected[3:, 3:] = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    np.testing.assert_allclose(R @ M @ R.T, expected, rtol=0, atol=1e-11 * abs(expected).max())


def test_states_between_the_steps_are_as_good_as_at_their_ends() -> None:
    model = top()
    exact = integrate(model, (0.0, 1.0), rtol=1e-12, method="dop853", output_step=0.02)
    found = integrate(model, (0.0, 1.0), step=0.05, method=NAME, output_step=0.02)
    errors = abs(found.coordinates - exact.coordinates).max(axis=1)
    assert errors.max() < 1.5 * errors[5::5].max()  # every fifth output is where a step ends


def test_functions_of_python_keep_the_balance() -> None:
    scene = kf.System(gravity=(0, 0, -9.81))
    cart = scene.add_rigid_body("cart", 1.0, 0.1, joint=kf.Prismatic("x"))
    bob = scene.add_rigid_body("bob", 1.0, 0.1, com=(0, 0, -0.5), joint=kf.Revolute("y", position=0.5), parent=cart)
    scene.add_motor(bob, lambda t: 0.3 * np.cos(2.0 * t))
    result = scene.simulate((0.0, 2.0), method=NAME, step=0.01)
    assert abs(result.energy.balance_error).max() < 1e-11


def test_a_run_goes_on_from_a_snapshot_to_the_bit() -> None:
    check_snapshot(lambda: stepper(flexible(), 1.0, 0.02), 1.0, 17)


def test_a_step_far_too_large_is_a_failure_with_advice() -> None:
    scene = kf.System()
    scene.add_rigid_body("top", 1.0, (1.0, 2.0, 3.0), joint=kf.Free(angular_velocity=(30.0, 20.0, 10.0)))
    with pytest.warns(kf.SimulationWarning, match="does not converge with steps of 1 s.*a smaller step"):
        result = scene.simulate((0.0, 10.0), method=NAME, step=1.0)
    assert result.status.kind == "failed"


def test_what_it_cannot_run_is_refused() -> None:
    scene = kf.System()
    scene.add_rigid_body("block", 1.0, 0.1, joint=kf.Prismatic("x"))
    with pytest.raises(kf.ModelError, match="needs a step"):
        scene.simulate((0.0, 1.0), method=NAME)
    scene = kf.System()
    scene.add_rigid_body("block", 1.0, 0.1, joint=kf.Prismatic("x", motion=kf.Motion.steady(1.0)))
    with pytest.raises(kf.ModelError, match=r"does not drive that of 'block'\. Remedy: 'radau5'"):
        scene.simulate((0.0, 1.0), method=NAME, step=0.1)


def floating_loop() -> Model:
    """Return four bodies in a loop of hinges that tumbles freely, with a spring across, which is damped."""
    scene = kf.System()
    joint = kf.Free(angular_velocity=(0.5, 1.0, 0.2), velocity=(1.0, 0.2, 0.0))
    base = scene.add_rigid_body("base", 1.0, (0.1, 0.2, 0.3), joint=joint)
    crank = scene.add_rigid_body("crank", 1.0, 0.05, com=(0.25, 0, 0), joint=kf.Revolute("z", speed=2.0), parent=base)
    rod_joint, rocker_joint = (kf.Revolute("z", position=kf.Guess(angle)) for angle in (1.2, 1.9))
    rod = scene.add_rigid_body("rod", 1.0, 0.05, com=(0.25, 0, 0), parent=crank, at=(0.5, 0, 0), joint=rod_joint)
    rocker = scene.add_rigid_body(
        "rocker", 1.0, 0.05, com=(0.25, 0, 0), parent=base, at=(0.7, 0, 0), joint=rocker_joint
    )
    scene.add_loop_joint("pin", kf.Revolute("z"), rod.frame(at=(0.5, 0, 0)), rocker.frame(at=(0.6, 0, 0)))
    scene.add_spring("band", crank.frame(at=(0.3, 0, 0)), rocker.frame(at=(0.3, 0, 0)), stiffness=20.0, damping=0.3)
    return scene.freeze()


LOOPS: dict[str, Callable[[], Model]] = {
    "four-bar": lambda: four_bar().freeze(),
    "floating": floating_loop,
    "flexible": lambda: bent_four_bars(1).freeze(),
}


@pytest.mark.parametrize("name", LOOPS)
def test_loops_keep_energy_and_momenta_and_stay_closed(name: str) -> None:
    span, steps = (0.1, (1e-3, 5e-4)) if name == "flexible" else (0.5, (0.01, 0.005))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", StartWarning)
        make = LOOPS[name]
        exact = integrate(make(), (0.0, span), method="dop853", rtol=1e-11, output_step=span / 5)
        runs = [integrate(make(), (0.0, span), method=NAME, step=step, output_step=span / 5) for step in steps]
        model = make()
    errors = [abs(run.coordinates[-1] - exact.coordinates[-1]).max() for run in runs]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.4)
    run = runs[1]
    states = np.hstack((run.coordinates, run.speeds))
    energies = np.array([sum(model.energy(t, y)[:3]) for t, y in zip(run.times, states, strict=True)])
    kept = energies + run.dissipated - run.work
    # what a step takes for round-off is 1e-13 of the sum of the sizes of all energies
    assert np.ptp(kept) <= 1e-12 * max(abs(energies).max(), np.ptp(energies), 1.0)
    for t, y in zip(run.times, states, strict=True):
        state = State(model, t, y[: model.coordinate_count], y[model.coordinate_count :])
        assert abs(constraint_residuals(state)).max() < 1e-10  # m and rad; the tolerance of closing times sizes of 1 m
    if name == "floating":
        assert flies_freely(model)
        found = np.array([np.concatenate(model.route.momenta(t, y)) for t, y in zip(run.times, states, strict=True)])
        assert np.ptp(found, axis=0) == pytest.approx(np.zeros(6), abs=1e-12 * np.abs(found).max())


def test_a_loop_to_the_ground_takes_momenta() -> None:
    scene = kf.System()
    block = scene.add_rigid_body("block", 1.0, 0.1, joint=kf.Free(velocity=(1.0, 0.0, 0.0)))
    scene.add_loop_joint("guide", kf.Prismatic("x"), scene.ground, block)
    assert not flies_freely(scene.freeze())
    run = scene.simulate((0.0, 1.0), method=NAME, step=0.1)
    assert run.position("block")[-1] == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
