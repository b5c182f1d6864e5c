"""The same scenes in other units, m, mm and um, kg and t, and of other sizes: equilibria of all kinds are the same."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import pytest

import kanefe as kf
from kanefe import shapes
from kanefe_fem import Material, Rectangle, beam_body, exact_beam, straight_beam
from other_units import DOWN, OTHERS, Units, assert_same_as_in_si

pytestmark = [
    pytest.mark.filterwarnings("ignore::kanefe.errors.UnitWarning"),
    pytest.mark.filterwarnings("ignore::kanefe.errors.AccuracyWarning"),  # the linear leaves bend far
]


def ball(of: Units) -> kf.Equilibrium:
    scene = of.system(*DOWN)
    spring = kf.CoordinateForce(stiffness=100.0 * of.kg)
    of.body(scene, "ball", 2.0, 0.0, (0, 0, 0), joint=kf.Prismatic("z", forces=spring))
    return kf.equilibrium(scene)


def chain(of: Units) -> kf.Equilibrium:
    scene = of.system(*DOWN)
    first = of.body(scene, "first", 1.0, 0.1, (0.5, 0, 0), joint=kf.Spherical())
    of.body(scene, "second", 1.0, 0.1, (0.5, 0, 0), at=of.at(1, 0, 0), parent=first, joint=kf.Spherical())
    return kf.equilibrium(scene)


def upright(of: Units) -> kf.Equilibrium:
    scene = of.system(*DOWN)
    of.body(scene, "rod", 1.0, 1 / 12, (0, 0, 0.5), joint=kf.Revolute("y"))
    return kf.equilibrium(scene)


def loop(of: Units) -> kf.Equilibrium:
    """A spatial four-bar of revolute joints, whose rows are partly redundant, on a spring."""
    scene = of.system(*DOWN)
    spring = kf.CoordinateForce(stiffness=5.0 * of.inertia)
    crank = of.body(scene, "crank", 1.0, 0.02, (0.2, 0, 0), joint=kf.Revolute("y", forces=spring))
    rod = of.body(scene, "rod", 2.0, 0.1, (0.5, 0, 0), at=of.at(0.4, 0, 0), parent=crank, joint=kf.Revolute("y"))
    rocker = of.body(
        scene, "rocker", 1.5, 0.05, (0, 0, 0.3), at=of.at(1.4, 0, -0.6), joint=kf.Revolute("y"), parent=scene.ground
    )
    scene.add_loop_joint("pin", kf.Revolute("y"), rod.frame(at=of.at(1.0, 0, 0)), rocker.frame(at=of.at(0, 0, 0.6)))
    return kf.equilibrium(scene)


def governor(of: Units) -> kf.Equilibrium:
    scene = of.system(*DOWN)
    shaft = of.body(scene, "shaft", 1.0, 0.01, (0, 0, 0), joint=kf.Revolute("z", motion=kf.Motion.steady(6.0)))
    of.body(scene, "arm", 1.0, 0.0, (0, 0, -0.5), parent=shaft, joint=kf.Revolute("y", position=0.3))
    return kf.equilibrium(scene)


def free_governor(of: Units) -> kf.Equilibrium:
    scene = of.system(*DOWN)
    shaft = of.body(scene, "shaft", 1.0, 0.01, (0, 0, 0), joint=kf.Revolute("z"))
    of.body(scene, "arm", 1.0, 0.0, (0, 0, -0.5), parent=shaft, joint=kf.Revolute("y", position=0.3))
    return kf.equilibrium(scene, speeds={"shaft": 6.0})


def top(of: Units) -> kf.Equilibrium:
    scene = of.system(*DOWN)
    turn = scene.add_frame("turn", joint=kf.Revolute("z"))
    tilt = scene.add_frame("tilt", parent=turn, joint=kf.Revolute("x", position=0.4))
    inertia = tuple(of.inertia * x for x in (0.02, 0.02, 0.01))
    scene.add_rigid_body("top", of.kg, inertia, com=of.at(0, 0, 0.3), parent=tilt, joint=kf.Revolute("z"))
    return kf.equilibrium(scene, speeds={"top": 150.0, "tilt": 0.0, "turn": 1.0}, find=["turn"])


def held_by_friction(of: Units) -> kf.Equilibrium:
    scene = of.system(4.0, 0.0, -9.0)
    rail = kf.Prismatic("x", friction=kf.JointFriction(0.5, static=0.6, stribeck_speed=0.01 * of.m))
    of.body(scene, "slide", 3.0, 0.1, (0.1, 0, 0.2), joint=rail)
    return kf.equilibrium(scene)


def on_springs(of: Units) -> kf.Equilibrium:
    scene = of.system(*DOWN)
    plate = of.body(scene, "plate", 10.0, 1.0, (0.1, 0.2, 0), joint=kf.Free(position=of.at(0, 0, 1.0)))
    for i, (x, y) in enumerate(((1, 0), (-1, 0.5), (0.2, -1))):
        top = scene.ground.frame(at=of.at(2.0 * x, 1.5 * y, 3.0))
        corner = plate.frame(at=of.at(x, y, 0))
        scene.add_spring(f"spring {i}", top, corner, stiffness=80.0 * of.kg, rest_length=0.5 * of.m)
    return kf.equilibrium(scene)


def box(of: Units, normal: object, **friction: float) -> kf.Equilibrium:
    scene = of.system(*DOWN)
    tilt = kf.rotation_about("y", 0.1)
    slope = scene.add_surface("slope", scene.ground, shapes.Plane("z"), orientation=tilt)
    box = of.body(scene, "box", 2.0, 0.1, (0, 0, 0), joint=kf.Free(position=of.at(0, 0, 0.125)))
    skin = scene.add_surface("skin", box, shapes.Box(of.at(0.4, 0.3, 0.2)))
    scene.add_contact("c", skin, slope, normal=normal, friction=kf.Coulomb(0.5, **friction))
    return kf.equilibrium(scene)


def soft_box(of: Units) -> kf.Equilibrium:
    return box(of, kf.HuntCrossley(1e5 * of.kg, 0.3 / of.m))


def hertz_box(of: Units) -> kf.Equilibrium:
    return box(of, kf.HuntCrossley(1e7 * of.kg / of.m**0.5, 0.3 / of.m, exponent=1.5), stiffness=1e5 * of.kg)


def rigid_box(of: Units) -> kf.Equilibrium:
    return box(of, kf.Rigid())


def lever(of: Units) -> kf.Equilibrium:
    scene = of.system(*DOWN)
    hinge = kf.Revolute("y", position=-0.3, forces=kf.CoordinateForce(stiffness=10.0 * of.inertia))
    body = of.body(scene, "lever", 2.0, 0.1, (0.5, 0, 0), joint=hinge)
    stop = scene.add_surface("stop", scene.ground, shapes.Plane("z"), at=of.at(0, 0, -0.2))
    scene.add_contact("end", body.frame(at=of.at(1.0, 0, 0)), stop, normal=kf.Rigid())
    return kf.equilibrium(scene)


STRIP, LENGTH = (0.01, 0.05), 1.0


def silicon(of: Units) -> Material:
    return Material(E=169e9 * of.pascal, nu=0.0, rho=2330.0 * of.kg / of.m**3)


def strip(of: Units) -> Rectangle:
    return Rectangle(*of.at(*STRIP))


@cache
def linear_leaf(of: Units, stiffening: str) -> kf.FlexibleBody:
    beam = straight_beam(LENGTH * of.m, strip(of), silicon(of), elements=10, planar=True)
    ends = {"root": "clamped", "tip": "rigid"}
    return beam_body(beam, ends, kf.CraigBampton(modes=4), stiffening=stiffening)


@cache
def exact_leaf(of: Units, theory: str) -> kf.FlexibleBody:
    return exact_beam(LENGTH * of.m, strip(of), silicon(of), basis=8, theory=theory, planar=True)


def stage(of: Units, leaf: kf.FlexibleBody, travel: float = 0.2) -> kf.Equilibrium:
    """A block on two parallel leaf springs, which it bends by a share of their length."""
    scene, height = of.system(0, 0, 0), 0.4
    upper = scene.add_flexible_body("upper", leaf, at=of.at(0, height / 2, 0))
    lower = scene.add_flexible_body("lower", leaf, at=of.at(0, -height / 2, 0))
    block = of.body(scene, "block", 9.5, 0.2, (0.1, -height / 2, 0), parent=upper.interface("tip"))
    scene.add_loop_joint("weld", kf.Fixed(), lower.interface("tip"), block.frame(at=of.at(0, -height, 0)))
    force = 24.0 * 169e9 * STRIP[1] * STRIP[0] ** 3 / 12.0 / LENGTH**2 * travel
    scene.add_force(block, (0, force * of.newton, 0), point=of.at(-0.5, -height / 2, 0))
    return kf.equilibrium(scene)


def linear_stage(of: Units) -> kf.Equilibrium:
    return stage(of, linear_leaf(of, "none"))


def stiffened_stage(of: Units) -> kf.Equilibrium:
    return stage(of, linear_leaf(of, "full"))


def exact_stage(of: Units) -> kf.Equilibrium:
    return stage(of, exact_leaf(of, "shear-rigid"))


def stretching_stage(of: Units) -> kf.Equilibrium:
    return stage(of, exact_leaf(of, "stretching"))


def blade(of: Units) -> kf.Equilibrium:
    """A leaf that is stretched by its spin and hangs in gravity."""
    scene = of.system(*DOWN)
    shaft = scene.add_frame("shaft", joint=kf.Revolute("z", motion=kf.Motion.steady(20.0)))
    scene.add_flexible_body("blade", linear_leaf(of, "full"), parent=shaft, at=of.at(0.2, 0, 0))
    return kf.equilibrium(scene)


def coiled(of: Units) -> kf.Equilibrium:
    """An exact beam that a couple bends by a radian and a force pulls."""
    scene = of.system(0, 0, 0)
    leaf = scene.add_flexible_body("leaf", exact_leaf(of, "shear-rigid"))
    stiffness = 169e9 * STRIP[1] * STRIP[0] ** 3 / 12.0
    scene.add_torque(leaf.interface("tip"), (0, 0, stiffness / LENGTH * of.inertia))
    scene.add_force(leaf.interface("tip"), (0.3 * stiffness / LENGTH**2 * of.newton, 0, 0))
    return kf.equilibrium(scene)


def doors(of: Units) -> kf.Equilibrium:
    """A door on two hinges, the second of which is redundant, and a spring of turning."""
    scene = of.system(1.0, 0.5, -9.81)
    spring = kf.CoordinateForce(stiffness=4.0 * of.inertia)
    door = of.body(scene, "door", 12.0, 2.0, (0.4, 0, 1.0), joint=kf.Revolute("z", forces=spring))
    top = of.at(0, 0, 2)
    scene.add_loop_joint("hinge", kf.Revolute("z"), door.frame(at=top), scene.ground.frame(at=top))
    return kf.equilibrium(scene)


def on_ropes(of: Units) -> kf.Equilibrium:
    """A weight on three ropes, and one that stays slack."""
    scene = of.system(*DOWN)
    weight = of.body(scene, "weight", 5.0, 0.1, (0, 0, 0), joint=kf.Free(position=of.at(0.1, 0.05, -1.0)))
    for i, (x, y, length) in enumerate(((1, 0, 1.2), (-0.6, 0.8, 1.1), (-0.5, -0.9, 1.3), (0, 0.1, 3.0))):
        ends = scene.ground.frame(at=of.at(x, y, 0)), weight.frame(at=of.at(0.1 * x, 0.1 * y, 0.1))
        scene.add(kf.Rope(f"rope {i}", ends, axial_stiffness=2e3 * of.newton, length=length * of.m))
    return kf.equilibrium(scene)


def on_bushings(of: Units) -> kf.Equilibrium:
    scene = of.system(*DOWN)
    engine = of.body(scene, "engine", 80.0, 2.0, (0.1, 0.2, 0.3), joint=kf.Free())
    for i, (x, y) in enumerate(((0.5, 0), (-0.4, 0.3), (-0.4, -0.3))):
        soft = *(of.kg * k for k in (2e4, 3e4, 5e4)), *(of.inertia * k for k in (50.0, 40.0, 30.0))
        feet = scene.ground.frame(at=of.at(x, y, 0)), engine.frame(at=of.at(x, y, 0))
        scene.add_bushing(f"mount {i}", *feet, stiffness=soft)
    return kf.equilibrium(scene)


def geared(of: Units) -> kf.Equilibrium:
    """Two shafts that a gear couples, with a weight on one and a spring on the other."""
    scene = of.system(*DOWN)
    spring = kf.CoordinateForce(stiffness=30.0 * of.inertia)
    arm = of.body(scene, "arm", 3.0, 0.1, (0.5, 0, 0), joint=kf.Revolute("y"))
    wheel = of.body(scene, "wheel", 1.0, 0.05, (0, 0, 0), at=of.at(0, 1, 0), joint=kf.Revolute("y", forces=spring))
    scene.add_gear("gear", {arm: 2.0, wheel: 1.0})
    return kf.equilibrium(scene)


def followed(of: Units) -> kf.Equilibrium:
    """A force that turns with its body, and a load that raising alone finds: an exact leaf coiled by a whole turn."""
    scene = of.system(0, 0, 0)
    leaf = scene.add_flexible_body("leaf", exact_leaf(of, "shear-rigid"))
    stiffness = 169e9 * STRIP[1] * STRIP[0] ** 3 / 12.0
    scene.add_torque(leaf.interface("tip"), (0, 0, 4.0 * stiffness / LENGTH * of.inertia))
    scene.add_force(leaf.interface("tip"), (0, stiffness / LENGTH**2 * of.newton, 0), follows=True)
    return kf.equilibrium(scene)


def in_a_trough(of: Units) -> kf.Equilibrium:
    """A ball between two planes, pressed against one of them."""
    scene = of.system(1.0, 0.0, -9.81)
    carrier = of.body(scene, "carrier", 0.1, 0.0, (0, 0, 0), at=of.at(0.01, 0, 0.14), joint=kf.Prismatic("x"))
    ball = of.body(scene, "ball", 2.0, 0.01, (0, 0, 0), parent=carrier, joint=kf.Prismatic("z"))
    skin = scene.add_surface("skin", ball, shapes.Sphere(0.1 * of.m))
    for name, tilt in (("left", 0.7), ("right", -0.7)):
        side = scene.add_surface(name, scene.ground, shapes.Plane("z"), orientation=kf.rotation_about("y", tilt))
        law = kf.HuntCrossley(1e6 * of.kg / of.m**0.5, 0.3 / of.m, exponent=1.5)
        scene.add_contact(f"on {name}", skin, side, normal=law, friction=kf.Coulomb(0.3, stiffness=1e5 * of.kg))
    return kf.equilibrium(scene)


SCENES: tuple[Callable[[Units], kf.Equilibrium], ...] = (
    *(ball, chain, upright, loop, governor, free_governor, top, held_by_friction, on_springs),
    *(soft_box, hertz_box, rigid_box, lever),
    *(linear_stage, stiffened_stage, exact_stage, stretching_stage, blade, coiled),
    *(doors, on_ropes, on_bushings, geared, followed, in_a_trough),
)


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.__name__)
@pytest.mark.parametrize("of", OTHERS, ids=["mm, t", "um", "a million times as small"])
def test_the_equilibrium_is_the_same_in_other_units(scene: Callable[[Units], kf.Equilibrium], of: Units) -> None:
    assert_same_as_in_si(scene, of)
