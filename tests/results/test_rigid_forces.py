"""Forces of scenes with rigid contacts from one compiled call are those that the literal route finds state by state."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
import kanefe.order_n.run_forces as compiled
from draws import in_parts
from kanefe import shapes
from kanefe.equations.forces_at import ForcesAt
from kanefe.equations.model import Model
from kanefe.errors import SimulationError
from kanefe.frames import rotation_matrices
from kanefe.kane.assemble import accelerations
from kanefe.kane.contact_shares import spare_forces
from kanefe.literal.contact_forces import check_determined, told
from kanefe.literal.run_forces import LiteralForces
from kanefe.order_n.force_kernel import ForceKernel
from kanefe.tree.neighbours import parts_of, sources_of
from kanefe.tree.run_sweeps import RunForces
from kanefe_fem.beams.body import straight_beam
from kanefe_fem.beams.sections import Rectangle
from result_scenes import SOFT
from rigid_scenes import rigid_scene, rigid_state, stack

CORNERS = [(x, y, -0.1) for x in (-0.2, 0.2) for y in (-0.1, 0.1)]
STANDING = kf.Free(position=(0.0, 0.0, 0.1))


def all_of(model: Model, forces: RunForces) -> dict[str, np.ndarray]:
    """Return all that is told, by what it is."""
    found = {"reactions": forces.reactions, "driving": forces.driving, "loops": forces.loops}
    for i, part in enumerate(parts_of(model)):
        found[f"part {i}, {part.name}"] = forces.part(i)
    for k in range(len(model.rigid_contacts)):
        found |= {f"contact {k}": forces.contact(k), f"points of contact {k}": forces.contact_points(k)}
    others = [(i, load) for i, load in enumerate(model.loads) if i not in model.rigid_contacts]
    return found | {
        f"end {end} of load {i}": forces.on_end(i, end) for i, load in others for end in range(len(load.ends))
    }


def assert_alike(found: dict[str, np.ndarray], wanted: dict[str, np.ndarray], accuracy: float) -> None:
    size = max(1.0, *(abs(array).max(initial=0.0) for array in wanted.values()))
    for name, array in wanted.items():
        np.testing.assert_allclose(found[name], array, rtol=0, atol=accuracy * size, err_msg=name)


def literally(model: Model, times: np.ndarray, states: np.ndarray) -> LiteralForces:
    return LiteralForces.of_states(model.route, times, states)


def is_one_motion(model: Model, t: float, y: np.ndarray) -> bool:
    """Whether both routes have the same accelerations: where slipping points share normal forces they may not."""
    state, n = model.literal.view(t, y), model.coordinate_count
    du = model.route.evaluate(t, y).rates[n : n + model.free_count]
    return bool(np.abs(accelerations(state) - du).max() <= 1e-9 * max(1.0, np.abs(du).max()))


@pytest.mark.parametrize("part", in_parts(10, short=3))
def test_random_states_are_those_of_the_literal_route(part: int) -> None:
    """All that is told of 200 scenes, but of states that the kernel leaves to the literal route.

    Joints of bodies that float have no forces, whatever is told of contacts: that is the balance of their forces.
    """
    compared = 0
    for seed in range(20 * part, 20 * part + 20):
        model = rigid_scene(seed)
        states, times = rigid_state(model, 10 * seed)[None], np.full(1, 0.2)
        try:
            check_determined(model.literal.view(0.2, states[0]))
        except SimulationError:
            continue
        sweeps = model.route.sweeps(times, states)
        assert sweeps is not None
        if len(sweeps.forces._found[1]):  # type: ignore[attr-defined]
            continue
        found = all_of(model, sweeps.forces)
        size = max(1.0, *(abs(array).max(initial=0.0) for array in found.values()))
        floating = [i for i, body in enumerate(model.bodies) if isinstance(body.joint, kf.Free)]
        # round-off of two ways, some 1e-15, over the weakest pivot of rows in these scenes, 2e-6
        np.testing.assert_allclose(found["reactions"][:, floating], 0.0, rtol=0, atol=1e-9 * size)
        if is_one_motion(model, 0.2, states[0]):
            assert_alike(found, all_of(model, literally(model, times, states)), 1e-9)
            compared += 1
    assert compared >= 5  # of 20: the kernel leaves up to half, where rows are close to depending on others


def on_slope(
    slope: float, mu: float, com: tuple[float, float, float] = (0.0, 0.0, 0.0), spin: float = 0.0
) -> kf.System:
    """A box on four corners, across a slope."""
    scene = kf.System(gravity=(9.81 * math.sin(slope), 0.0, -9.81 * math.cos(slope)))
    joint = kf.Free(position=(0.0, 0.0, 0.1), angular_velocity=(0.0, 0.0, spin))
    box = scene.add_rigid_body("box", 2.0, 0.02, com=com, joint=joint)
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    feet = scene.add_surface("corners", box, shapes.Points(CORNERS))
    scene.add_contact("feet", feet, floor, normal=kf.Rigid(), friction=kf.Coulomb(mu))
    return scene


def loaded_table() -> kf.System:
    """A table on six legs with its load beside their middle: by forces of least norm the far legs would pull."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    table = scene.add_rigid_body("table", 2.0, 0.5, com=(0.8, 0.1, 0.0), joint=STANDING)
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    legs = scene.add_surface("legs", table, shapes.Points([(x, y, -0.1) for x in (-1, 0, 1) for y in (-0.5, 0.5)]))
    scene.add_contact("feet", legs, floor, normal=kf.Rigid(), friction=kf.Coulomb(0.5))
    return scene


def bouncing() -> kf.System:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    for i in range(4):
        joint = kf.Free(position=(0.5 * i, 0.0, 0.15 + 0.05 * i), velocity=(0.3, 0.0, 0.0))
        skin = scene.add_surface(
            f"skin {i}", scene.add_rigid_body(f"ball {i}", 1.0, 4e-3, joint=joint), shapes.Sphere(0.1)
        )
        scene.add_contact(f"contact {i}", skin, floor, normal=kf.Rigid(0.6), friction=kf.Coulomb(0.3))
    return scene


def laden() -> kf.System:
    """A box that sticks, with a flap that is latched, a wheel that rubs in its bearing, and a ball on a spring.

    The latch holds the one hinge several times, in N m and in N, beside the corners in N.
    """
    scene = on_slope(0.2, 0.6)
    box = scene.body("box")
    flap = scene.add_rigid_body("flap", 0.2, 1e-3, com=(0.1, 0, 0), parent=box, at=(0, 0, 0.1), joint=kf.Revolute("y"))
    scene.add_loop_joint("latch", kf.Fixed(), flap.frame(at=(0.2, 0, 0.1)), box.frame(at=(0.2, 0, 0.2)))
    rubs = kf.JointFriction(0.1, 0.01)
    wheel = kf.Revolute("y", speed=5.0, friction=rubs)
    scene.add_rigid_body("wheel", 0.3, 1e-3, com=(0.01, 0, 0), parent=box, at=(0, 0.2, 0), joint=wheel)
    ball = scene.add_rigid_body("ball", 0.5, 1e-3, joint=kf.Free(position=(0.5, 0.5, 0.0999)))
    skin, ground = (
        scene.add_surface("skin", ball, shapes.Sphere(0.1)),
        scene.add_surface("ground", scene.ground, shapes.Plane("z")),
    )
    scene.add_contact("soft", skin, ground, normal=kf.HuntCrossley(1e5), friction=kf.Coulomb(0.4))
    scene.add_spring("cord", ball, box.frame(at=(0.2, 0.1, 0)), stiffness=5.0, rest_length=0.3)
    return scene


def landing() -> kf.System:
    """A flexible beam with a foot at both ends that falls on a driven deck, and carries a tool at its tip."""
    beam = straight_beam(1.0, Rectangle(0.02, 0.04), SOFT, elements=4)
    interfaces = {"root": "clamped", "tip": "rigid"}
    body = kf.flexible_body(beam, interfaces, reduction=kf.CraigBampton(modes=2), damping=kf.RayleighDamping(0.0, 1e-3))
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    heave = kf.Motion.table(np.linspace(0.0, 1.0, 21), 0.02 * np.sin(6.0 * np.linspace(0.0, 1.0, 21)))
    deck = scene.add_rigid_body("deck", 5.0, 1.0, joint=kf.Prismatic("z", motion=heave))
    top = scene.add_surface("top", deck, shapes.Plane("z"))
    hub = scene.add_rigid_body("hub", 1.0, 0.05, joint=kf.Free(position=(0.0, 0.0, 0.2)))
    arm = scene.add_flexible_body("arm", body, parent=hub)
    scene.add_rigid_body("tool", 0.3, 0.01, parent=arm.interface("tip"), at=(0, 0, 0.1), joint=kf.Revolute("y"))
    points = shapes.Points([(0, y, -0.05) for y in (-0.1, 0.1)])
    law, friction = kf.Rigid(0.1), kf.Coulomb(0.4)
    for name, frame in (("hub", hub), ("tip", arm.interface("tip"))):
        scene.add_contact(f"{name} foot", scene.add_surface(name, frame, points), top, normal=law, friction=friction)
    return scene


RUNS: dict[str, Callable[[], kf.System]] = {
    "box that slides": lambda: on_slope(0.3, 0.2),
    "box that sticks, its friction shared by the normal forces": lambda: on_slope(0.35, 0.45, (0.0, 0.02, 0.1)),
    "box that spins": lambda: on_slope(0.0, 0.3, (0.02, 0.01, 0.0), 3.0),
    "stack": lambda: stack(3, 0.01),
    "bouncing balls": bouncing,
    "box with loops, compliant contact and friction in a bearing": laden,
    "flexible body that lands on a driven deck": landing,
}


@pytest.mark.parametrize("name", RUNS)
def test_runs_are_read_in_one_compiled_call(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    result = RUNS[name]().simulate((0.0, 0.4), output_step=0.02)
    channels, passes, prepared = result._channels, [], ForceKernel.prepared

    def asked(_: object) -> LiteralForces:
        raise AssertionError("the literal route was asked")

    with monkeypatch.context() as patched:
        patched.setattr(ForceKernel, "prepared", lambda self, *given: passes.append(1) or prepared(self, *given))
        patched.setattr(compiled.CompiledForces, "_of_rest", property(asked))
        found = all_of(channels.model, channels.forces)
        for contact in channels.points:
            result.contact(contact)
            result.contact_points(contact)
    assert len(passes) == 1
    wanted = all_of(channels.model, literally(channels.model, channels.times, channels.states))
    assert any(array.any() for what, array in wanted.items() if what.startswith("contact"))
    for k in range(len(channels.model.rigid_contacts)):
        # in the air the nearest point is told: of two equally near, on either side of y = 0, round-off decides which
        depths = wanted[f"points of contact {k}"][:, :, 4]
        is_even = (depths >= depths.max(axis=1, keepdims=True) - 1e-12).sum(axis=1) > 1
        is_open, y = ~(depths >= 0.0).any(axis=1), found[f"contact {k}"][:, 8]
        np.copysign(y, wanted[f"contact {k}"][:, 8], out=y, where=is_even & is_open)
    assert_alike(found, wanted, 1e-10)  # round-off of forces that cancel


def test_rows_that_say_several_times_the_same_beside_corners_are_there() -> None:
    """What the case with loops compares: forces of corners, and forces and moments of a latch, that can be shared."""
    model = laden().freeze()
    spare = spare_forces(model.literal.view(0.0, model.route.start(0.0)))
    assert np.abs(spare[: len(model.constraints[0].rows)]).max() > 0.1
    assert np.abs(spare[len(model.constraints[0].rows) :]).max() > 0.1


def test_what_only_a_search_can_share_the_literal_route_tells() -> None:
    result = loaded_table().simulate((0.0, 0.02), output_step=0.01)
    forces = result._channels.forces
    assert len(forces._found[1]) == len(result.times)
    normal = result.contact_points("feet").normal
    assert normal.min() > -1e-9
    np.testing.assert_allclose(normal.sum(axis=1), 2.0 * 9.81, rtol=1e-9)
    np.testing.assert_allclose(result.contact("feet").normal, 2.0 * 9.81, rtol=1e-9)


def test_the_contact_of_a_foot_is_a_part_of_the_force_at_its_interface() -> None:
    result = landing().simulate((0.0, 0.4), output_step=0.02)
    model = result._channels.model
    assert "tip foot" in sources_of(model)[model.index("arm"), "tip"].neighbours.unknown
    axes = rotation_matrices(result.rotation("arm"))
    in_N = (axes @ result.coupling_force("arm", "tip", of="tip foot")[:, :3, None])[:, :, 0]
    wanted = result.contact("tip foot").force
    assert wanted.any()
    np.testing.assert_allclose(in_N, wanted, rtol=0, atol=1e-10 * np.abs(wanted).max())


def test_functions_of_the_state_see_what_a_run_tells() -> None:
    result = on_slope(0.35, 0.45, (0.0, 0.02, 0.1)).simulate((0.0, 0.1), output_step=0.05)
    channels = result._channels
    seen = ForcesAt(channels.model, channels.times[1], channels.states[1]).rigid_contact(0)
    np.testing.assert_array_equal(seen, channels.read("load", "feet")[1])
    state = channels.model.literal.view(channels.times[1], channels.states[1])
    np.testing.assert_allclose(seen, told(state, 0), rtol=0, atol=1e-12 * np.abs(seen).max())
