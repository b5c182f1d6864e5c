"""Newton matrices that keep the structure of a tree: they solve what dense ones solve, and cost what couples."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe import shapes
from kanefe.equations.model import Model
from kanefe.equations.routes import newton_pattern
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.kernel_stepper import KernelStepper
from kanefe.integrate.methods.radau5 import METHOD
from kanefe.integrate.run import integrate
from kanefe.integrate.stepper import StepControl
from kanefe.kernels.algebra import sparse
from kanefe.kernels.steppers import radau_systems
from kanefe.order_n import tree_matrix
from kanefe.order_n.tree_matrix import TreeMatrix, expected_work, filled_pattern, keeps_structure
from kanefe.tree.model_data import QUADRATURES
from random_scenes import Recipe, random_model
from run_scenes import check_snapshot


def sprung_chain(count: int, reach: int = 1) -> Model:
    """Return rods on hinges about changing axes, each with a spring and a damper to another further on."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    links: list[kf.RigidBody] = []
    for i in range(count):
        carrier = {"parent": links[-1], "at": (0.5, 0, 0)} if links else {}
        joint = kf.Revolute("zyx"[i % 3], position=0.1 * (-1) ** i)
        links.append(
            scene.add_rigid_body(f"link {i}", 1.0, (0.01, 0.02, 0.03), com=(0.2, 0, 0), joint=joint, **carrier)
        )
    for i, (one, other) in enumerate(zip(links, links[reach:], strict=False)):
        ends = one.frame(at=(0.1, 0.05, 0.0)), other.frame(at=(0.4, 0.05, 0.0))
        scene.add_spring(f"spring {i}", *ends, stiffness=1e4, damping=10.0)
    return scene.freeze()


def moved(model: Model, seed: int) -> np.ndarray:
    """Return a state with quadratures near the start."""
    rng = np.random.default_rng(seed)
    q = model.advance(model.initial_coordinates, 0.1 * rng.standard_normal(model.free_count))
    u = model.initial_speeds + 0.3 * rng.standard_normal(model.free_count)
    return np.concatenate((q, u, 0.01 * rng.standard_normal(model.state_count), np.zeros(QUADRATURES)))


def taken(monkeypatch: pytest.MonkeyPatch, is_tree: bool) -> None:
    """Let radau5 take matrices of trees in all scenes that have such, or in none."""
    monkeypatch.setattr(tree_matrix, "DEARER", 0.0 if is_tree else np.inf)


def solutions(model: Model, y: np.ndarray, h: float) -> tuple[KernelStepper, np.ndarray]:
    """Return what the real and the complex system of a step of h give for random residuals."""
    stepper = METHOD.make(Dynamics(model), 0.0, 1.0, StepControl(1e-6, 1e-9, None))
    step, size = stepper.step, len(y) - QUADRATURES
    step.state[:], step.h, step.at[:], step.time_at = y, h, y, 0.0
    stepper._differentiate(0.0, y)
    assert radau_systems.factorise_systems(step)
    r = np.random.default_rng(7).standard_normal((3, len(y)))
    radau_systems.solve_real(step, r[0])
    radau_systems.solve_complex(step, r[1], r[2])
    return stepper, r[:, :size]


RECIPES = [
    Recipe(seed, bodies=3 + seed, elastic=0.5 * (seed % 3 != 0), loads=seed % 4, between=seed % 4, is_autonomous=True,
           slopes=("rotation-vector", "tait-bryan")[seed % 2], has_fluid=seed % 2 == 0)
    for seed in range(8)
]  # fmt: skip


@pytest.mark.parametrize("recipe", RECIPES, ids=lambda recipe: str(recipe.seed))
def test_the_structure_solves_what_dense_matrices_solve(recipe: Recipe, monkeypatch: pytest.MonkeyPatch) -> None:
    """Joints of all kinds, flexible bodies, in fluids, with loads of all kinds, at a state in motion."""
    found = []
    for is_tree in (True, False):
        taken(monkeypatch, is_tree)
        model = random_model(recipe)
        assert (newton_pattern(model.route) is not None) == is_tree
        found.append(solutions(model, moved(model, recipe.seed), 0.03)[1])
    # round-off, 1e-15 to 1e-13 of the largest, times the condition of systems with modes of 1e4 rad/s
    assert found[0] == pytest.approx(found[1], abs=1e-9 * np.abs(found[1]).max())


def test_loads_with_states_and_coordinates_are_in_the_structure(monkeypatch: pytest.MonkeyPatch) -> None:
    def pressed() -> Model:
        scene = kf.System(gravity=(0.0, 0.0, -9.81))
        ball = scene.add_rigid_body("ball", 1.0, 0.01, joint=kf.Free(position=(0.0, 0.0, 0.0999), velocity=(0.3, 0, 0)))
        rod = scene.add_rigid_body("rod", 0.5, 0.02, com=(0.2, 0, 0), joint=kf.Revolute("y"), parent=ball)
        friction = kf.Coulomb(0.4, stiffness=1e4, damping=10.0)
        floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
        point = ball.frame(at=(0.0, 0.0, -0.1))
        scene.add_contact("foot", point, floor, normal=kf.HuntCrossley(1e5, damping=0.1), friction=friction)
        scene.add_spring("strut", rod.frame(at=(0.3, 0, 0)), scene.ground, stiffness=50.0, damping=1.0)
        return scene.freeze()

    found = []
    for is_tree in (True, False):
        taken(monkeypatch, is_tree)
        model = pressed()
        y = np.concatenate((model.initial_state, np.zeros(QUADRATURES)))
        found.append(solutions(model, y, 0.01)[1])
    assert found[0] == pytest.approx(found[1], abs=1e-9 * np.abs(found[1]).max())


def test_a_run_is_that_of_dense_matrices(monkeypatch: pytest.MonkeyPatch) -> None:
    """With dampers: energies, which the structure leaves out, cost no steps."""
    runs = []
    for is_tree in (True, False):
        taken(monkeypatch, is_tree)
        model = sprung_chain(8)
        runs.append(integrate(model, (0.0, 0.3), method="radau5", rtol=1e-6, output_step=0.1))
    counts = [run.statistics["steps"] for run in runs]
    assert counts[0] == pytest.approx(counts[1], rel=0.05)
    # both follow rtol: 1e-6 of angles of 1 rad
    assert runs[0].coordinates == pytest.approx(runs[1].coordinates, abs=1e-6)


def test_a_run_is_taken_up_again(monkeypatch: pytest.MonkeyPatch) -> None:
    taken(monkeypatch, True)
    model, control = sprung_chain(6), StepControl(1e-6, 1e-9, None)
    check_snapshot(lambda: METHOD.make(Dynamics(model), 0.0, 1.0, control), 0.2, 5)


def test_work_grows_with_the_links_and_with_what_couples_them() -> None:
    """Products of an elimination: in proportion to the links, and with the length of the paths between ends."""
    work = {(count, reach): TreeMatrix(sprung_chain(count, reach).route).pattern().work for count, reach in
            ((20, 1), (40, 1), (80, 1), (40, 2), (40, 4), (40, 39))}  # fmt: skip
    assert (work[80, 1] - work[40, 1]) == pytest.approx(2.0 * (work[40, 1] - work[20, 1]), rel=1e-12)
    assert work[40, 1] < work[40, 2] < work[40, 4]
    assert work[40, 39] < 6.0 * work[40, 1]  # one spring from end to end: each row of the chain between has to know it


@pytest.mark.parametrize(
    "recipe", [Recipe(seed, bodies=10, elastic=0.3 * seed, is_autonomous=True) for seed in range(3)]
)
def test_the_work_is_known_before_a_pattern_is_made(recipe: Recipe) -> None:
    route = random_model(recipe).route
    # it is for choices of methods; of rigid trees and of up to twelve modes a body within 20 %
    assert expected_work(route) == pytest.approx(TreeMatrix(route).pattern().work, rel=0.3)


def test_dense_matrices_are_kept_where_they_are_less_work_or_all_is_coupled() -> None:
    assert newton_pattern(sprung_chain(12).route) is None
    assert newton_pattern(sprung_chain(120).route) is not None

    def read(t: float, state: kf.StateView) -> float:
        return -float(state.joint_coordinates("link 0")[0])

    scene = kf.System()
    rod = scene.add_rigid_body("link 0", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("z"))
    scene.add_motor(rod, read)
    assert not keeps_structure(scene.freeze().route)


def test_sparse_factors_solve_with_what_they_fill_in() -> None:
    rng, n = np.random.default_rng(1), 12
    A = np.diag(rng.uniform(2.0, 3.0, n)) + np.diag(rng.uniform(-0.5, 0.5, n - 1), 1) * (rng.random((n, n)) < 1.0)
    A[n - 1] += rng.uniform(-0.5, 0.5, n)
    A[:, n - 1] += rng.uniform(-0.5, 0.5, n)
    A[7, 2] = A[3, 9] = 0.7
    rows, columns = np.nonzero(A)
    pattern = filled_pattern(rows, columns, n)
    for kind in (float, complex):
        given = A.astype(kind) * (np.exp(0.3j) if kind is complex else 1.0)
        values, x = np.zeros(len(pattern.columns), dtype=kind), rng.standard_normal(n).astype(kind)
        at = np.repeat(np.arange(n), np.diff(pattern.starts))
        values[:], b = given[at, pattern.columns], given @ x
        assert sparse.factorise_sparse(pattern, values, np.zeros(n, dtype=kind))
        sparse.solve_sparse(pattern, values, b)
        assert b == pytest.approx(x, abs=1e-13)
    values[pattern.diagonals[0]] = 0.0
    values[: pattern.starts[1]] = 0.0
    assert not sparse.factorise_sparse(pattern, values, np.zeros(n, dtype=complex))
