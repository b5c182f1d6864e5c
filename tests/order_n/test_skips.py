"""What a scene does not need is not computed: what is skipped raises if it is called, and the numbers stay the same."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import kanefe as kf
import kanefe.integrate.dynamics
import kanefe.kane.energy
import kanefe.order_n.route
import kanefe.results.literal_sweeps
from kanefe.equations.model import Model
from kanefe.integrate.dynamics import Dynamics
from kanefe.kane.assemble import accelerations
from kanefe.kernels.bodies import ModalBody
from kanefe.kernels.values.records import column
from kanefe.literal.route import LiteralRoute
from kanefe.order_n.route import OrderN
from kanefe.states.state import State
from order_n_rates import order_n
from repository import surroundings
from scenes import lattice_body, random_inertia, random_state, unit_axis
from skip_scenes import FREE, SKIPS, chain, rates


def python(code: str, **environment: str) -> str:
    """Return what a fresh interpreter prints that finds this repository's packages and these tests."""
    variables = surroundings(**environment)
    run = subprocess.run([sys.executable, "-c", code], env=variables, capture_output=True, text=True, check=True)
    return run.stdout


@pytest.fixture(scope="module")
def calls() -> Any:
    # compiled kernels do not see that a function was replaced: in plain Python they do
    return json.loads(python("import skip_scenes; print(skip_scenes.report())", KANEFE_JIT="0"))


@pytest.mark.parametrize("name", SKIPS)
def test_kernels_skip_what_a_scene_has_not(calls: Any, name: str) -> None:
    functions, sparing, busy = calls[name]
    assert sparing == []
    if name.startswith("elastic"):  # without an attached body there is no interface, and without a load no field
        functions.remove("sweeps.outward.move_interface")
    assert busy == functions


@pytest.mark.parametrize(
    "name",
    [
        name
        for name in SKIPS
        if name
        not in ("damping product", "second-order displacement", "contacts out of reach", "points of rigid contacts")
        and name != "fluid around a body"
        and "off" not in name
    ],
)
def test_the_motion_is_that_of_the_scene_that_skips_nothing(name: str) -> None:
    _, sparing, busy = SKIPS[name]
    few, many = sparing(), busy()
    n = many.coordinate_count
    found = rates(many)
    # the same sums, contracted by the compiler in other ways
    np.testing.assert_allclose(rates(few), np.concatenate((found[:2], found[n : n + 2])), rtol=1e-13)


def test_without_damping_the_product_would_be_zero() -> None:
    model = chain(**FREE)
    assert order_n(model).flexible.bodies[0, column(ModalBody, "damped")] == -1
    y = np.concatenate((*random_state(model, 1), np.zeros(2)))
    expected = order_n(model).held_rates(0.0, y)[0]
    other = OrderN(model)
    bodies, pool = other.flexible.bodies.copy(), other.flexible.pool
    k = model.flexible_terms("arm").body.free_count
    bodies[0, column(ModalBody, "damped")] = len(pool)
    other.flexible = other.flexible._replace(bodies=bodies, pool=np.concatenate((pool, np.zeros(k * k))))
    np.testing.assert_allclose(other.held_rates(0.0, y)[0], expected, rtol=1e-13, atol=1e-13 * abs(expected).max())


def refuse(*arguments: Any, **options: Any) -> Any:
    raise LookupError("this should be skipped")


def loaded_arm() -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    arm = scene.add_flexible_body("arm", lattice_body(1, reduction=kf.CraigBampton(modes=2)), joint=kf.Revolute("y"))
    scene.add_rigid_body("tip", 0.5, 0.01, parent=arm.interface("tip"))
    return scene


def test_forces_that_do_no_work_are_computed_when_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    options: dict[str, Any] = {"rtol": 1e-4, "output_step": 0.02}
    asked = loaded_arm().simulate((0.0, 0.1), **options)
    force = asked.coupling_force("arm", "root")
    monkeypatch.setattr(kanefe.results.literal_sweeps, "LiteralForces", refuse)
    monkeypatch.setattr(kanefe.order_n.sweeps, "CompiledForces", refuse)
    result = loaded_arm().simulate((0.0, 0.1), **options)
    np.testing.assert_array_equal(result.position("tip"), asked.position("tip"))
    with pytest.raises(LookupError):
        result.coupling_force("arm", "root")
    assert abs(force).max() > 1.0


def test_no_power_is_computed_where_nothing_exchanges_energy(monkeypatch: pytest.MonkeyPatch) -> None:
    # nodes that rotate in the nodal form: a scene of the literal route
    scene = kf.System(gravity=(0, 0, -9.81))
    body = lattice_body(1, rotations=True, reduction=kf.CraigBampton(modes=2))
    arm = scene.add_flexible_body("arm", body, joint=kf.Revolute("y"))
    model = scene.freeze()
    assert isinstance(model.route, LiteralRoute)
    assert not model.has_power
    y = np.concatenate((*random_state(model, 1), np.zeros(2)))
    full = replace(model, bodies=(replace(model.bodies[0], loads=_zero_load(arm)),))
    assert full.has_power
    expected = Dynamics(full).rate(0.0, y)
    monkeypatch.setattr(kanefe.kane.energy, "load_power", refuse)
    monkeypatch.setattr(kanefe.kane.energy, "dissipated_power", refuse)
    np.testing.assert_array_equal(Dynamics(model).rate(0.0, y), expected)
    with pytest.raises(LookupError):
        Dynamics(full).rate(0.0, y)


def _zero_load(arm: Any) -> Any:
    scene = kf.System()
    scene.add_force(scene.add_rigid_body("body", 1.0, 0.1, joint=kf.Free()), (0.0, 0.0, 0.0))
    return scene.freeze().bodies[0].loads


def row_count(model: Model) -> int:
    return len(order_n(model).tables.rows)


def test_interfaces_have_rows_only_where_something_is_attached() -> None:
    def scene(attached: str) -> Model:
        made = kf.System()
        interfaces = {"root": "clamped", "tip": "rigid", "middle": "rigid"}
        arm = made.add_flexible_body("arm", lattice_body(1, interfaces), joint=kf.Revolute("z"))
        if attached == "body":
            made.add_rigid_body("tip", 0.5, 0.01, parent=arm.interface("tip"))
        elif attached == "load":
            made.add_force(arm.interface("middle"), (1, 2, 3))
        elif attached == "spring":
            made.add_spring("s", arm.interface("tip"), made.ground, stiffness=1.0)
        return made.freeze()

    assert row_count(scene("nothing")) == 1
    assert row_count(scene("load")) == row_count(scene("spring")) == 2
    assert row_count(scene("body")) == 3
    model = scene("body")
    q, u = random_state(model, 2)
    expected = accelerations(State(model, 0.0, q, u))
    found = model.rhs(0.0, np.concatenate((q, u)))[len(q) :]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * abs(expected).max())


def test_rigid_bodies_fixed_to_each_other_are_one_row() -> None:
    rng = np.random.default_rng(4)
    scene = kf.System(gravity=(1, 2, 3))
    arm = scene.add_rigid_body("arm", 1.0, random_inertia(rng), joint=kf.Revolute(unit_axis(rng)))
    for i in range(5):
        where = {"at": rng.uniform(-1, 1, 3), "orientation": rng.standard_normal(4)}
        arm = scene.add_rigid_body(f"part{i}", 1.0, random_inertia(rng), com=rng.uniform(-1, 1, 3), parent=arm, **where)
    scene.add_rigid_body("feather", 1.0, 0.1, parent=arm, gravity=False)
    model = scene.freeze()
    assert row_count(model) == 2  # gravity acts on all of a row or on none of it
    q, u = random_state(model, 1)
    assert model.rhs(0.0, np.concatenate((q, u)))[1:] == pytest.approx(
        accelerations(State(model, 0.0, q, u)), rel=1e-13
    )


def pendulum(**load: Any) -> kf.System:
    scene = kf.System(gravity=(0, -9.81, 0))
    arm = scene.add_rigid_body("arm", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("z"))
    last = scene.add_rigid_body("last", 1.0, 0.1, com=(0.5, 0, 0), parent=arm, at=(1, 0, 0), joint=kf.Revolute("z"))
    if load:
        scene.add_motor(last, load["motor"])
    return scene


def test_planar_scenes_take_the_planar_kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    model = pendulum().freeze()
    y = np.array([0.3, -0.2, 1.0, 0.5])
    in_space = OrderN(model)
    expected = in_space.held_rates(0.0, np.concatenate((y, np.zeros(2))))[0][:4]
    monkeypatch.setattr(OrderN, "kernel_in_space", property(refuse))
    np.testing.assert_allclose(model.rhs(0.0, y), expected, rtol=1e-13)
    with pytest.raises(LookupError):
        OrderN(model).held_rates(0.0, np.concatenate((y, np.zeros(2))))
    with pytest.raises(LookupError):
        chain().rhs(0.0, np.zeros(4))


def test_scenes_without_functions_of_the_user_stay_in_compiled_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    def run(scene: kf.System) -> np.ndarray:
        return scene.simulate((0.0, 0.1), method="rk4", step=1e-2).position("last")

    # the same motor torque, once as a function
    called = run(pendulum(motor=lambda t: 0.25))
    monkeypatch.setattr(OrderN, "held_rates", refuse)
    # rounding of 40 evaluations
    np.testing.assert_allclose(run(pendulum(motor=0.25)), called, rtol=1e-13, atol=1e-13)
    with pytest.raises(LookupError):
        run(pendulum(motor=lambda t: 0.25))


def test_functions_of_time_do_not_look_at_the_state(monkeypatch: pytest.MonkeyPatch) -> None:
    model = pendulum(motor=lambda t: 0.25).freeze()
    expected = model.rhs(0.0, model.initial_state)
    monkeypatch.setattr(kanefe.order_n.route, "SweptState", refuse)
    np.testing.assert_array_equal(model.rhs(0.0, model.initial_state), expected)
    asking = pendulum(motor=lambda t, state: 0.25).freeze()
    with pytest.raises(LookupError):
        asking.rhs(0.0, asking.initial_state)


IMPORTS = """
import sys
import kanefe as kf
scene = kf.System()
body = scene.add_rigid_body("body", 1.0, 0.1, joint=kf.Revolute("z"))
scene.add_force(body, (1, 0, 0))
print("numba" in sys.modules)
model = scene.freeze()
model.rhs(0.0, model.initial_state)
print("numba" in sys.modules)
"""


def test_numba_is_not_imported_where_kernels_are_built() -> None:
    assert python(IMPORTS, KANEFE_JIT="1").split() == ["False", "False"]
    assert python(IMPORTS, KANEFE_JIT="0").split() == ["False", "False"]


@pytest.mark.parametrize("is_looked_at", [False, True])
def test_looking_at_contacts_calls_no_function_of_the_user(is_looked_at: bool) -> None:
    """A ball bounces under a force of a function, and on a rope of a given length, whose events ask for it."""
    forces: list[float] = []
    lengths: list[float] = []

    def force(t: float, state: kf.SceneState) -> tuple[float, float, float]:  # of the state: not sampled for its jumps
        forces.append(t)
        return (0.0, 0.0, 0.1 * np.sin(t))

    def length(t: float) -> float:
        lengths.append(t)
        return 1.0 + 0.01 * t

    scene = kf.System(gravity=(0, 0, -9.81))
    ball = scene.add_point("ball", 1.0, at=(0, 0, 0.2))
    scene.add_force(ball, force)
    ground = scene.add_surface("ground", scene.ground, kf.shapes.Plane("z"))
    shape = scene.add_surface("shape", ball, kf.shapes.Sphere(0.1))
    scene.add_contact("drop", shape, ground, normal=kf.KelvinVoigt(1e4))
    if is_looked_at:
        peg = scene.ground.frame(at=(0, 0, 2.0))
        motion = kf.Motion(length, lambda t: 0.01, lambda t: 0.0)
        scene.add(kf.Rope("hoist", (peg, ball), axial_stiffness=10.0, length=motion, breaking_load=1e9))
    result = scene.simulate((0.0, 0.4), method="dop853")
    assert result.events["drop touch"].size > 0
    beside = result.statistics["evaluations"] + 20  # the start, and the states whose functions are checked again
    assert (len(forces) > beside) == is_looked_at
    assert bool(lengths) == is_looked_at
