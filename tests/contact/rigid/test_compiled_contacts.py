"""Rigid contacts in order n against the literal route, which is independent of it."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.kane.assemble import accelerations, held_solver
from kanefe.kane.constraints import held_rows
from kanefe.kane.rigid_contacts.contact_forces import check_determined
from kanefe.kane.rigid_contacts.impacts import START, resolved
from kanefe.kane.route import powers, state_rates
from kanefe.order_n.route import OrderN
from rigid_scenes import rigid_scene, rigid_state, stack

T = 0.2


def literal_rates(model: Model, y: np.ndarray) -> tuple[np.ndarray, float] | None:
    """Return dy/dt and powers, and how far rows are from dependent; None where the forces are not determined."""
    state = model.literal.view(T, y)
    try:
        check_determined(state)
    except kf.SimulationError:
        return None
    weakest = 1.0
    if held_rows(state):
        solver = held_solver(state)
        if solver.rank < solver.row_count:
            return None
        values = np.linalg.svd(solver.scaled_rows)[1]
        weakest = float(values[-1] / values[0]) ** 2
    du = accelerations(state)
    rates = model.coordinate_rates(state.q, state.u), du, state_rates(state), powers(state, du)
    return np.concatenate(rates), weakest


@pytest.mark.parametrize("seed", range(40))
def test_random_scenes_accelerate_as_by_the_literal_route(seed):
    model = rigid_scene(seed)
    assert isinstance(model.route, OrderN)
    for number in range(3):
        y = rigid_state(model, 10 * seed + number)
        found = literal_rates(model, y)
        if found is None:
            continue
        rates, weakest = found
        own, _ = model.route.held_rates(T, np.append(y, (0.0, 0.0)))
        # round-off of the two ways through some hundred operations, over what rows lack to depend on each other
        np.testing.assert_allclose(own, rates, rtol=0.0, atol=1e-12 / weakest * np.abs(rates).max())


def test_many_random_states_are_compared():
    """The test above says nothing where forces are not determined, and little where nothing touches."""
    states = [(rigid_scene(seed), 10 * seed) for seed in range(20)]
    found = [literal_rates(model, rigid_state(model, seed)) for model, seed in states]
    touching = [bool(held_rows(model.literal.view(T, rigid_state(model, seed)))) for model, seed in states]
    assert sum(one is not None and touches for one, touches in zip(found, touching, strict=True)) >= 7


def assert_impacts_agree(model: Model, y: np.ndarray) -> bool:
    """Compare what follows an event at which what has a status touches; return whether that is determined."""
    z = model.parts(y)[2]
    keys = [
        (number, i)
        for number, load in enumerate(model.rigid_contacts)
        for i, status in enumerate(model.rigid_contact(number).status(z[model.load_states[load]]))
        if status
    ]
    if not keys:
        return False
    G, b = model.literal.contact_instant(T, y).problem(keys)
    own, own_b = model.route.contact_instant(T, y).problem(keys)
    # round-off of the two ways through some hundred operations
    np.testing.assert_allclose(own, G, rtol=0.0, atol=1e-11 * np.abs(G).max())
    np.testing.assert_allclose(own_b, b, rtol=0.0, atol=1e-11 * np.abs(b).max())
    values = np.linalg.eigvalsh(G)
    if values[0] < 1e-3 * values[-1]:
        return False  # several contacts share impulses
    found = []
    for at in (model.literal.contact_instant, model.route.contact_instant):
        try:
            found.append(resolved(model, T, y, START, 1.0, 2.0, 1e-6, at))
        except kf.SimulationError as error:
            found.append(str(error))
    literal, compiled = found
    if isinstance(literal, str) or isinstance(compiled, str):
        assert literal == compiled
        return False
    # the cone problem is solved to 1e-12 of its forces, and round-off of G is divided by its least eigenvalue
    np.testing.assert_allclose(compiled.u, literal.u, rtol=0.0, atol=1e-8 * np.abs(literal.u).max())
    np.testing.assert_allclose(compiled.z, literal.z, rtol=0.0, atol=1e-6 * np.abs(literal.z).max())
    assert [name for name, _ in compiled.happened] == [name for name, _ in literal.happened]
    return True


@pytest.mark.parametrize("part", range(3))
def test_random_impacts_are_those_of_the_literal_route(part):
    """Speeds, statuses and kept directions."""
    seeds = range(67 * part, 67 * part + 67)
    assert (
        sum(assert_impacts_agree(model := rigid_scene(seed), rigid_state(model, 10 * seed + 5)) for seed in seeds) >= 10
    )


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


def test_a_stack_at_rest_asks_python_at_its_start_alone(monkeypatch):
    """What happens is decided twice as a run begins, and looked at once; no step of it needs Python."""
    asked: list[float] = []
    plain = OrderN.contact_instant

    def counted(self, t, y):
        asked.append(t)
        return plain(self, t, y)

    monkeypatch.setattr(OrderN, "contact_instant", counted)
    result = stack(3, 0.0).simulate((0.0, 2.0))
    assert set(asked) == {0.0}
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
        contact, z = model.rigid_contact(0), y[-30:]
        assert contact.status(z).count(1) == 4
    margins = model.route.contact_instant(0.0, y).margins()
    forces = list(margins.normals.values())
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
