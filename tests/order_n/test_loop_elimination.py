"""Loops are eliminated where their ends meet: work in proportion to their number, and the literal route's numbers."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.kane.assemble import held_accelerations
from kanefe.kane.state import State
from kanefe.kernels.constraints.row_paths import FIRST_GUEST
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.order_n.route import OrderN
from loop_scenes import four_bars, nested_loops

LAYOUTS = ("apart", "in a row", "one on the other")


def route_of(model: Model) -> OrderN:
    assert isinstance(model.route, OrderN)
    return model.route


def work_of(model: Model) -> dict[str, int]:
    """Return what an evaluation does for loops: visits, products at meetings, and entries of the envelope."""
    paths = route_of(model).loops.paths
    guests = np.diff(paths.meetings[:, FIRST_GUEST])
    return {"visits": len(paths.visits), "products": int((guests**2).sum()), "entries": int(paths.ends[-1])}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_work_grows_with_the_number_of_loops(layout: str) -> None:
    few, many = (work_of(four_bars(count, layout).freeze()) for count in (4, 8))
    for what, size in few.items():
        assert many[what] <= 2.2 * size, what


def test_loops_on_a_body_are_eliminated_there() -> None:
    model = four_bars(6, "apart", base="free").freeze()
    route = route_of(model)
    base = int(route.loops.paths.places.argmax()) - 1  # where the last place is
    assert base >= 0
    assert np.count_nonzero(np.diff(route.loops.paths.places)) == 1
    # the loops share nothing but the base: each is a block of its own
    assert np.all(np.diff(route.loops.paths.ends) <= 5)


@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_rates_are_those_of_the_literal_route(layout: str, base: str) -> None:
    assert_same(four_bars(5, layout, base=base).freeze())


def test_a_loop_through_another_loop() -> None:
    model = nested_loops().freeze()
    assert np.count_nonzero(np.diff(route_of(model).loops.paths.places)) == 1  # they share joints: all at N
    assert_same(model)


def test_a_loop_beside_another_on_a_moving_body_is_eliminated_before() -> None:
    """A strut to the ground holds the carrier of a four-bar from beside it: two places."""
    scene = four_bars(1, "apart", base="free")
    scene.add_distance(
        "strut", scene.body("base").frame(at=(0.1, 0.2, 0.3)), scene.ground.frame(at=(0.4, 0.9, 1.2)), 0.7
    )
    model = scene.freeze()
    assert np.count_nonzero(np.diff(route_of(model).loops.paths.places)) == 2
    assert_same(model)


def test_a_driven_crank_and_its_driving_force() -> None:
    scene = four_bars(2, "one on the other")
    wheel = scene.add_rigid_body("wheel", 1.0, 0.1, joint=kf.Revolute("y", motion=kf.Motion.steady(3.0)))
    scene.add_gear("gear", {wheel: 1.0, scene.body("crank 0"): 2.0})
    model = scene.freeze()
    assert_same(model)
    state = State(model, 0.0, model.initial_coordinates, model.initial_speeds)
    _, multipliers, _ = held_accelerations(state)
    force = scene.simulate((0.0, 0.01)).driving_force("wheel")
    # the gear is all that acts on the wheel, whose speed is steady: its multiplier, times its coefficient
    assert np.ravel(force)[0] == pytest.approx(-multipliers[-1], rel=1e-9)
    assert abs(multipliers[-1]) > 0.1  # N m: not that of a gear that holds nothing


def assert_same(model: Model) -> None:
    q, u = model.initial_coordinates, model.initial_speeds
    du, _, _ = held_accelerations(State(model, 0.0, q, u))
    rates, weakest = route_of(model).held_rates(0.0, np.concatenate((q, u, np.zeros(2))))
    assert weakest > NEAR_SINGULAR
    found = rates[model.coordinate_count : model.coordinate_count + model.free_count]
    np.testing.assert_allclose(found, du, rtol=0, atol=1e-11 * (1.0 + abs(du).max()))
