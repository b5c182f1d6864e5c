"""Forces of all states of a run from one compiled call are those that the literal route finds state by state."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
import kanefe.order_n.run_forces as compiled
from kanefe.equations.model import Model
from kanefe.frames import Matrix, Vector
from kanefe.literal.run_forces import LiteralForces
from kanefe.order_n.force_kernel import ForceKernel
from kanefe.tree.neighbours import BODY, FORCE, LOAD, LOOP, parts_of
from kanefe.tree.run_sweeps import RunForces
from kanefe_fem.beams.body import straight_beam
from kanefe_fem.beams.sections import Rectangle
from loop_scenes import bent_four_bars, four_bar, four_bars, nested_loops, spatial_loop
from random_loops import LoopScene, closed_state
from random_scenes import Recipe, planar_model, random_model
from result_scenes import SOFT
from scenes import random_state

TIMES = np.array((0.0, 0.1, 0.35))
SPEEDING_UP = kf.Motion(lambda t: 0.3 + t + t * t, lambda t: 1.0 + 2.0 * t, lambda _: 2.0)


def wandering(model: Model) -> tuple[Vector, Matrix]:
    """Return states that have nothing to do with each other; with loops those that are closed."""
    if not model.constraints:
        states = [(*random_state(model, seed), model.initial_states) for seed in range(len(TIMES))]
        return TIMES, np.array([np.concatenate(state) for state in states])
    closed = [state for state in (closed_state(model, seed) for seed in range(4)) if state is not None]
    return np.zeros(len(closed)), np.array([np.concatenate((*state, model.initial_states)) for state in closed])


def literally(model: Model, times: Vector, states: Matrix) -> LiteralForces:
    n, m = model.coordinate_count, model.free_count
    pairs = list(zip(times.tolist(), states, strict=True))
    return LiteralForces(
        model, lambda: [model.route.acting(t, y, model.route.evaluate(t, y).rates[n : n + m]) for t, y in pairs]
    )


def all_of(model: Model, forces: RunForces) -> dict[str, np.ndarray]:
    """Return all that is told, by what it is."""
    found = {"reactions": forces.reactions, "driving": forces.driving, "loops": forces.loops, "gears": forces.gears}
    for i, part in enumerate(parts_of(model)):
        kinds = {source.kind for source in part.sources}
        found[f"part {i} of {kinds}"] = forces.part(i)
    ends = [(i, end) for i, load in enumerate(model.loads) for end in range(len(load.ends))]
    return found | {f"end {end} of load {i}": forces.on_end(i, end) for i, end in ends}


def assert_alike(model: Model, times: Vector, states: Matrix) -> dict[str, np.ndarray]:
    sweeps = model.route.sweeps(times, states)
    assert sweeps is not None
    assert sweeps.forces is not None
    found, wanted = all_of(model, sweeps.forces), all_of(model, literally(model, times, states))
    # round-off of what cancels: the inertia and the loads of a body, and what several forces at an interface share
    size = max(1.0, *(abs(array).max(initial=0.0) for array in wanted.values()))
    for name, array in wanted.items():
        np.testing.assert_allclose(found[name], array, rtol=0, atol=1e-10 * size, err_msg=name)
    return wanted


def stiffened() -> Model:
    """A hub with a stiffened arm whose root and tip together hold it in G; the tip carries a tool."""
    beam = straight_beam(1.0, Rectangle(0.02, 0.04), SOFT, elements=4)
    root = kf.Interface(fixed=("x", "y", "z", "rx"), axes=kf.rotation_about((1, 2, 3), 0.7))
    interfaces = {"root": root, "tip": kf.Interface(fixed=("y", "z"))}
    body = kf.flexible_body(beam, interfaces, reduction=kf.CraigBampton(modes=3), stiffening="full")
    scene = kf.System(gravity=(1.0, 2.0, -9.81))
    hub = scene.add_rigid_body("hub", 1.0, np.diag((1.0, 2.0, 2.5)), com=(0.1, 0, 0.2), joint=kf.Spherical())
    arm = scene.add_flexible_body("arm", body, parent=hub, at=(0.1, 0, 0), joint=kf.Revolute("z"))
    scene.add_rigid_body("tool", 0.5, 0.1, com=(0, 0.1, 0), parent=arm.interface("tip"), joint=kf.Universal())
    scene.add_force(arm.interface("tip"), (1.0, 2.0, 3.0), point=(0.0, 0.1, 0.2))
    return scene.freeze()


def geared() -> Model:
    """A chain of three whose joints a gear couples, another that is open, and a rack, with a rope that pulls."""
    scene = kf.System(gravity=(1.0, 2.0, -9.81))
    links = [scene.add_rigid_body("0", 1.0, 0.1, com=(0.3, 0, 0), joint=kf.Revolute("z"))]
    links += [scene.add_rigid_body("1", 1.0, 0.1, com=(0.3, 0, 0), parent=links[0], joint=kf.Revolute("y"))]
    links += [scene.add_rigid_body("2", 1.0, 0.1, com=(0.3, 0, 0), parent=links[1], joint=kf.Prismatic("x"))]
    scene.add_gear("open", {links[0]: 2.0}, starts_on=False)
    scene.add_gear("pair", {links[0]: 2.0, links[1]: -3.0})
    scene.add_rack("teeth", links[1], links[2], 0.4)
    scene.add_spring("pull", links[2], scene.ground.frame(at=(1, 2, 3)), stiffness=30.0)
    return scene.freeze()


TREES: dict[str, Callable[[], Model]] = {
    "rigid": lambda: random_model(Recipe(2, bodies=8, loads=5, between=4)),
    "flexible": lambda: random_model(Recipe(0, bodies=7, elastic=0.5, loads=4, between=4)),
    "more flexible": lambda: random_model(Recipe(5, bodies=7, elastic=0.5, loads=4, between=4, slopes="tait-bryan")),
    "planar": lambda: planar_model(Recipe(6, bodies=8, loads=3)),
    "loop": lambda: LoopScene(Recipe(3, bodies=6, elastic=0.5, loads=3, between=2), 2).scene.freeze(),
    "rigid loop": lambda: LoopScene(Recipe(3, bodies=6, loads=3, between=2), 2).scene.freeze(),
    "four-bar": lambda: four_bar().freeze(),
    "four-bars apart": lambda: four_bars(4, "apart", base="free", closed_by="rods").freeze(),
    "four-bars in a row": lambda: four_bars(4, "in a row", closed_by="rods", motion=SPEEDING_UP).freeze(),
    "four-bars upon each other": lambda: four_bars(
        4, "one on the other", closed_by="rods", motion=SPEEDING_UP
    ).freeze(),
    "geared": geared,
    "flexible four-bars": lambda: bent_four_bars(3).freeze(),
}


@pytest.mark.parametrize("name", TREES)
def test_forces_are_those_of_the_literal_route(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    model = TREES[name]()
    times, states = wandering(model)
    assert len(states)

    def asked(_: object) -> LiteralForces:
        raise AssertionError("the literal route was asked")

    monkeypatch.setattr(compiled.CompiledForces, "_of_rest", property(asked))  # one call tells all states
    wanted = assert_alike(model, times, states)
    assert wanted["reactions"].any()
    kinds = {source.kind for part in parts_of(model) for source in part.sources}
    assert name not in ("flexible", "more flexible") or {BODY, LOAD, FORCE} <= kinds
    assert name not in ("loop", "flexible four-bars") or LOOP in kinds
    assert not name.startswith("four-bars") or wanted["loops"].any()
    assert name != "geared" or wanted["gears"].any(axis=0).tolist() == [False, True, True, True, True]
    assert not model.driven_count or wanted["driving"].any()


def test_a_bent_root_that_lets_turn_holds_where_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    model = stiffened()
    times, states = wandering(model)
    states[:, model.flexible_terms("arm").eta] *= 0.05  # bent no beyond the valid range of its stiffening
    monkeypatch.setattr("kanefe.literal.run_forces.LiteralForces", None)
    wanted = assert_alike(model, times, states)
    assert all(array.any() for name, array in wanted.items() if name.startswith("part"))


def test_what_several_multipliers_do_the_literal_route_tells() -> None:
    """Rows that say again what others say: of their forces the least are told, whoever finds them."""
    model = LoopScene(Recipe(1, bodies=6, elastic=0.5, loads=3, between=2), 2).scene.freeze()
    times, states = wandering(model)
    assert assert_alike(model, times, states)["loops"].any()


@pytest.mark.parametrize(
    "make",
    [
        lambda: four_bars(4, "in a row", base="free", motion=SPEEDING_UP),
        lambda: four_bars(4, "one on the other", motion=SPEEDING_UP),
        nested_loops,
    ],
    ids=["in a row", "upon each other", "nested"],
)
def test_spatial_pins_that_hold_a_plane_several_times_are_told(make: Callable[[], kf.System]) -> None:
    model = make().freeze()
    wanted = assert_alike(model, *wandering(model))
    assert wanted["loops"].any()
    assert not model.driven_count or wanted["driving"].any()


def test_interfaces_that_share_forces_in_several_ways_are_told() -> None:
    beam = straight_beam(1.0, Rectangle(0.02, 0.04), SOFT, elements=4)
    body = kf.flexible_body(beam, {"root": "clamped", "tip": "clamped"}, reduction=kf.CraigBampton(modes=3))
    scene = kf.System(gravity=(1.0, 2.0, -9.81))
    hub = scene.add_rigid_body("hub", 1.0, 0.1, joint=kf.Revolute("y"))
    scene.add_flexible_body("arm", body, parent=hub, at=(0.1, 0, 0))
    model = scene.freeze()
    wanted = assert_alike(model, *wandering(model))
    assert all(array.any() for name, array in wanted.items() if name.startswith("part"))


def test_all_channels_of_a_run_come_from_one_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    result = four_bar().simulate((0.0, 0.1), output_step=0.01)
    passes = []
    prepared = ForceKernel.prepared
    monkeypatch.setattr(ForceKernel, "prepared", lambda self, *given: passes.append(given) or prepared(self, *given))
    for body in result.bodies:
        result.joint_reaction(body)
    for loop in result.loops:
        assert result.loop_force(loop).any()
    assert len(passes) == 1


def test_a_state_tells_what_a_run_tells() -> None:
    model = spatial_loop(2).freeze()
    times, states = wandering(model)
    told = model.route.sweeps(times, states).forces  # type: ignore[union-attr]
    assert told is not None
    found = model.joint_reactions(float(times[0]), states[0])
    for wrench, wanted in zip(found.values(), told.reactions[0], strict=True):
        np.testing.assert_array_equal(wrench, wanted)
