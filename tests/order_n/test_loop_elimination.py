"""Loops are eliminated where their ends meet: work in proportion to their number, and the literal route's numbers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.kane.assemble import held_accelerations
from kanefe.kane.energy import dissipated_power, drive_power, load_power
from kanefe.kernels.constraints.closing import ENDED, closing_memory_size
from kanefe.kernels.constraints.loop_tables import RowWork
from kanefe.kernels.constraints.row_paths import Meetings
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.literal.loop_closure import openings, project_positions
from kanefe.order_n.route import OrderN
from kanefe.states.constraints import constraint_rates
from kanefe.states.state import State
from kanefe.tree.model_data import QUADRATURES
from loop_scenes import bent_four_bars, four_bar, four_bars, geared_bars, nested_loops

LAYOUTS = ("apart", "in a row", "one on the other")
SPEEDING_UP = kf.Motion(lambda t: 0.3 + t + t * t, lambda t: 1.0 + 2.0 * t, lambda _: 2.0)


def route_of(model: Model) -> OrderN:
    assert isinstance(model.route, OrderN)
    return model.route


def work_of(model: Model) -> dict[str, int]:
    """Return what an evaluation does for loops: visits, meetings and products there, and entries of the envelope."""
    paths = route_of(model).loops.paths
    guests = np.diff([meeting.first_guest for meeting in Meetings(paths.meetings)])
    return {
        "visits": len(paths.visits),
        "numbers": RowWork(route_of(model).loops.sizes, np.zeros(0)).visit_numbers,
        "meetings": len(guests),
        "products": int((guests**2).sum()),
        "entries": int(paths.ends[-1]),
    }


@pytest.mark.parametrize("closed_by", ["pins", "rods"])
@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_work_grows_with_the_number_of_loops(layout: str, base: str, closed_by: str) -> None:
    few, many = (work_of(four_bars(count, layout, base=base, closed_by=closed_by).freeze()) for count in (10, 20))
    for what, size in few.items():
        # twice as much, and a tenth more for what differs at the ends of a row
        assert size < many[what] <= 2.2 * size, what


def test_gears_between_loops_add_work_with_their_number() -> None:
    few, many = (work_of(geared_bars(count).freeze()) for count in (10, 20))
    for what, size in few.items():
        assert size < many[what] <= 2.2 * size, what


def test_each_of_four_bars_upon_each_other_is_eliminated_by_itself() -> None:
    paths = route_of(four_bars(6, "one on the other").freeze()).loops.paths
    assert np.diff(paths.places)[np.diff(paths.places) > 0].tolist() == [5] * 6  # the rows of a pin
    assert len(paths.order) == 30


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
    assert_same(four_bars(10, layout, base=base).freeze())


@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_driven_crank_moves_all_as_the_literal_route_tells(layout: str, base: str) -> None:
    model = four_bars(10, layout, base=base, motion=SPEEDING_UP).freeze()
    assert model.driven_count == 1
    assert_same(model)


def test_gears_join_the_loops_on_a_body() -> None:
    model = geared_bars(10).freeze()
    places = np.diff(route_of(model).loops.paths.places)
    assert places[places > 0].tolist() == [5 * 10 + 9]  # pins and gears, at the body that carries all
    assert_same(model)


@pytest.mark.parametrize("seed", [2, 3])
def test_flexible_couplers_that_carry_more_loops(seed: int) -> None:
    model = bent_four_bars(seed).freeze()
    assert np.count_nonzero(np.diff(route_of(model).loops.paths.places)) == 2  # at the base, and at the tip above
    assert_same(model)
    q, u = near(model, seed, 0.02)
    assert_same(model, *parts(model, model.route.projected(0.0, np.concatenate((q, u)))))


@pytest.mark.parametrize("closed_by", ["pins", "rods"])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_state_that_is_a_little_open_is_closed(layout: str, closed_by: str) -> None:
    assert_closes(four_bars(6, layout, base="free", closed_by=closed_by).freeze())


@pytest.mark.parametrize("make", [nested_loops, lambda: geared_bars(4), lambda: bent_four_bars(3)])
def test_nested_geared_and_flexible_loops_are_closed(make: Callable[[], kf.System]) -> None:
    assert_closes(make().freeze())


def assert_closes(model: Model) -> None:
    q, u = near(model, 1, 1e-4)
    # by more than a step of an integrator may leave open
    assert openings(model, 0.0, q).worst > 1e-5
    assert slip(model, q, u) > 1e-5
    q, u = parts(model, model.route.projected(0.0, np.concatenate((q, u))))
    assert openings(model, 0.0, q).worst < 1e-12
    assert slip(model, q, u) < 1e-11 * (1.0 + abs(u).max())


def near(model: Model, seed: int, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a random state beside the start."""
    rng = np.random.default_rng(seed)
    q = model.advance(model.initial_coordinates, size * rng.standard_normal(model.free_count))
    return q, model.initial_speeds + size * rng.standard_normal(model.free_count)


def parts(model: Model, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return y[: model.coordinate_count], y[model.coordinate_count :]


def slip(model: Model, q: np.ndarray, u: np.ndarray) -> float:
    """Return the largest rate at which a loop opens."""
    state = State(model, 0.0, q, u)
    J = constraint_rates(state).J
    return float(abs(J @ state.full[: J.shape[1]]).max())


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


def assert_same(model: Model, q: np.ndarray | None = None, u: np.ndarray | None = None) -> None:
    """Compare the rates of both routes, at the start if nothing else is told."""
    q = model.initial_coordinates if q is None else q
    u = model.initial_speeds if u is None else u
    du, _, _ = held_accelerations(State(model, 0.0, q, u))
    rates, weakest = route_of(model).held_rates(0.0, np.concatenate((q, u, np.zeros(2))))
    assert weakest > NEAR_SINGULAR
    n, size = model.coordinate_count, 1.0 + abs(du).max()
    np.testing.assert_allclose(rates[n : n + len(du)], du, rtol=0, atol=1e-11 * size)
    state = State(model, 0.0, q, u)
    powers = dissipated_power(state), load_power(state) + drive_power(state, du)
    # those of drives are forces that come from these accelerations, times speeds of some units
    np.testing.assert_allclose(rates[n + len(du) :], powers, rtol=0, atol=1e-10 * (size + np.abs(powers).max()))


@pytest.mark.parametrize("angle", [1e-2, 1e-4, 1e-6])
def test_a_loop_near_its_singular_position_is_weak_beside_another(angle: float) -> None:
    """Nearly straight with two bars a rod holds them by the square of the angle, beside a loop that is not."""
    scene = kf.System(gravity=(0, 0, -9.81))
    for name, x, first, second, end in (("flat", 0.0, angle, -0.5 * angle, 2.0), ("bent", 5.0, 0.3, 0.9, 7.0)):
        upper = scene.add_rigid_body(
            f"{name} 0", 1.0, 1e-2, com=(0.1, 0, 0), at=(x, 0, 0), joint=kf.Revolute("y", position=first)
        )
        lower = scene.add_rigid_body(
            f"{name} 1",
            1.0,
            1e-2,
            com=(0.1, 0, 0),
            parent=upper,
            at=(0.5, 0, 0),
            joint=kf.Revolute("y", position=second),
        )
        turns = first, first + second
        place = 0.5 * np.array((np.cos(turns).sum(), 0.0, -np.sin(turns).sum())) + (x, 0.0, 0.0)
        pin = np.array((end, 0.0, 0.0))
        length = float(np.linalg.norm(place - pin))
        scene.add_distance(f"{name} rod", lower.frame(at=(0.5, 0, 0)), scene.ground.frame(at=tuple(pin)), length)
    model = scene.freeze()
    q, u = model.initial_coordinates, model.initial_speeds
    _, _, weakest = held_accelerations(State(model, 0.0, q, u))
    _, found = route_of(model).held_rates(0.0, np.concatenate((q, u, np.zeros(2))))
    assert weakest < 10.0 * angle**2
    # one is relative to inertias, the other to displacements
    assert 0.1 * weakest < found < 10.0 * weakest


def test_loops_that_are_switched_off_do_not_make_others_weak() -> None:
    """Nothing is factored where the strut would be: only what holds is measured."""
    scene = four_bars(1, "apart", base="free")
    plain = scene.copy().freeze()
    ends = scene.body("base").frame(at=(0.1, 0.2, 0.3)), scene.ground.frame(at=(0.4, 0.9, 1.2))
    scene.add_distance("strut", *ends, 0.7, starts_on=False)
    model = scene.freeze()
    assert np.count_nonzero(np.diff(route_of(model).loops.paths.places)) == 2
    found = [
        route_of(one).held_rates(0.0, np.concatenate((one.route.start(0.0), np.zeros(2))))[1] for one in (plain, model)
    ]
    assert found[1] == found[0] > NEAR_SINGULAR


@pytest.mark.parametrize("layout", ["apart", "in a row", "one on the other"])
def test_nothing_is_eliminated_where_loops_are_open_by_round_off_alone(layout: str) -> None:
    """The pivot that is returned is 1 where nothing was eliminated."""
    model = four_bars(3, layout).freeze()
    route = model.route
    assert isinstance(route, OrderN)
    n, m = model.coordinate_count, model.free_count
    memory = np.empty(closing_memory_size(route.scene))

    def closed(share: float) -> tuple[np.ndarray, float]:
        y = np.concatenate((model.initial_coordinates, np.zeros(m), model.initial_states, np.zeros(QUADRATURES)))
        y[n : n + m] += share * np.random.default_rng(3).standard_normal(m)
        ended, weakest = route.closing(0.0, route.drives(0.0), y, memory)
        assert ended == ENDED.closed
        return y, weakest

    still, pivot = closed(0.0)
    assert pivot == 1.0
    np.testing.assert_array_equal(still[:n], model.initial_coordinates)
    moved, pivot = closed(1e-13)
    assert pivot < 1.0
    assert np.abs(openings_of_speeds(model, moved)).max() < 1e-15


def openings_of_speeds(model: Model, y: np.ndarray) -> np.ndarray:
    q, u, _ = model.parts(y[:-QUADRATURES])
    state = State(model, 0.0, q, u)
    return constraint_rates(state).open_rates(state.full)


def test_rows_at_markers_beside_their_links_tell_how_near_a_dead_centre_is() -> None:
    """The pins are 2 m and 0.9 m from the joints of their bars: coupler and rocker come into line."""
    model = four_bar(rocker=0.9, motion=kf.Motion.steady(2.0, 0.6)).freeze()
    q = np.array((-2.728843865, 1.305535183))
    state = State(model, 0.99, project_positions(model, 0.99, q), np.zeros(2))
    literal = held_accelerations(state)[2]
    assert literal < NEAR_SINGULAR
    y = np.concatenate((state.q, state.u, np.zeros(2)))
    assert 0.5 * literal < route_of(model).held_rates(0.99, y)[1] < 2.0 * literal


def test_a_crank_that_pulls_its_rocker_beyond_its_reach_is_told_in_compiled_runs() -> None:
    scene = four_bar(rocker=0.9, motion=kf.Motion.steady(2.0, 0.6))
    with pytest.warns(kf.SimulationWarning, match=r"at a singular position.*within its reach"):
        scene.simulate((0.0, 3.0), rtol=1e-6)
