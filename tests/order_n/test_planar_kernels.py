"""The planar kernels against the literal route and the kernels in space; which scenes are planar."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.integrate.run import integrate
from kanefe.kane.assemble import accelerations
from kanefe.kernels.evaluation.evaluation import ASKED
from kanefe.kernels.planar.evaluation import evaluate_planar, planar_memory_size
from kanefe.kernels.planar.layout import ROW, PlanarTables, RowKind
from kanefe.kernels.steppers.step_commands import NOT_FINITE
from kanefe.order_n.planar_route import PlanarRoute
from kanefe.order_n.route import OrderN
from kanefe.order_n.tables.planar_tables import planar_tables
from kanefe.states.state import State
from random_scenes import Recipe, planar_model
from scenes import lattice_body, random_state

T = 0.3


def tables_of(model: Model) -> PlanarTables | None:
    return planar_tables(model, OrderN(model).tables)


def planar_rates(model: Model, t: float, y: np.ndarray) -> tuple[np.ndarray, int]:
    """Return dy/dt from the planar kernels, and what they return."""
    in_space, tables = OrderN(model), tables_of(model)
    assert tables is not None
    values = in_space.values(t, y)
    vectors = np.array((y, np.full(len(y), np.nan)))
    memory = np.empty(planar_memory_size(tables))
    done, _ = evaluate_planar(ASKED._replace(t=t), tables, in_space.drives(t), values, vectors, memory)
    return vectors[1], done


def state_of(model: Model, seed: int) -> np.ndarray:
    return np.concatenate((*random_state(model, seed), [0.0, 0.0]))


@pytest.mark.parametrize("seed", range(12))
def test_planar_equals_literal_and_space(seed: int) -> None:
    model = planar_model(Recipe(seed, bodies=8, loads=12))
    y, n, m = state_of(model, seed), model.coordinate_count, model.free_count
    rates, _ = planar_rates(model, T, y)
    literal = accelerations(State(model, T, y[:n], y[n : n + m]))
    # the mass matrices of these trees have condition numbers up to some 1e3
    np.testing.assert_allclose(rates[n : n + m], literal, rtol=0, atol=1e-11 * abs(literal).max())
    in_space = OrderN(model).held_rates(T, y)[0]
    np.testing.assert_allclose(rates, in_space, rtol=0, atol=1e-11 * abs(in_space).max())


@pytest.mark.parametrize("seed", range(3))
def test_steps_equal_those_in_space(seed: int) -> None:
    in_plane, in_space = (planar_model(Recipe(seed, bodies=8, loads=12, is_autonomous=True)) for _ in range(2))
    assert in_plane.route.is_autonomous
    assert isinstance(in_plane.route, PlanarRoute)
    in_space.__dict__["route"] = OrderN(in_space)
    options = {"method": "rk4", "step": 2e-3, "output_step": 0.02}
    states, expected = (integrate(model, (0.0, 0.08), **options).coordinates for model in (in_plane, in_space))
    # round-off of 1e-14 a step, which the motion over 0.08 s hardly grows
    np.testing.assert_allclose(states, expected, rtol=0, atol=1e-11 * abs(states).max())


def test_bodies_fixed_to_each_other_are_one_row_and_a_planar_joint_is_one() -> None:
    scene = kf.System()
    base = scene.add_rigid_body("base", 1.0, 0.1)
    cart = scene.add_rigid_body("cart", 1.0, 0.1, parent=base, joint=kf.Planar())
    mast = scene.add_rigid_body("mast", 1.0, 0.1, parent=cart, at=(0, 0.5, 0))
    scene.add_rigid_body("arm", 1.0, 0.1, parent=mast, joint=kf.Revolute((0, 0, -1)))
    tables = tables_of(scene.freeze())
    assert tables is not None
    assert len(tables.rows) == 3
    assert tables.rows[1, ROW.kind] == RowKind.FLOAT


@pytest.mark.parametrize(("turns", "tolerance"), [(0, 4e-16), (10, 4e-16), (2e5, 4e-16), (1e7, np.spacing(6.3e7))])
def test_angles_of_many_turns(turns: float, tolerance: float) -> None:
    scene = kf.System(gravity=(1.0, -9.81, 0.0))
    scene.add_rigid_body("bob", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("z"))
    model = scene.freeze()
    for angle in np.linspace(-3.5, 3.5, 29):
        y = np.array([angle + 2 * np.pi * turns, 0.0, 0.0, 0.0])
        rates, _ = planar_rates(model, 0.0, y)
        c, s = np.cos(y[0]), np.sin(y[0])
        # gravity is 9.9 m/s2, and the arm 0.5 m; other round-off is a few units in the last place of 14 rad/s2
        assert abs(rates[1] - 0.5 * (-9.81 * c - 1.0 * s) / (0.1 + 0.25)) < 0.5 * 9.9 / 0.35 * tolerance + 1e-14


def test_no_inertia_along_a_joint_is_told() -> None:
    for joint in (kf.Revolute("z"), kf.Prismatic("x"), kf.Planar()):
        for is_first in (False, True):
            scene = kf.System()
            arm = scene.add_rigid_body("arm", 1.0, 0.1, joint=kf.Revolute("z"))
            scene.add_frame("tip", parent=None if is_first else arm, joint=joint)
            model = scene.freeze()
            assert planar_rates(model, 0.0, state_of(model, 0))[1] == -1


def test_rates_that_are_not_finite_are_told() -> None:
    scene = kf.System()
    arm = scene.add_rigid_body("arm", 1.0, 0.1, com=(1, 0, 0), joint=kf.Revolute("z"))
    scene.add_rigid_body("hand", 1.0, 0.1, com=(1, 0, 0), parent=arm, at=(1, 0, 0), joint=kf.Revolute("z"))
    y = np.array([0.0, 1.0, 1e200, 1e200, 0.0, 0.0])
    assert planar_rates(scene.freeze(), 0.0, y)[1] == NOT_FINITE


def arm_and(**second: Any) -> kf.System:
    """Return an arm on a revolute joint about z, and a body on it."""
    scene = kf.System(gravity=(0, -9.81, 0))
    arm = scene.add_rigid_body("arm", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("z"))
    scene.add_rigid_body("second", 1.0, 0.1, com=(0.5, 0, 0), parent=arm, at=(1, 0, 0), **second)
    return scene


def with_flexible_body() -> kf.System:
    scene = arm_and()
    scene.add_flexible_body("flexible", lattice_body(planar=True))
    return scene


def with_spring() -> kf.System:
    scene = arm_and()
    body = scene.add_rigid_body("third", 1.0, 0.1, joint=kf.Planar(position=(3, 0)))
    scene.add_spring("spring", scene.ground, body, stiffness=1.0)
    return scene


def with_loop() -> kf.System:
    scene = arm_and(joint=kf.Revolute("z", position=2.0))
    body = scene.add_rigid_body("third", 1.0, 0.1, joint=kf.Planar(position=(3, 0)))
    scene.add_distance("rope", scene.ground, body, 3.0)
    return scene


def all_fixed() -> kf.System:
    scene = kf.System()
    scene.add_rigid_body("base", 1.0, 0.1)
    return scene


NOT_PLANAR = {
    "revolute across": lambda: arm_and(joint=kf.Revolute("y")),
    "revolute askew": lambda: arm_and(joint=kf.Revolute((0, 1e-9, 1))),
    "placed askew": lambda: arm_and(joint=kf.Revolute("z"), orientation=(1, 1e-9, 0, 0)),
    "prismatic along the normal": lambda: arm_and(joint=kf.Prismatic("z")),
    "planar joint askew": lambda: arm_and(joint=kf.Planar(), orientation=(1, 0, 0.1, 0)),
    "screw": lambda: arm_and(joint=kf.Screw("z", lead=0.1)),
    "cylindrical": lambda: arm_and(joint=kf.Cylindrical("z")),
    "universal": lambda: arm_and(joint=kf.Universal("z", "x")),
    "spherical": lambda: arm_and(joint=kf.Spherical()),
    "translation": lambda: arm_and(joint=kf.Translation()),
    "free": lambda: arm_and(joint=kf.Free()),
    "flexible": with_flexible_body,
    "spring": with_spring,
    "loop": with_loop,
    "nothing turns or slides": all_fixed,
}


@pytest.mark.parametrize("reason", NOT_PLANAR)
def test_scenes_that_are_not_planar(reason: str) -> None:
    assert tables_of(NOT_PLANAR[reason]().freeze()) is None


@pytest.mark.parametrize("axes", [[(1, 0, 0)], [(1, 1, 0), (1, 1, 0)], [(1, 0, 0), (1, 0, 0), (0.6, 0, 0.8)]])
def test_slides_alone_are_planar_if_there_is_a_plane(axes: list[tuple[float, ...]]) -> None:
    scene, parent = kf.System(gravity=(1, 2, 3)), None
    for i, axis in enumerate(axes):
        parent = scene.add_rigid_body(f"b{i}", 1.0, 0.1, parent=parent, joint=kf.Prismatic(axis))
    model = scene.freeze()
    y = state_of(model, 1)
    expected = OrderN(model).held_rates(0.0, y)[0]
    np.testing.assert_allclose(planar_rates(model, 0.0, y)[0], expected, rtol=0, atol=1e-13 * abs(expected).max())


def test_three_slides_in_space_are_not_planar() -> None:
    scene, parent = kf.System(), None
    for i, axis in enumerate("xyz"):
        parent = scene.add_rigid_body(f"b{i}", 1.0, 0.1, parent=parent, joint=kf.Prismatic(axis))
    assert tables_of(scene.freeze()) is None
