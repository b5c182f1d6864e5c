"""The order-n route equals the literal one in random scenes of everything there is; its Jacobian, and long chains.

The literal route is dense and in numpy, knows nothing of rows and sweeps, and is itself tested against balances and
finite differences. Examples are the same in every run (``derandomize``).
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

import kanefe as kf
from benchmarks.work_precision.rigid_chain import GRAVITY, chain_links, chain_scene
from exact_accelerations import exact_accelerations
from kanefe.equations.model import Model
from kanefe.kane.assemble import accelerations, held_accelerations
from kanefe.kane.coupling import recovered_forces
from kanefe.kane.energy import dissipated_power, drive_power, load_power
from kanefe.kane.reactions import joint_reactions
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.literal.loop_closure import project_positions, project_speeds
from kanefe.order_n.planar_route import PlanarRoute
from kanefe.states.state import State
from kanefe.tree.bent import bent_too_far
from loop_scenes import spatial_loop
from order_n_rates import T, order_n, rates_of_recipes
from random_loops import LoopScene, closed_state, constraint_jacobian
from random_scenes import Recipe, elastic_body, planar_model, random_model, recipes
from repository import surroundings
from scenes import random_state


def examples(count: int) -> settings:
    checks = [HealthCheck.too_slow, HealthCheck.filter_too_much]
    return settings(max_examples=count, derandomize=True, deadline=None, database=None, suppress_health_check=checks)


def literal_powers(model: Model, t: float, q: np.ndarray, u: np.ndarray, du: np.ndarray) -> np.ndarray:
    work = load_power(State(model, t, q, u)) + drive_power(State(model, t, q, u), du)
    return np.array([dissipated_power(State(model, t, q, u)), work])


def condition(model: Model, t: float, q: np.ndarray, u: np.ndarray) -> float:
    """Return the condition number of the mass matrix, which multiplies round-off, with a diagonal of ones."""
    M = model.mass_matrix(t, np.concatenate((q, u)))
    sizes = np.sqrt(np.diag(M))
    return float(np.linalg.cond(M / np.outer(sizes, sizes))) if len(M) else 1.0


def compare(model: Model, t: float, q: np.ndarray, u: np.ndarray, du: np.ndarray, tolerance: float) -> None:
    """Check dy/dt of the order-n route, to a share of the largest acceleration (of 1 m/s2 or rad/s2 at least)."""
    n, m = model.coordinate_count, model.free_count
    rates = order_n(model).held_rates(t, np.concatenate((q, u, np.zeros(2))))[0]
    size = 1.0 + abs(du).max(initial=0.0)
    np.testing.assert_allclose(
        rates[:n], model.coordinate_rates(q, u), rtol=0, atol=1e-13 * (1 + abs(u).max(initial=0))
    )
    np.testing.assert_allclose(rates[n : n + m], du, rtol=0, atol=tolerance * size)
    powers = literal_powers(model, t, q, u, du)
    # the powers of drives are forces that come from these accelerations, times speeds of some units
    np.testing.assert_allclose(rates[n + m :], powers, rtol=0, atol=10 * tolerance * (size + abs(powers).max()))


def check_tree(model: Model, seed: int) -> None:
    q, u = random_state(model, seed)
    # where a stiffened body has lost inertia: that is told, and no equations
    assume(not bent_too_far(model.literal, T, q, u))
    # modes of light bodies on long chains: condition numbers up to 1e6, which the sweeps feel less than the dense solve
    tolerance = max(1e-11, np.finfo(float).eps * condition(model, T, q, u))
    compare(model, T, q, u, accelerations(State(model, T, q, u)), tolerance)


@examples(50)
@given(recipes())
def test_rigid_trees(recipe: Recipe) -> None:
    check_tree(random_model(recipe), recipe.seed)


@examples(35)
@given(recipes(elastic=0.4))
def test_trees_with_flexible_bodies(recipe: Recipe) -> None:
    check_tree(random_model(recipe), recipe.seed)


@examples(25)
@given(recipes(bodies=15, elastic=0.3, between=6))
def test_trees_with_springs_and_bushings(recipe: Recipe) -> None:
    check_tree(random_model(recipe), recipe.seed)


@examples(25)
@given(recipes())
def test_planar_trees(recipe: Recipe) -> None:
    model = planar_model(recipe)
    assert isinstance(model.route, PlanarRoute)
    check_tree(model, recipe.seed)


def has_same_loops(recipe: Recipe, loops: int) -> bool:
    """Compare both routes; tell whether there was anything to compare."""
    model = LoopScene(recipe, loops).frozen()
    state = closed_state(model, recipe.seed) if model is not None and model.constraints else None
    if model is None or state is None:
        return False
    q, u = state
    du, _, weakest = held_accelerations(State(model, 0.0, q, u))
    _, pivot = order_n(model).held_rates(0.0, np.concatenate((q, u, np.zeros(2))))
    # runs leave states nearer to a singular position than NEAR_SINGULAR to the literal route
    weakest = min(weakest, pivot)
    if weakest < 1e-3 * NEAR_SINGULAR:
        return False
    # round-off of a constraint that hardly holds anything grows by as much
    tolerance = np.finfo(float).eps * condition(model, 0.0, q, u) / min(weakest, 1.0)
    compare(model, 0.0, q, u, du, max(1e-11, tolerance))
    return True


@examples(35)
@given(recipes(bodies=12, loads=4), st.integers(1, 3))
def test_rigid_loops(recipe: Recipe, loops: int) -> None:
    assume(has_same_loops(recipe, loops))


@examples(25)
@given(recipes(bodies=12, loads=4, elastic=0.4, between=2), st.integers(1, 3))
def test_loops_with_flexible_bodies(recipe: Recipe, loops: int) -> None:
    assume(has_same_loops(recipe, loops))


@examples(15)
@given(recipes(bodies=12, elastic=0.7, loads=3, between=1, has_fluid=True))
def test_trees_with_bodies_in_a_fluid_and_balls_with_rotors(recipe: Recipe) -> None:
    check_tree(random_model(recipe), recipe.seed)


@examples(20)
@given(recipes(bodies=8, elastic=0.5, has_fluid=True), st.integers(1, 2))
def test_loops_with_bodies_in_a_fluid_and_balls_with_rotors(recipe: Recipe, loops: int) -> None:
    assume(has_same_loops(recipe, loops))


@examples(20)
@given(recipes(bodies=12, loads=2))
def test_rows_of_loops_that_are_open_and_slip(recipe: Recipe) -> None:
    # between its projections an integrator sees such states, and terms that vanish on closed loops
    model = LoopScene(recipe, 1).frozen()
    assume(model is not None and len(model.constraints) == 1)  # rows that say the same twice contradict each other here
    q, u = random_state(model, recipe.seed)
    J = constraint_jacobian(model, q, u)[:, : model.free_count]
    assume(np.linalg.matrix_rank(J, tol=1e-3) == len(J))
    du, _, weakest = held_accelerations(State(model, 0.0, q, u))
    _, pivot = order_n(model).held_rates(0.0, np.concatenate((q, u, np.zeros(2))))
    assume(min(weakest, pivot) >= 1e-3 * NEAR_SINGULAR)
    compare(model, 0.0, q, u, du, 1e-11)


def test_thirty_bodies_with_loops() -> None:
    recipes = [Recipe(seed, bodies=30, elastic=0.2, between=1) for seed in range(6)]
    assert sum(has_same_loops(recipe, loops=4) for recipe in recipes) >= 4


@pytest.mark.parametrize("seed", range(12))
def test_reactions_carry_what_the_joints_exert(seed: int) -> None:
    # the reactions come from the balance of the bodies with the accelerations of the order-n route: along its free
    # coordinates a joint exerts its own forces, and nothing if it has none
    model = random_model(Recipe(seed, bodies=20, elastic=0.3, loads=6))
    q, u = random_state(model, seed)
    y = np.concatenate((q, u, np.zeros(2)))
    du = order_n(model).held_rates(T, y)[0][len(q) : len(q) + len(u)]
    driving, _ = recovered_forces(State(model, T, q, u), du)
    expected = literal_driving(model, q, u)
    np.testing.assert_allclose(driving, expected, rtol=0, atol=1e-10 * (1 + abs(expected).max(initial=0.0)))
    for body, reaction in zip(model.bodies, joint_reactions(State(model, T, q, u), du), strict=True):
        if body.joint_loads or body.has_coordinate_forces or body.is_driven:
            continue
        at = body.joint_coordinates(T, q)
        V, W = body.joint.partial_velocities(at)
        _, A_FM = body.joint.pose(at)
        along = (A_FM.T @ V).T @ reaction[:3] + (A_FM.T @ W).T @ reaction[3:]
        np.testing.assert_allclose(along, 0.0, atol=1e-10 * (1 + abs(reaction).max()))


def literal_driving(model: Model, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    return recovered_forces(State(model, T, q, u), accelerations(State(model, T, q, u)))[0]


# Central differences of order 8; friction bends over 0.1 rad/s, modes swing with some 1e2 rad/s.
STEP = 5e-4
OFFSETS = np.arange(-4, 5)
WEIGHTS = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280]) / STEP


def differences(model: Model, t: float, y: np.ndarray) -> np.ndarray:
    J = np.empty((len(y), len(y)))
    for i in range(len(y)):
        step = STEP * np.eye(len(y))[i]
        J[:, i] = sum(w * model.rhs(t, y + k * step) for w, k in zip(WEIGHTS, OFFSETS, strict=True) if k)
    return J


@pytest.mark.parametrize(
    "make",
    [
        lambda: random_model(Recipe(11, bodies=8, elastic=0.4, loads=5, between=3, is_autonomous=True)),
        lambda: random_model(Recipe(1, 8, 0.5, 4, 2, True, "tait-bryan")),
        lambda: spatial_loop(2).freeze(),
    ],
    ids=["rotation vector", "tait-bryan", "driven, with loops"],
)
def test_jacobian_equals_differences(make: Callable[[], Model]) -> None:
    model = make()
    q, u = random_state(model, 5, amplitude=0.02, speed=0.5)
    if model.constraints:
        q, u = model.initial_coordinates, model.initial_speeds
    y = np.concatenate((q, u))
    J = model.jacobian(T, y)
    # round-off of 1e-16 of the rates, which are some 1e-2 to 1e-1 of the largest entry, over the step
    np.testing.assert_allclose(J, differences(model, T, y), rtol=0, atol=1e-9 * abs(J).max())
    assert abs(J).max() > 1.0


def test_a_chain_of_a_thousand_links_is_right() -> None:
    count = 1000
    q, u = np.random.default_rng(1000).standard_normal((2, count))
    exact, bound = exact_accelerations(chain_links(count), GRAVITY, q, u)
    found = chain_scene(count).freeze().rhs(0.0, np.concatenate((q, u)))[count:]
    # the goal of the project; the judge's own error is counted
    assert float(abs(found - exact).max() / abs(exact).max()) + bound < 1e-9


PLAIN = """
import json, sys
import numpy as np
from kanefe.kernels.compiler._numba import IS_COMPILED
from order_n_rates import rates_of_recipes
print(json.dumps([IS_COMPILED, "numba" in sys.modules, [list(rates) for rates in rates_of_recipes()]]))
"""


def test_plain_python_gives_the_numbers_of_compiled_code() -> None:
    environment = surroundings(KANEFE_JIT="0")
    run = subprocess.run([sys.executable, "-c", PLAIN], env=environment, capture_output=True, text=True, check=True)
    is_compiled, has_numba, plain = json.loads(run.stdout)
    assert not is_compiled
    assert not has_numba
    for ours, theirs in zip(rates_of_recipes(), plain, strict=True):
        # sums in another order, contracted products: round-off times condition numbers of some 1e3
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12 * abs(ours).max())


@pytest.mark.filterwarnings("ignore:divide by zero", "ignore:invalid value")  # of numpy, without compiled kernels
def test_a_joint_without_inertia_is_named() -> None:
    scene = kf.System()
    arm = scene.add_rigid_body("arm", 1.0, 0.1, joint=kf.Revolute("z"))
    scene.add_frame("tip", parent=arm, joint=kf.Revolute("y"))
    model = scene.freeze()
    with pytest.raises(kf.SimulationError, match="nothing has inertia along tip: rate"):
        model.rhs(0.0, model.initial_state)


# inertia that is zero about an axis is round-off of the others once it is turned in space
@pytest.mark.filterwarnings("ignore:divide by zero", "ignore:invalid value")  # of numpy, without compiled kernels
@pytest.mark.parametrize(
    ("joint", "inertia"),
    [
        (kf.Free(angular_velocity=(0.1, 1.0, 0.0)), (0.0, 1.0, 1.0)),
        (kf.Free(orientation=(1.0, 0.3, -0.5, 0.2)), (0.0, 1.0, 1.0)),
        (kf.Free(), (0.0, 0.0, 0.0)),
        (kf.Spherical(orientation=(1.0, 0.3, -0.5, 0.2)), (0.0, 1.0, 1.0)),
    ],
)
def test_a_zero_of_inertia_is_named_however_it_is_turned(joint, inertia):
    scene = kf.System()
    scene.add_rigid_body("rod", 1.0, inertia, joint=joint)
    model = scene.freeze()
    with pytest.raises(kf.SimulationError, match="nothing has inertia along rod: wx"):
        model.rhs(0.0, model.initial_state)


@pytest.mark.parametrize("seed", range(4))
def test_a_loop_between_parts_of_one_body_holds_nothing(seed: int) -> None:
    # all rows are round-off: measured by each other they would stop the pendulum in the air
    rng = np.random.default_rng(seed)
    scene = kf.System(gravity=(0.3, -9.81, 0.5))
    arm = scene.add_rigid_body("arm", 1.0, 0.1, com=(0.4, 0.1, 0), joint=kf.Revolute(rng.standard_normal(3)))
    where = {"at": rng.uniform(-1, 1, 3), "orientation": rng.standard_normal(4)}
    part = scene.add_rigid_body("part", 1.0, 0.1, parent=arm, **where)
    inner = {"at": rng.uniform(-1, 1, 3), "orientation": rng.standard_normal(4)}  # the same place, rounded otherwise
    ends = arm.frame(**where).frame(**inner), part.frame(**inner)
    scene.add_loop_joint("glue", kf.Universal((1, 2, 3), (3, -1, 0.5)), *ends)
    model = scene.freeze()
    y = np.array([0.7, 1.3])
    free = model.forces(0.0, y) / model.mass_matrix(0.0, y)[0, 0]
    assert accelerations(State(model, 0.0, y[:1], y[1:])) == pytest.approx(free, rel=1e-12)
    assert order_n(model).held_rates(0.0, np.concatenate((y, np.zeros(2))))[0][1:2] == pytest.approx(free, rel=1e-12)


def test_loops_where_nothing_is_free() -> None:
    scene = kf.System()
    body = scene.add_rigid_body("body", 1.0, 0.1, at=(1, 0, 0))
    scene.add_distance("rod", scene.ground, body, 1.0 + 1e-13)  # as good as closed: there is something to improve
    model = scene.freeze()
    assert project_positions(model, 0.0, model.initial_coordinates).shape == (0,)
    assert project_speeds(model, 0.0, model.initial_coordinates, np.zeros(0)).shape == (0,)
    assert accelerations(State(model, 0.0, np.zeros(0), np.zeros(0))).shape == (0,)
    assert model.rhs(0.0, np.zeros(0)).shape == (0,)


def test_a_gear_on_a_driven_wheel() -> None:
    # the wheel turns as told, the other one by the gear: its acceleration and the power of the drive are known
    scene = kf.System()
    motion = kf.Motion(lambda t: t**3, lambda t: 3 * t**2, lambda t: 6 * t)
    driver = scene.add_rigid_body("driver", 1.0, 0.2, joint=kf.Revolute("z", motion=motion))
    driven = scene.add_rigid_body("driven", 1.0, 0.5, at=(1, 0, 0), joint=kf.Revolute("z"))
    scene.add_gear("pair", {driver: 2.0, driven: 1.0})
    model = scene.freeze()
    t = 0.5
    rates = order_n(model).held_rates(t, np.array([-2 * t**3, -6 * t**2, 0.0, 0.0]))[0]
    assert rates[1] == pytest.approx(-12 * t, rel=1e-13)
    assert rates[3] == pytest.approx((0.2 + 4 * 0.5) * 6 * t * 3 * t**2, rel=1e-13)


def test_a_flexible_body_without_modes_is_loaded_like_a_rigid_one() -> None:
    body = elastic_body("no modes", 0)
    scene = kf.System(gravity=(1, 2, 3))
    member = scene.add_flexible_body("member", body, joint=kf.Revolute("y"))
    scene.add_rigid_body("child", 1.0, 0.1, parent=member.interface("tip"), com=(0.1, 0.2, 0.3), joint=kf.Revolute("z"))
    scene.add_traction(member, "side", (1.0, 2.0, 3.0))
    model = scene.freeze()
    assert body.free_count == 0
    q, u = random_state(model, 0)
    np.testing.assert_allclose(
        model.rhs(0.0, np.concatenate((q, u)))[2:], accelerations(State(model, 0.0, q, u)), rtol=1e-13
    )
