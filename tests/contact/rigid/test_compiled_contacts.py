"""Rigid contacts in order n against the literal route, which is independent of it."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from contact_conditions import assert_contacts_hold
from draws import in_parts
from kanefe.contact.contact import OPEN, SLIPS
from kanefe.equations.model import Model
from kanefe.integrate.events import event_search
from kanefe.kane.assemble import accelerations, held_accelerations, held_solver
from kanefe.kernels.compiler.arrays import NOT_CALLED
from kanefe.kernels.constraints.constraint_rows import RowKind
from kanefe.kernels.constraints.contact_margins import LeastMargins
from kanefe.kernels.constraints.loop_tables import rows_of
from kanefe.kernels.contact.rigid_points import given_points
from kanefe.kernels.events.watched_run import Does
from kanefe.kernels.impacts.contact_questions import Asks
from kanefe.kernels.loads.telling import States
from kanefe.literal.contact_forces import check_determined
from kanefe.literal.route import LiteralRoute, powers, state_rates
from kanefe.order_n.contact_changing import decider_of
from kanefe.order_n.contact_watching import ContactLook, watching_contacts
from kanefe.order_n.route import OrderN
from kanefe.states.constraints import held_rows
from rigid_scenes import rigid_scene, rigid_state, stack

T = 0.2


def literal_rates(model: Model, y: np.ndarray) -> tuple[np.ndarray, float] | None:
    """Return dy/dt and powers, and how far rows are from dependent: its square, 0.0 where several forces do the same.

    None where the forces are not determined.
    """
    state = model.literal.view(T, y)
    try:
        check_determined(state)
    except kf.SimulationError:
        return None
    weakest = 1.0
    if held_rows(state):
        solver = held_solver(state)
        values = np.linalg.svd(solver.scaled_rows)[1]
        weakest = float(values[-1] / values[0]) ** 2 if solver.rank == solver.row_count else 0.0
    du = accelerations(state)
    rates = model.coordinate_rates(state.q, state.u), du, state_rates(state), powers(state, du)
    return np.concatenate(rates), weakest


def own_multipliers(model: Model, y: np.ndarray) -> np.ndarray:
    """Return the multipliers of all rows that hold, in the order of the literal route, by compiled code."""
    look, route = ContactLook(model.route), model.route
    states = np.zeros((1, look.vectors.shape[1]))
    states[0, : len(y)] = y
    given = np.full(1, T), route.drives(T)[None], route.values(T, y)[None], states
    found = np.empty((1, LeastMargins.number_count))
    watching_contacts(route).prepared(look.looked, NOT_CALLED, States(*given), found)()
    contact = np.array([row.kind == RowKind.CONTACT for row in rows_of(route.loops)])
    found, points = look.workspace.multipliers, look.workspace.multipliers[contact].reshape(-1, 3)
    status = y[model.coordinate_count + model.free_count :][[one.status for one in given_points(route.loops.points)]]
    held = [forces[: 3 if kind == 1.0 else 1] for forces, kind in zip(points, status, strict=True) if kind > 0.0]
    return np.concatenate((found[~contact], *held))


def assert_reactions_agree(model: Model, y: np.ndarray, weakest: float) -> None:
    """Compare what constraints and contacts exert, where that is determined.

    Speeds of random states do not meet rows that depend on each other: each route then misses them in its own measure.
    """
    state = model.literal.view(T, y)
    if held_rows(state) and weakest > 0.0:
        own, wanted = own_multipliers(model, y), held_accelerations(state)[1]
        np.testing.assert_allclose(own, wanted, rtol=0.0, atol=1e-12 / weakest * np.abs(wanted).max())


@pytest.mark.parametrize("part", in_parts(20, short=6))
def test_random_scenes_are_those_of_the_literal_route(part):
    """Accelerations, and forces of contacts and constraints, of 200 scenes."""
    for seed in range(10 * part, 10 * part + 10):
        model = rigid_scene(seed)
        assert isinstance(model.route, OrderN)
        y = rigid_state(model, 10 * seed)
        found = literal_rates(model, y)
        if found is None:
            continue
        rates, weakest = found
        if weakest > 0.0:
            own, _ = model.route.held_rates(T, np.append(y, (0.0, 0.0)))
            # round-off of the two ways through some hundred operations, over what rows lack to depend on each other
            np.testing.assert_allclose(own, rates, rtol=0.0, atol=1e-12 / weakest * np.abs(rates).max())
        assert_reactions_agree(model, y, weakest)


def test_many_random_states_are_compared():
    """The test above says nothing where forces are not determined, and little where nothing touches."""
    states = [(rigid_scene(seed), 10 * seed) for seed in range(20)]
    found = [literal_rates(model, rigid_state(model, seed)) for model, seed in states]
    touching = [bool(held_rows(model.literal.view(T, rigid_state(model, seed)))) for model, seed in states]
    assert sum(one is not None and touches for one, touches in zip(found, touching, strict=True)) >= 7


def assert_changes_agree(model: Model, y: np.ndarray, what: int) -> bool:
    """Compare what follows an event, with responses by sweeps and by dense matrices; return whether something does."""
    run = 0.2, 0.4, 1e-6
    own, literal = decider_of(model.route), model.literal.asked_contacts(what, T, y, *run)
    is_known = own.ask(what, T, y, *run)
    try:
        wanted = literal.changed()
    except kf.SimulationError as error:
        refusal = str(error)
    else:
        refusal = ""
    if refusal and is_known:
        with pytest.raises(kf.SimulationError) as found:
            own.changed()
        assert str(found.value) == refusal
    if refusal:
        return False
    if not is_known:  # forces of the state before are not determined, of which the literal route asks for less
        with pytest.raises(kf.SimulationError, match="Painleve"):
            model.route.held_rates(T, np.append(y, (0.0, 0.0)))
        return False
    changed = own.changed()
    (_, u, z), (_, wanted_u, wanted_z) = model.parts(changed.y), model.parts(wanted.y)
    # the cone problem is solved to 1e-12 of its forces, and round-off of G is divided by its least eigenvalue
    np.testing.assert_allclose(u, wanted_u, rtol=0.0, atol=1e-8 * np.abs(wanted_u).max())
    np.testing.assert_allclose(z, wanted_z, rtol=0.0, atol=1e-6 * np.abs(wanted_z).max())
    assert [code for _, code in changed.reports] == [code for _, code in wanted.reports]
    np.testing.assert_allclose([t for t, _ in changed.reports], [t for t, _ in wanted.reports], rtol=1e-6)
    assert changed.told.warnings == wanted.told.warnings
    return not np.array_equal(u, model.parts(y)[1])


@pytest.mark.parametrize("part", in_parts(4, short=1))
def test_what_random_impacts_leave_can_be(part):
    """Nothing goes on into a surface, pulls, or holds more than it can: said of states, whatever decided them."""
    for seed in range(20 * part, 20 * part + 20):
        model = rigid_scene(seed)
        try:
            y = model.route.asked_contacts(Asks.START, T, rigid_state(model, 10 * seed + 5), 0.2, 0.4, 1e-6).changed().y
        except kf.SimulationError:
            continue
        # decisions do not see 1e-7 of the largest force
        assert_contacts_hold(model, T, y, 1e-6)


@pytest.mark.parametrize("part", in_parts(10, short=3))
def test_random_impacts_are_those_of_the_literal_route(part):
    """Speeds, statuses, kept directions and reports of 200 scenes, each struck and asked for one more kind of event."""
    struck = 0
    for seed in range(20 * part, 20 * part + 20):
        model = rigid_scene(seed)
        y = rigid_state(model, 10 * seed + 5)
        struck += assert_changes_agree(model, y, Asks.START)
        assert_changes_agree(model, y, (Asks.TOUCH, Asks.LIFT, Asks.SLIP, Asks.STICK)[seed % 4])
    assert struck >= 4


def test_what_is_alike_changes_as_one() -> None:
    """Boxes at several places, whose forces differ by round-off: none is left for an event of its own."""
    scene = kf.System(gravity=(3.0, 0.2, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    corners = kf.shapes.Points([(0.1, 0.03, -0.1), (-0.1, 0.02, -0.1), (0.01, 0.1, -0.1)])
    for i in range(3):
        box = scene.add_rigid_body(f"box {i}", 1.0, 0.01, joint=kf.Free(position=(0.3 * i + 0.01, 0.7 * i, 0.1)))
        skin = scene.add_surface(f"corners {i}", box, corners)
        scene.add_contact(f"c{i}", skin, floor, normal=kf.Rigid(), friction=kf.Coulomb(0.5))
    model = scene.freeze()
    decider, options = decider_of(model.route), (0.2, 0.4, 1e-6)
    assert decider.ask(Asks.START, T, model.initial_state, *options)
    assert decider.ask(Asks.LIFT, T, decider.y.copy(), *options)
    z = model.parts(decider.y)[2]
    changed = [model.rigid_contact(i).status(z[model.load_states[at]]) for i, at in enumerate(model.rigid_contacts)]
    assert changed == 3 * [[SLIPS, OPEN, SLIPS]]  # each tips over two corners


def test_a_stack_that_falls_comes_to_rest_without_chatter():
    count, drop = 5, 0.01
    result = stack(count, drop).simulate((0.0, 1.0))
    for i in range(count):
        assert [len(result.events[f"c{i} {what}"]) for what in ("touch", "lift", "slip")] == [1, 0, 0]
        # gaps of round-off, which a drift of the events would leave
        place = (0.003 * (-1) ** i, 0, 0.1 + 0.2 * i)
        np.testing.assert_allclose(result.position(f"box {i}")[-1], place, rtol=0.0, atol=1e-12)
    # all fall as one, and the first impact stops all
    np.testing.assert_allclose(result.events["c0 touch"], np.sqrt(2.0 * drop / 9.81), rtol=1e-9)
    assert abs(result.energy.balance_error).max() < 1e-8


def ball() -> kf.System:
    """Return a ball that bounces, slips and rolls, and stops bouncing."""
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    joint = kf.Free(position=(0, 0, 0.2), velocity=(0.5, 0.1, 0))
    skin = scene.add_surface("skin", scene.add_rigid_body("ball", 1.0, 4e-3, joint=joint), kf.shapes.Sphere(0.1))
    scene.add_contact("c", skin, floor, normal=kf.Rigid(0.5), friction=kf.Coulomb(0.1))
    return scene


def tumbling() -> kf.System:
    """Return a box that falls on a corner, and has each of them tell what it does."""
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    joint = kf.Free(position=(0, 0, 0.25), orientation=kf.rotation_about((1.0, 0.6, 0.2), 0.5))
    corners = [(x, y, z) for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)]
    skin = scene.add_surface("skin", scene.add_rigid_body("box", 1.0, 0.01, joint=joint), kf.shapes.Points(corners))
    scene.add_contact("c", skin, floor, normal=kf.Rigid(0.3, impact="poisson"), friction=kf.Coulomb(0.4))
    return scene


def linkage() -> kf.System:
    """Return a coupler whose crank runs on a rigid stop; a loop holds."""
    scene = kf.System(gravity=(0, 0, -9.81))
    bars = [
        scene.add_rigid_body(f"crank {i}", 1.0, 0.1, com=(0, 0, 0.5), at=(i, 0, 0), joint=kf.Revolute("y", speed=1.0))
        for i in range(2)
    ]
    bar = scene.add_rigid_body("bar", 1.0, 0.1, com=(0.5, 0, 0), parent=bars[0], at=(0, 0, 1), joint=kf.Revolute("y"))
    scene.add_loop_joint("pin", kf.Revolute("y"), bar.frame(at=(1, 0, 0)), bars[1].frame(at=(0, 0, 1)))
    knob = scene.add_surface("knob", bar, kf.shapes.Sphere(0.05), at=(0.5, 0, 0))
    floor = scene.add_surface("floor", scene.ground.frame(at=(0, 0, 0.4)), kf.shapes.Plane("z"))
    scene.add_contact("c", knob, floor, normal=kf.Rigid(0.4), friction=kf.Coulomb(0.2))
    return scene


RUNS = {"ball": (ball, 2.0), "box": (tumbling, 0.6), "linkage": (linkage, 1.5)}


@pytest.mark.parametrize("method", ["dop853", "radau5"])
@pytest.mark.parametrize("name", RUNS)
def test_runs_over_impacts_are_those_with_events_in_python(name, method, monkeypatch):
    """Python looks at no step of the one, and at each in which something happens of the other."""
    scene, stop = RUNS[name]
    asked: list[float] = []
    scan, kind = event_search.EventWatch.scan, event_search.kind_for_kernels
    monkeypatch.setattr(
        event_search.EventWatch, "scan", lambda self, stepper, clock: asked.append(0.0) or scan(self, stepper, clock)
    )
    options = {"method": method, "rtol": 1e-8, "output_step": 0.05, "events": ["c touch of point 1"] * (name == "box")}
    compiled = scene().simulate((0.0, stop), **options)
    assert not asked
    monkeypatch.setattr(
        event_search, "kind_for_kernels", lambda event: Does.BOUND if kind(event) == Does.BOUND_CHANGES else kind(event)
    )
    in_python = scene().simulate((0.0, stop), **options)
    assert len(asked) > 3
    assert compiled.events.keys() == in_python.events.keys()
    for event, times in in_python.events.items():
        # what separates is as deep as its root was missed by, and impacts that follow add that up
        np.testing.assert_allclose(compiled.events[event], times, rtol=0, atol=1e-8, err_msg=event)
    states = compiled.run.trajectory.coordinates, in_python.run.trajectory.coordinates
    np.testing.assert_allclose(*states, rtol=0, atol=1e-8)
    np.testing.assert_allclose(compiled.energy.dissipated, in_python.energy.dissipated, rtol=0, atol=1e-8)
    assert abs(compiled.energy.balance_error).max() < 1e-5


def test_a_stack_at_rest_asks_python_for_nothing(monkeypatch):
    """What touches at its start is decided in compiled code, and no step of it needs Python."""

    def refuse(*_):
        raise AssertionError("asked Python")

    monkeypatch.setattr(LiteralRoute, "asked_contacts", refuse)
    monkeypatch.setattr(event_search.EventWatch, "scan", refuse)
    result = stack(3, 0.0).simulate((0.0, 2.0))
    assert not any(len(times) for times in result.events.values())


@pytest.mark.parametrize("friction", [None, kf.Coulomb(0.5)])
def test_a_table_that_leans_on_three_legs_has_forces_that_can_be(friction):
    """Least norm would let one leg pull: forces are a plane over the legs, and the load lies beyond its middle."""
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    table = scene.add_rigid_body("table", 1.0, 0.1, com=(0.28, 0.28, 0), joint=kf.Free(position=(0, 0, 0.7)))
    feet = scene.add_surface("feet", table, kf.shapes.Points([(x, y, -0.7) for x in (-0.4, 0.4) for y in (-0.4, 0.4)]))
    scene.add_contact("c", feet, floor, normal=kf.Rigid(), friction=friction)
    model = scene.freeze()
    y = model.route.start(0.0)
    if friction is not None:
        contact, z = model.rigid_contact(0), y[-len(model.rigid_contact(0).initial_states) :]
        assert contact.status(z).count(1) == 4
    forces = model.route.asked_contacts(Asks.MARGINS, 0.0, y).margins[:, 1]
    assert min(forces) > 0.0
    # force and moments are in balance
    np.testing.assert_allclose(sum(forces), 9.81, rtol=1e-9)
    arms = np.array([(x, y) for x in (-0.4, 0.4) for y in (-0.4, 0.4)])
    np.testing.assert_allclose(forces @ arms, (0.28 * 9.81, 0.28 * 9.81), rtol=1e-9)
    result = scene.simulate((0.0, 1.0))
    assert not any(len(times) for times in result.events.values())


def test_painleves_paradox_is_named_in_an_evaluation():
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    angle = np.radians(60.0)
    start = kf.Free(position=(0.5 * np.cos(angle), 0, 0.5 * np.sin(angle)), orientation=kf.rotation_about("y", -angle))
    rod = scene.add_rigid_body("rod", 1.0, (1e-3, 1.0 / 12.0, 1.0 / 12.0), joint=start)
    scene.add_contact("c", rod.frame(at=(-0.5, 0, 0)), floor, normal=kf.Rigid(), friction=kf.Coulomb(3.0))
    model = scene.freeze()
    y = model.initial_state.copy()
    q, u, z = (part.copy() for part in model.parts(y))
    u[0] = -5.0
    model.rigid_contact(0).with_status(z, 0, 2, np.array((-1.0, 0.0, 0.0)))
    y = np.concatenate((q, u, z))
    with pytest.raises(kf.SimulationError, match=r"Painleve.*HuntCrossley"):
        model.rhs(0.0, y)


def pushed(force: object) -> Model:
    """Return a box that strikes a floor on one corner while it is pushed."""
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    start = kf.Free(position=(0, 0, 0.1), velocity=(0.3, 0, -1.0), angular_velocity=(0.2, 0.1, 0))
    box = scene.add_rigid_body("box", 1.0, 0.01, joint=start)
    corners = scene.add_surface("corners", box, kf.shapes.Points([(0.1, 0.1, -0.1), (-0.1, 0.1, -0.1)]))
    scene.add_contact("c", corners, floor, normal=kf.Rigid(0.3), friction=kf.Coulomb(0.4))
    scene.add_force(box, force)
    return scene.freeze()


def test_events_with_functions_in_python_are_those_without():
    """Compiled code asks Python about the scene, which has the values of loads and asks compiled code."""
    of_numbers, of_functions = pushed((3.0, 0.0, -20.0)), pushed(lambda t: (3.0, 0.0, -20.0))
    assert of_numbers.route.is_autonomous
    assert not of_functions.route.is_autonomous
    own, asked = (
        one.route.asked_contacts(Asks.START, T, one.initial_state, 0.2, 0.4, 1e-6).changed().y
        for one in (of_numbers, of_functions)
    )
    np.testing.assert_array_equal(own, asked)


def test_errors_of_functions_pass_through_compiled_code():
    calls: list[float] = []

    def force(t: float) -> tuple[float, float, float]:
        if calls:
            raise ZeroDivisionError("asked")
        return 0.0, 0.0, 1.0

    model = pushed(force)
    y = model.initial_state
    calls.append(0.0)
    for route in (model.route, model.literal):
        with pytest.raises(Exception, match="asked"):
            route.asked_contacts(Asks.START, T, y, 0.2, 0.4, 1e-6)
