"""Coupling forces: the whole of what acts at an interface, in closed form by class of load, and bodies in balance."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from balances import imbalances
from kanefe.frames import rotation_matrix
from kanefe.instants.instant import Instant
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.reduction import build
from kanefe.results.channels import RunChannels
from kanefe.states.state import State
from random_loops import LoopScene, closed_state
from random_scenes import Recipe
from scenes import lattice_body, random_state

BALANCED = 1e-9
"""Of the largest force: accelerations of stiff bodies have condition numbers up to some 1e6, times 1e-16."""

ON_TIP = np.array((0.0, 0.0, -98.1, 0.0, 0.0, 0.0))


def cantilever(**options: Any) -> tuple[kf.System, Any, np.ndarray]:
    """Return a scene with a lattice held at its root, and the place of its tip in N."""
    scene = kf.System(**options)
    arm = scene.add_flexible_body("arm", lattice_body(0, reduction=kf.CraigBampton(modes=2)))
    return scene, arm, np.array(arm.body.interface("tip").position)


def at_start(scene: kf.System) -> Instant:
    """Return the scene as it starts, undeformed and at rest."""
    model = scene.freeze()
    return Instant(model, 0.0, model.initial_state[: model.coordinate_count + model.free_count + model.state_count])


class Pull(kf.Load):
    def __init__(self, name: str, on: Any, wrench: np.ndarray) -> None:
        self.name, self.ends, self.wrench = name, (on,), wrench

    def action(self, t, ends, states):
        return kf.Action(np.array(self.wrench)[None])


def spring(scene, arm, p):
    below = scene.ground.frame(at=p - (0, 0, 1))
    scene.add_spring("it", arm.interface("tip"), below, stiffness=981.0, rest_length=0.9)


def bushing(scene, arm, p):
    below = scene.ground.frame(at=p - (0, 0, 0.1))
    scene.add_bushing("it", below, arm.interface("tip"), stiffness=(5.0, 5.0, 981.0))


def rope(scene, arm, p):
    below = scene.ground.frame(at=p - (0, 0, 1))
    scene.add(kf.Rope("it", (below, arm.interface("tip")), axial_stiffness=1e5, preload=98.1))


def winch(scene, arm, p):
    below = scene.ground.frame(at=p - (0, 0, 1))
    scene.add(kf.Winch("it", (below, arm.interface("tip")), tension=98.1, stiffness=1e5, damping=10.0, speed=1.0))


def oleo(scene, arm, p):
    above = scene.ground.frame(at=p + np.array((0, 0, 1)))  # gas of 981 kPa above the ambient pressure on 1e-4 m2
    gas = {"area": 1e-4, "pressure": 981e3, "volume": 1e-4, "ambient": 0.0}
    scene.add(kf.Oleo("it", (above, arm.interface("tip")), **gas))


def hub_load(scene, arm, p):
    scene.add(kf.PeriodicLoad("it", arm.interface("tip"), 30.0, ON_TIP))


def own_load(scene, arm, p):
    scene.add(Pull("it", arm.interface("tip"), ON_TIP))


def force(scene, arm, p):
    scene.add_force(arm.interface("tip"), ON_TIP[:3])


def soft_contact(scene, arm, p):
    roof = scene.add_surface("roof", scene.ground, kf.shapes.Plane("-z"), at=p - (0, 0, 0.01))
    scene.add_contact("it", arm.interface("tip"), roof, normal=kf.KelvinVoigt(9810.0))


CLOSED: dict[str, Callable[..., None]] = {
    f.__name__: f for f in (spring, bushing, rope, winch, oleo, hub_load, own_load, force, soft_contact)
}


@pytest.mark.parametrize("load", CLOSED)
def test_a_known_load_of_98_newtons_down_is_told_at_the_tip(load: str) -> None:
    scene, arm, p = cantilever()
    CLOSED[load](scene, arm, p)
    at = at_start(scene)
    (name,) = at.neighbours("arm", "tip").known
    for of in (None, "F_k", name):
        # stiffness times lengths, to round-off of 1e5 N/m
        assert at.coupling_force("arm", "tip", of) == pytest.approx(ON_TIP, abs=1e-9)
    assert not at.coupling_force("arm", "tip", "F_u").any()
    assert name == ("it" if load != "force" else "the force on 'tip' of 'arm'")


def test_a_torque_and_an_offset_force_act_about_the_interface() -> None:
    scene, arm, _ = cantilever()
    scene.add_torque(arm.interface("tip"), (1.0, 2.0, 3.0))
    scene.add_force(arm.interface("tip"), (0.0, 0.0, -10.0), point=(0.5, 0.0, 0.0))
    at = at_start(scene)
    assert at.coupling_force("arm", "tip") == pytest.approx([0, 0, -10, 1, 7, 3], abs=1e-12)
    assert at.coupling_force("arm", "tip", "the torque on 'tip' of 'arm'") == pytest.approx([0, 0, 0, 1, 2, 3])


WEIGHT = {"at": (0.5, 0.0, 0.0)}


def weld(scene, arm, p):
    scene.add_rigid_body("it", 10.0, 0.01, parent=arm.interface("tip"), **WEIGHT)


def driven(scene, arm, p):
    hinge = kf.Revolute("y", motion=kf.Motion.steady(0.0))
    scene.add_rigid_body("it", 10.0, 0.01, parent=arm.interface("tip"), com=(0.5, 0, 0), joint=hinge)


def loop(scene, arm, p):
    scene.add_rigid_body("weight", 10.0, 0.01, at=(p[0] + 0.5, *p[1:]), joint=kf.Free())
    scene.add_loop_joint("it", kf.Fixed, arm.interface("tip"), scene.body("weight").frame(at=(-0.5, 0, 0)))


@pytest.mark.parametrize("load", [weld, driven, loop])
def test_a_weight_beside_the_tip_at_rest_is_an_unknown_force_with_its_moment(load: Callable[..., None]) -> None:
    scene, arm, p = cantilever(gravity=(0, 0, -9.81))
    load(scene, arm, p)
    rest = kf.equilibrium(scene)
    beside = rest.rotation("arm")
    assert beside == pytest.approx([1, 0, 0, 0])
    arm_N = rest.position("arm", "tip") - rest.center_of_mass("it" if load is not loop else "weight")
    needed = np.concatenate((ON_TIP[:3], -np.cross(arm_N, ON_TIP[:3])))
    assert rest.neighbours("arm", "tip") == (("it",), ())
    for of in (None, "F_u", "it"):
        # a rest leaves 1e-9 of the forces on it
        assert rest.coupling_force("arm", "tip", of) == pytest.approx(needed, abs=1e-6)
    weight = 9.81 * rest.body("arm").mass
    assert rest.coupling_force("arm", "root")[2] == pytest.approx(98.1 + weight, abs=1e-6)


def test_a_motor_and_the_spring_of_a_joint_come_with_its_body() -> None:
    scene, arm, _ = cantilever()
    hinge = kf.Revolute("z", forces=kf.CoordinateForce(stiffness=4.0, rest=-0.5))
    wheel = scene.add_rigid_body("wheel", 2.0, 0.3, parent=arm.interface("tip"), joint=hinge)
    scene.add_motor(wheel, 5.0)
    at = at_start(scene)
    assert at.coupling_force("arm", "tip", "wheel")[5] == pytest.approx(-(5.0 - 2.0), abs=1e-12)


def test_a_gear_loads_the_interface_by_the_joint_that_it_drives() -> None:
    scene, arm, _ = cantilever()
    small = scene.add_rigid_body("small", 2.0, 0.3, parent=arm.interface("tip"), joint=kf.Revolute("z"))
    large = scene.add_rigid_body("large", 2.0, 0.6, joint=kf.Revolute("z"))
    scene.add_gear("gear", {small: 1.0, large: -1.0})
    scene.add_torque(large, (0.0, 0.0, 1.0))
    at = at_start(scene)
    turn = at.angular_acceleration("small")[2]
    # the gear gives the small wheel what turns it, and its axle hands that on
    assert at.coupling_force("arm", "tip")[5] == pytest.approx(-0.3 * turn, rel=1e-9)
    assert turn > 0.01


def test_a_rigid_contact_is_unknown_and_what_the_contact_tells() -> None:
    scene, arm, p = cantilever(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"), at=p)
    scene.add_force(arm.interface("tip"), (0, 0, -50.0))
    scene.add_contact("it", arm.interface("tip"), floor, normal=kf.Rigid(), friction=kf.Coulomb(0.5))
    result = scene.simulate((0.0, 1e-3), output_step=5e-4)
    told = result.contact("it").force
    assert told[-1, 2] > 1.0
    turn = rotation_matrix(result.rotation("arm")[-1])
    assert result.coupling_force("arm", "tip", "it")[-1, :3] == pytest.approx(turn.T @ told[-1], rel=1e-9)
    assert result.neighbours("arm", "tip") == (("it",), ("the force on 'tip' of 'arm'",))
    assert max(imbalances(result.at(result.times[-1])).values()) < BALANCED


def test_known_forces_on_a_clamped_interface_are_not_counted_twice() -> None:
    scene, arm, _ = cantilever()
    scene.add_force(arm.interface("root"), (0.0, 0.0, -30.0))
    scene.add_rigid_body("it", 1.0, 0.1, parent=arm.interface("root"), joint=kf.Prismatic("z"))
    scene.add_force(scene.body("it"), (2.0, 0.0, 0.0))
    at = at_start(scene)
    root = {of: at.coupling_force("arm", "root", of)[:3] for of in (None, "ground", "it", "F_u", "F_k")}
    assert root["F_k"] == pytest.approx([0, 0, -30])
    assert root["it"] == pytest.approx([2, 0, 0])
    assert root["ground"] == pytest.approx([-2, 0, 30], abs=1e-12)
    assert root["F_u"] == pytest.approx([0, 0, 30], abs=1e-12)
    assert root[None] == pytest.approx([0, 0, 0], abs=1e-12)


def test_forces_on_nodes_of_a_rigid_patch_act_at_its_interface() -> None:
    scene, arm, _ = cantilever()
    body = arm.body
    near = [i for i in range(len(body.nodes)) if np.linalg.norm(body.nodes[i] - body.interface("tip").position) < 0.3]
    scene.add_force(arm.node(near[0]), (0.0, 0.0, -7.0))
    scene.add_force(arm.node(len(body.nodes) // 2), (0.0, 0.0, -5.0))  # a node by itself
    at = at_start(scene)
    arm_m = body.nodes[near[0]] - body.interface("tip").position
    needed = np.concatenate(((0, 0, -7.0), np.cross(arm_m, (0, 0, -7.0))))
    assert at.coupling_force("arm", "tip") == pytest.approx(needed, abs=1e-12)
    assert max(imbalances(at).values()) < BALANCED


# -- names


def test_what_acts_is_named_and_others_are_refused_with_the_list() -> None:
    scene, arm, p = cantilever()
    spring(scene, arm, p)
    result = scene.simulate((0.0, 0.01))
    with pytest.raises(kf.ModelError, match=r"of='bolt'.*'tip' of 'arm'. Remedy: one of 'F_u', 'F_k', 'it'"):
        result.coupling_force("arm", "tip", of="bolt")
    with pytest.raises(kf.ModelError, match="one of 'F_u', 'F_k', 'ground'"):
        result.coupling_force("arm", "root", of=3)
    with pytest.raises(kf.ModelError, match="deflection has no parts"):
        result.read("deflection", "arm", "tip", "it")
    with pytest.raises(kf.ModelError, match="needs an interface"):
        result.read("coupling_force", "arm", of="it")


def test_one_name_of_two_is_told_apart_by_kind() -> None:
    scene, arm, p = cantilever(gravity=(0, 0, -9.81))
    spring(scene, arm, p)
    scene.add_rigid_body("it", 10.0, 0.01, parent=arm.interface("tip"))
    scene.add(Pull("F_k", arm.interface("tip"), 2 * ON_TIP))
    at = at_start(scene)
    assert at.neighbours("arm", "tip") == (("body it",), ("load it", "load F_k"))
    assert at.coupling_force("arm", "tip", "load it") == pytest.approx(ON_TIP, abs=1e-9)
    assert at.coupling_force("arm", "tip", "load F_k") == pytest.approx(2 * ON_TIP)
    assert at.coupling_force("arm", "tip", "F_k") == pytest.approx(3 * ON_TIP, abs=1e-9)


def test_files_studies_and_stepping_tell_the_same(tmp_path) -> None:
    scene, arm, p = cantilever(gravity=(0, 0, -9.81))
    spring(scene, arm, p)
    scene.add_rigid_body("weight", 1.0, 0.01, parent=arm.interface("tip"))
    result = scene.simulate((0.0, 0.02), output_step=0.01)
    result.save(tmp_path / "run.h5")
    loaded = kf.load_result(tmp_path / "run.h5")
    for interface, parts in (("tip", (None, "F_u", "F_k", "it", "weight")), ("root", (None, "F_u", "F_k", "ground"))):
        assert loaded.neighbours("arm", interface) == result.neighbours("arm", interface)
        for of in parts:
            force = result.coupling_force("arm", interface, of)
            np.testing.assert_array_equal(loaded.coupling_force("arm", interface, of), force)
    with pytest.raises(kf.ModelError, match="one of 'F_u', 'F_k', 'weight', 'it'"):
        loaded.coupling_force("arm", "tip", of="bolt")
    largest = abs(result.coupling_force("arm", "tip")[:, 2]).max()
    assert kf.studies.peak("coupling_force", "arm", "tip", component="force z")(result) == pytest.approx(
        {"peak coupling force arm tip force z": largest}
    )
    known = kf.studies.peak("coupling_force", "arm", "tip", "it", component="force z")(result)
    assert list(known.values()) == [abs(result.coupling_force("arm", "tip", "it")[:, 2]).max()]
    sim = scene.start(outputs=["coupling_force arm/tip force_z"])
    assert sim.outputs["coupling_force arm/tip force_z"] == pytest.approx(result.coupling_force("arm", "tip")[0, 2])
    figure = result.plot("coupling_force", "arm", "tip")
    np.testing.assert_array_equal(figure.axes[0].lines[2].get_ydata(), result.coupling_force("arm", "tip")[:, 2])


# -- balance


def more_loads(made: LoopScene, seed: int, is_rigid: bool) -> None:
    """Add every class of load and contact that random scenes do not have, on interfaces where there are any."""
    rng, scene = np.random.default_rng((seed, 11)), made.scene
    on = [frame for frame in made.carriers[1:] if frame.interface_frame is not None] or made.carriers[1:]

    def frame(at: bool = True) -> Any:
        found = on[int(rng.integers(len(on)))]
        return found.frame(at=rng.uniform(-0.2, 0.2, 3)) if at else found

    wind = {"angles": (0.0, 1.5, np.pi), "areas": rng.standard_normal((3, 6)), "is_symmetric": True}
    scene.add(kf.Rope("rope", (frame(), scene.ground.frame(at=(3, 1, 2)), frame()), axial_stiffness=9.0, preload=2.0))
    cable = {"stiffness": 5.0, "damping": 1.0, "speed": 1.0}
    scene.add(kf.Winch("winch", (scene.ground.frame(at=(-3, 1, 0)), frame()), tension=1.5, **cable))
    gas = {"area": 1e-4, "pressure": 3e4, "volume": 1e-2, "ambient": 0.0, "orifice": 0.1}
    scene.add(kf.Oleo("oleo", (scene.ground.frame(at=(0, 5, 0)), frame()), extended=20.0, **gas))
    scene.add(kf.PeriodicLoad("hub", frame(), 3.0, rng.standard_normal(6)))
    scene.add(kf.Aerodynamics("wind", frame(), kf.Wind((3.0, 1.0, 0.0)), **wind))
    scene.add(Pull("own", frame(), rng.standard_normal(6)))
    # a plane beyond everything, in whose reach all is
    side = scene.add_surface("side", scene.ground, kf.shapes.Plane("z"), at=(0, 0, 9.0))
    points = [frame(), *made.points[:1]]
    friction = kf.Coulomb(0.3, stiffness=3.0, damping=0.1)
    scene.add_contact("soft", points, side, normal=kf.KelvinVoigt(0.5, damping=0.1), friction=friction)
    if not is_rigid:
        return
    wall = scene.add_surface("wall", scene.ground, kf.shapes.Plane("x"), at=(-99.0, 0, 0))
    scene.add_contact("rigid", frame(), wall, normal=kf.Rigid(), friction=kf.Coulomb(0.4))


def touching(instant: Instant, rng: np.random.Generator) -> Instant:
    """Return the instant with its rigid contact stuck or slipping, wherever its bodies are."""
    model = instant.model
    z = instant.z.copy()
    contact, own = model.rigid_contact(0), z[model.load_states[model.rigid_contacts[0]]]
    status = int(rng.integers(1, 3))
    contact.with_status(own, 0, status, np.array((0.0, 0.6, 0.8)) if status == 2 else np.zeros(3))
    return Instant(model, instant.time, np.concatenate((instant.q, instant.u, z)))


def drawn_instant(seed: int, is_rigid: bool) -> Instant | None:
    """Return a random scene in a state with closed loops; None: it locks up, or two rows say nearly the same."""
    recipe = Recipe(seed, 9, elastic=0.6, loads=6, between=5)
    made, bare = LoopScene(recipe, 2), LoopScene(recipe, 2)
    more_loads(made, seed, is_rigid)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of stiffening that leaves something out
        model, plain = made.frozen(), bare.frozen()
    state = None if plain is None else closed_state(plain, seed)
    if model is None or state is None:
        return None
    instant = Instant(model, 0.0, np.concatenate((*state, model.initial_states)))
    instant = touching(instant, np.random.default_rng(seed)) if is_rigid else instant
    with suppress(kf.SimulationError):
        if model.route.evaluate(0.0, instant.state).weakest >= NEAR_SINGULAR:
            return instant
    return None


def random_instant(seed: int, is_rigid: bool) -> Instant:
    """Return the first of the scenes of a seed whose forces have values: every second one has."""
    drawn = (drawn_instant(seed + 100 * i, is_rigid) for i in range(20))
    return next(instant for instant in drawn if instant is not None)


def check_balance(seed: int, is_rigid: bool) -> None:
    instant = random_instant(seed, is_rigid)
    assert instant.model.route.name == "order n"
    found = imbalances(instant)
    assert max(found.values()) < BALANCED, found
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(RunChannels, "swept", property(lambda channels: channels.literal))
        literal = Instant(instant.model, 0.0, instant.state)
        assert max(imbalances(literal).values()) < BALANCED
    for body in (b for b in instant.model.bodies if b.flexible is not None):
        wholes = [instant.coupling_force(body.name, n.name) for n in body.interfaces]
        size = 1.0 + max(abs(whole).max() for whole in wholes)
        for n, whole in zip(body.interfaces, wholes, strict=True):
            parts = [instant.coupling_force(body.name, n.name, of) for of in ("F_u", "F_k")]
            assert sum(parts) == pytest.approx(whole, abs=1e-13 * size)  # the same numbers in another order
            # accelerations of both routes differ by round-off times the condition of the masses, up to 1e6
            assert literal.coupling_force(body.name, n.name) == pytest.approx(whole, abs=1e-9 * size)


@pytest.mark.parametrize(("seed", "is_rigid"), [(0, True), (1, False), (10, False)])
def test_every_body_of_random_scenes_balances_by_both_routes(seed: int, is_rigid: bool) -> None:
    check_balance(seed, is_rigid)


@pytest.mark.stress
@pytest.mark.parametrize("seed", range(30))
def test_more_random_scenes_balance(seed: int) -> None:
    check_balance(seed, True)


@pytest.mark.parametrize("seed", range(3))
def test_unreduced_bodies_balance(seed: int, monkeypatch) -> None:
    monkeypatch.setattr(build, "LARGEST_DENSE", 0)
    scene = kf.System(gravity=(0.3, -0.5, -1.0))
    hub = scene.add_rigid_body("hub", 2.0, 0.3, joint=kf.Revolute("y"))
    body = lattice_body(seed, interior=2)
    arm = scene.add_flexible_body("arm", body, parent=hub, at=(0.1, 0, 0), joint=kf.Revolute("z"))
    tip = arm.interface("tip")
    end = scene.add_rigid_body("end", 0.5, 0.1, parent=tip, joint=kf.Spherical(), at=(0.1, 0, 0))
    scene.add_spring("spring", tip, scene.ground.frame(at=(2, 1, 1)), stiffness=3.0, damping=0.2, rest_length=0.3)
    scene.add_bushing("bushing", arm.interface("root"), end, stiffness=(1.0,) * 6, damping=(0.1,) * 6)
    scene.add(kf.Rope("rope", (scene.ground, tip, end), axial_stiffness=5.0, preload=1.0))
    scene.add_force(tip, (1.0, 2.0, -1.0), point=(0.1, 0.0, 0.0), follows=True)
    scene.add_force(arm.node(4), (0.5, 0.0, 1.0))
    model = scene.freeze()
    assert model.route.name == "unreduced"
    q, u = random_state(model, seed)
    z = model.initial_states
    assert max(imbalances(Instant(model, 0.0, np.concatenate((q, u, z)))).values()) < BALANCED


# -- cost


def test_what_is_not_asked_is_not_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []

    def count(owner: Any, name: str) -> None:
        real = getattr(owner, name)
        monkeypatch.setattr(owner, name, lambda *args: asked.append(name) or real(*args))

    import kanefe.literal.run_forces as literal
    from kanefe.order_n.force_kernel import ForceKernel

    count(literal, "recovered_forces")
    count(literal, "joint_reactions")
    count(ForceKernel, "prepared")
    count(State, "marker")
    scene, arm, p = cantilever(gravity=(0, 0, -9.81))
    scene.add_rigid_body("weight", 1.0, 0.01, parent=arm.interface("tip"))
    spring(scene, scene.body("arm"), p)
    result = scene.simulate((0.0, 0.02), output_step=0.01)
    asked.clear()  # of the start, where the spring looks for its length
    for interface in ("tip", "root"):  # of carried bodies, loads and what carries the arm: all from one pass
        result.coupling_force("arm", interface)
    result.coupling_force("arm", "tip", of="it")
    result.joint_reaction("weight")
    assert asked == ["prepared"]
