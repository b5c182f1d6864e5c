"""Bad input to a scene: an error that names the thing and the remedy, and nothing half-built."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import KanefeError, ModelError
from scenes import lattice_body

BODY = lattice_body(0)
FLOATING = lattice_body(0, {}, reduction=kf.CraigBampton(modes=2))


def scene() -> tuple[kf.System, Any, Any]:
    """Return a scene with a hub on a hinge and an arm on it."""
    system = kf.System()
    hub = system.add_rigid_body("hub", 1.0, 0.1, joint=kf.Revolute("z"))
    arm = system.add_flexible_body("arm", BODY, parent=hub)
    return system, hub, arm


def rigid(**options: Any) -> Callable[[], Any]:
    return lambda: scene()[0].add_rigid_body(**{"name": "b", "mass": 1.0, "inertia": 0.1, **options})


def flexible(**options: Any) -> Callable[[], Any]:
    return lambda: scene()[0].add_flexible_body(**{"name": "b", "body": BODY, **options})


def load(kind: str, target: str, *values: Any, **options: Any) -> Callable[[], Any]:
    def add() -> None:
        system, hub, arm = scene()
        targets = {"hub": hub, "arm": arm, "tip": arm.interface("tip"), "node": arm.node(3), "nothing": "hub"}
        getattr(system, f"add_{kind}")(targets[target], *values, **options)

    return add


RIGID_CASES = [
    (rigid(mass=-1.0), r"mass of body 'b' must be finite and >= 0 kg, not -1\.0"),
    (rigid(mass=np.nan), "mass of body 'b' must be finite and >= 0 kg, not nan"),
    (rigid(mass="heavy"), "mass of body 'b' must be finite and >= 0 kg, not 'heavy'"),
    (rigid(mass=(1.0, 2.0)), "mass of body 'b' must be finite"),
    (rigid(mass=None), "mass of body 'b' must be finite and >= 0 kg, not None"),
    (rigid(inertia="big"), "inertia of body 'b' must be one number, three or a 3 x 3 matrix, not 'big'"),
    (rigid(mass=0.0), "body 'b' has inertia but no mass. Remedy: give it a mass, or no inertia"),
    (rigid(com=(1, 2)), r"com of body 'b' must be three finite numbers in m, not \(1, 2\)"),
    (rigid(com=(1, 2, np.inf)), "com of body 'b' must be three finite numbers"),
    (rigid(inertia=(1, 2)), "inertia of body 'b' must be one number, three or a 3 x 3 matrix"),
    (rigid(inertia=np.nan), "inertia of body 'b' must be one number, three or a 3 x 3 matrix"),
    (
        rigid(inertia=np.array([[1, 0.5, 0], [0, 1, 0], [0, 0, 1]])),
        r"inertia of body 'b' is not symmetric\. Remedy: pass 0\.5",
    ),
    (rigid(inertia=-0.1), "inertia of body 'b' has a negative principal moment"),
    (rigid(inertia=(1, 1, -0.5)), r"inertia of body 'b' has a negative principal moment \(-0\.5 kg m2\)"),
    (
        rigid(inertia=(1, 1, 2.1)),
        r"inertia of body 'b' breaks the triangle inequality: .* 2\.1 kg m2.* Remedy: check units",
    ),
    (
        rigid(inertia=np.array([[1, 0.9, 0], [0.9, 1, 0], [0, 0, 0.5]])),
        "inertia of body 'b' breaks the triangle inequality",
    ),
]
COMMON_CASES = [
    ({"name": "hub"}, "the scene already has a body called 'hub'. Remedy: another name"),
    ({"name": "arm"}, "the scene already has a body called 'arm'. Remedy: another name"),
    ({"name": ""}, "the name of a body must be a text without '/' and null characters, not ''"),
    ({"name": "a/b"}, "the name of a body must be a text without '/' and null characters, not 'a/b'"),
    ({"name": "a\0"}, "the name of a body must be a text without '/' and null characters"),
    ({"name": 3}, "the name of a body must be a text"),
    ({"joint": "revolute"}, r"joint of body 'b' must be a Joint, such as Revolute\('z'\), not 'revolute'"),
    ({"joint": kf.Revolute}, "joint of body 'b' must be a Joint"),
    ({"parent": "hub"}, "parent of body 'b' must be a body or interface of this scene, not 'hub'"),
    ({"orientation": (1, 0, 0)}, r"orientation of body 'b' must be a rotation, not \(1, 0, 0\)"),
    ({"orientation": (0, 0, 0, 0)}, "orientation of body 'b' must be a rotation"),
    ({"orientation": (1, np.nan, 0, 0)}, "orientation of body 'b' must be a rotation"),
    ({"at": (1, 2)}, r"at of body 'b' must be three finite numbers, not \(1, 2\)"),
    ({"at": "tip"}, "at of body 'b' must be three finite numbers, not 'tip'"),
    ({"at": (1, (2, 3), 4)}, "at of body 'b' must be three finite numbers"),
    ({"at": (1, 2, np.nan)}, "at of body 'b' must be three finite numbers"),
]
FLEXIBLE_CASES = [
    (flexible(body="arm.npz"), r"flexible body 'b' must be a FlexibleBody, not str\. Remedy: make one with"),
    (flexible(body=None), "flexible body 'b' must be a FlexibleBody, not NoneType"),
    (
        flexible(body=FLOATING),
        "'b' has no interface fixed in G, so a fixed joint has nothing to hold. Remedy: .*'clamped'",
    ),
    (flexible(body=FLOATING, joint=kf.Revolute("z")), "so a revolute joint has nothing to hold. Remedy: .*free joint"),
    (flexible(body=FLOATING, joint=kf.Spherical()), "so a spherical joint has nothing to hold. Remedy: .*free joint"),
    (
        flexible(modal_coordinates=[1.0]),
        r"modal_coordinates of body 'b' must be 15 finite numbers, shape \(1,\) was given",
    ),
    (flexible(modal_speeds=[np.nan] * 15), "modal_speeds of body 'b' must be 15 finite numbers"),
]
LOAD_CASES = [
    (load("force", "hub", (1, 2)), r"the force on 'hub' must be three finite numbers, not \(1, 2\)"),
    (load("force", "tip", (1, 2, np.nan)), "the force on 'tip' of 'arm' must be three finite numbers"),
    (load("force", "node", 3.0), "the force on 'node 3' of 'arm' must be three finite numbers"),
    (load("force", "hub", (1, 2, 3), point=(0, 0)), "point of the force on 'hub' must be three finite numbers"),
    (
        load("force", "nothing", (1, 2, 3)),
        "the target of a load must be a body or an interface of this scene, or scene.ground, not 'hub'",
    ),
    (load("torque", "hub", (1, 2)), "the torque on 'hub' must be three numbers or one for a motor"),
    (load("torque", "tip", 2.0), "the torque on 'tip' of 'arm' must be three numbers"),
    (load("torque", "hub", np.nan), "the torque on 'hub' must be a finite number, not nan"),
    (load("torque", "hub", "strong"), "the torque on 'hub' must be"),
    (load("force", "hub", "strong"), "the force on 'hub' must be three finite numbers, not 'strong'"),
    (load("torque", "hub", (1, 2, np.nan)), "the torque on 'hub' must be three finite numbers"),
    (load("torque", "hub", lambda t: (1, 2)), "the torque on 'hub' must be three numbers or one for a motor"),
    (
        load("torque", "arm", 1.0),
        "the torque on 'arm' is one number, but its fixed joint has no single free axis. Remedy",
    ),
]


@pytest.mark.parametrize(("make", "message"), [*RIGID_CASES, *FLEXIBLE_CASES, *LOAD_CASES])
def test_bad_bodies_and_loads_are_named(make: Callable[[], Any], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        make()


@pytest.mark.parametrize("add", [rigid, flexible], ids=["rigid", "flexible"])
@pytest.mark.parametrize(("options", "message"), COMMON_CASES)
def test_bad_placing_is_named(options: dict, message: str, add: Callable[..., Callable[[], Any]]) -> None:
    with pytest.raises(ModelError, match=message):
        add(**options)()


@pytest.mark.parametrize("add", [rigid, flexible], ids=["rigid", "flexible"])
def test_a_refused_body_leaves_the_scene_as_it_was(add: Callable[..., Callable[[], Any]], monkeypatch: Any) -> None:
    system, _, _ = scene()
    monkeypatch.setitem(globals(), "scene", lambda: (system, None, None))
    for options in ({"name": "hub"}, {"at": (1, 2)}, {"orientation": (0, 0, 0, 0)}):
        with pytest.raises(ModelError):
            add(**options)()
    add()()  # the name is still free
    assert [b.name for b in system.freeze().bodies] == ["hub", "arm", "b"]


def test_a_parent_from_another_system_is_named() -> None:
    (_, hub, arm), (other, _, _) = scene(), scene()
    for parent, name in ((hub, "hub"), (arm.interface("tip"), "arm")):
        with pytest.raises(ModelError, match=f"parent '{name}' of body 'b' belongs to another system. Remedy: body"):
            other.add_rigid_body("b", 1.0, parent=parent)
        with pytest.raises(ModelError, match=r"belongs to another system. Remedy: scene.body"):
            other.add_force(parent, (1, 2, 3))


def test_a_flexible_parent_carries_at_its_interfaces_only() -> None:
    system, _, arm = scene()
    with pytest.raises(
        ModelError, match=r"carries other bodies at its interfaces only\. Remedy: .* one of \['root', 'tip'\]"
    ):
        system.add_rigid_body("b", 1.0, parent=arm)
    with pytest.raises(ModelError, match=r"node 3 of 'arm' has no rotation of its own\. Remedy: an interface"):
        system.add_rigid_body("b", 1.0, parent=arm.node(3))
    with pytest.raises(ModelError, match=r"no interface called 'middle'\. It has: root, tip"):
        arm.interface("middle")
    with pytest.raises(ModelError, match="node 99 is not one of the 9 nodes of this body"):
        arm.node(99)


def test_an_interface_whose_frame_cannot_turn_carries_no_body() -> None:
    # "middle" is a single node without rotations: what it carries could not turn with the body
    system = kf.System()
    arm = system.add_flexible_body("arm", lattice_body(0, {"root": "clamped", "middle": "rigid"}))
    with pytest.raises(
        ModelError, match=r"interface 'middle' of 'arm' is a node without a rotation .* Remedy: an interface of three"
    ):
        system.add_rigid_body("b", 1.0, parent=arm.interface("middle"))
    system.add_force(arm.interface("middle"), (1, 0, 0))  # loads may act there


def test_a_driven_joint_takes_no_motor() -> None:
    system = kf.System()
    hub = system.add_rigid_body("hub", 1.0, 0.1, joint=kf.Revolute("z", motion=kf.Motion.steady(1.0)))
    with pytest.raises(
        ModelError, match="the torque on 'hub' is one number, but its revolute joint has no single free axis"
    ):
        system.add_torque(hub, 1.0)


@pytest.mark.parametrize("gravity", [(0, 0), (0, 0, np.nan), 9.81])
def test_bad_gravity_is_named(gravity: Any) -> None:
    with pytest.raises(ModelError, match="gravity must be three finite numbers"):
        kf.System(gravity=gravity)


def test_unknown_slopes_are_named() -> None:
    with pytest.raises(ModelError, match=r"no slopes called 'euler'\. Remedy: one of"):
        kf.System(slopes="euler")


def test_an_empty_scene_is_named() -> None:
    with pytest.raises(ModelError, match=r"the scene has no bodies\. Remedy: add_rigid_body or add_flexible_body"):
        kf.System().simulate((0.0, 1.0))


def test_unknown_bodies_of_a_model_are_named() -> None:
    model = scene()[0].freeze()
    with pytest.raises(ModelError, match=r"no body called 'hubb'\. It has: hub, arm"):
        model.index("hubb")
    with pytest.raises(ModelError, match="body 'hub' is rigid: it has no modal coordinates, mesh or interfaces"):
        model.flexible_terms("hub")


@pytest.mark.parametrize(
    "make",
    [
        rigid(inertia=(1, 1, 2)),  # a thin disc: the equality
        rigid(inertia=(0, 1, 1)),  # a thin rod
        rigid(inertia=(1, 1, 2 + 1e-7)),  # round-off of a CAD program
        rigid(inertia=np.array([[1, 1e-12, 0], [0, 1, 0], [0, 0, 1]])),
        rigid(mass=0.0, inertia=0.0),  # a frame
        rigid(inertia=0.0),  # a point mass
        flexible(body=FLOATING, joint=kf.Free()),
        flexible(body=FLOATING, joint=kf.Planar()),
    ],
)
def test_border_cases_are_taken(make: Callable[[], Any]) -> None:
    make()


def test_a_body_that_exists_is_refused_before_its_arrays_are_read() -> None:
    system, _, _ = scene()
    with pytest.raises(ModelError, match="already has a body called 'arm'"):
        system.add_flexible_body("arm", BODY, modal_coordinates=[1, 2, 3])


def test_later_changes_of_the_user_s_arrays_change_nothing() -> None:
    at, gravity, force = np.array([1.0, 0, 0]), np.array([0, 0, -9.81]), np.array([1.0, 2.0, 3.0])
    system = kf.System(gravity=gravity)
    body = system.add_rigid_body("b", 1.0, 0.1, at=at, joint=kf.Free())
    system.add_force(body, force)
    at[:] = gravity[:] = force[:] = 7.0
    model = system.freeze()
    assert model.bodies[0].p_PoFo_P.tolist() == [1.0, 0.0, 0.0]
    assert model.gravity.tolist() == [0.0, 0.0, -9.81]
    assert model.bodies[0].loads[0][0].function(0.0).tolist() == [1.0, 2.0, 3.0]


def test_every_error_is_a_kanefe_error() -> None:
    for make, _ in (*RIGID_CASES, *FLEXIBLE_CASES, *LOAD_CASES):
        with pytest.raises(KanefeError):
            make()
