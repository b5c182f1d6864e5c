"""Joints, loads, laws of contact and constraints in other units: those of other rests, beside `test_units.py`."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

import kanefe as kf
from kanefe import shapes
from kanefe_fem import Material, Rectangle, beam_body, straight_beam
from other_units import DOWN, OTHERS, Units, assert_same_as_in_si

pytestmark = pytest.mark.filterwarnings("ignore::kanefe.errors.UnitWarning")


def floor(scene: kf.System) -> kf.Surface:
    return scene.add_surface("floor", scene.ground, shapes.Plane("z"))


def in_the_plane(of: Units) -> kf.Equilibrium:
    scene = of.system(0.0, -9.81, 0.0)
    across, turning = (kf.CoordinateForce(stiffness=k, damping=2.0 * k) for k in (300.0 * of.kg, 5.0 * of.inertia))
    of.body(scene, "plate", 2.0, 0.1, (0.3, 0.1, 0), joint=kf.Planar(forces=(across, across, turning)))
    return kf.equilibrium(scene)


def with_a_given_height(of: Units) -> kf.Equilibrium:
    scene = of.system(2.0, 0.0, -9.81)
    spring = kf.CoordinateForce(stiffness=40.0 * of.kg, rest=0.2 * of.m)
    given = (None, None, kf.Motion.steady(0.0, 0.5 * of.m))
    joint = kf.Translation(motion=given, forces=(spring, spring, None))
    carriage = scene.add_frame("carriage", joint=joint)
    of.body(scene, "bob", 1.0, 0.02, (0, 0, -0.4), parent=carriage, joint=kf.Universal("x", "y", position=(0.1, 0.2)))
    return kf.equilibrium(scene)


def on_a_deck(of: Units) -> kf.Equilibrium:
    """A pose as a function of time carries a pendulum on a spring."""
    scene = of.system(*DOWN)
    still, place = np.zeros(3), np.array(of.at(0.2, 0.1, 0.5))
    motion = kf.PoseMotion(lambda t: place, lambda t: still, lambda t: still)
    deck = scene.add_frame("deck", joint=kf.Free(motion=motion))
    hinge = kf.Revolute("y", forces=kf.CoordinateForce(stiffness=8.0 * of.inertia))
    of.body(scene, "arm", 1.0, 0.1, (0.5, 0, 0), parent=deck, joint=hinge)
    return kf.equilibrium(scene)


def on_a_stop(of: Units, **stop: float) -> kf.Equilibrium:
    scene = of.system(*DOWN)
    law = kf.CoordinateForce(limits=(-0.1 * of.m, None), limit_stiffness=1e5 * of.kg, **stop)
    of.body(scene, "ball", 2.0, 0.0, (0, 0, 0), joint=kf.Prismatic("z", forces=law))
    return kf.equilibrium(scene)


def on_a_damped_stop(of: Units) -> kf.Equilibrium:
    return on_a_stop(of, limit_damping=30.0 * of.kg)


def on_a_stop_that_restitutes(of: Units) -> kf.Equilibrium:
    return on_a_stop(of, limit_restitution=0.5)


def on_an_oleo(of: Units) -> kf.Equilibrium:
    """A mass on a strut on a tyre, a spring that does not pull."""
    scene = of.system(*DOWN)
    body = scene.add_point("body", 600.0 * of.kg, joint=kf.Prismatic("z", position=1.0 * of.m))
    stop = kf.CoordinateForce(limits=(0.0, None), limit_stiffness=1e7 * of.kg)
    joint = kf.Prismatic("z", forces=stop)
    wheel = scene.add_point("wheel", 30.0 * of.kg, parent=body, at=of.at(0, 0, -1), joint=joint)
    gas = {"area": 3e-3 * of.m**2, "pressure": 8e5 * of.pascal, "volume": 8e-4 * of.m**3}
    oil = {"orifice": 6e3 * of.kg / of.m, "rebound": 1.5e4 * of.kg / of.m, "ambient": 101325.0 * of.pascal}
    scene.add(kf.Oleo("oleo", (body, wheel), **gas, **oil))
    scene.add_contact("tyre", wheel, floor(scene), normal=kf.KelvinVoigt(4e5 * of.kg, 100.0 * of.kg))
    return kf.equilibrium(scene)


def on_a_winch(of: Units) -> kf.Equilibrium:
    scene = of.system(*DOWN)
    spring = kf.CoordinateForce(stiffness=2e3 * of.kg, damping=60.0 * of.kg)
    block = scene.add_point("block", 20.0 * of.kg, at=of.at(0, 0, 2), joint=kf.Prismatic("z", forces=spring))
    cable = {"stiffness": 1e5 * of.kg, "damping": 400.0 * of.kg, "speed": 0.5 * of.m}
    scene.add(kf.Winch("winch", (scene.ground, block), tension=300.0 * of.newton, **cable))
    return kf.equilibrium(scene)


def on_bearings(of: Units) -> kf.Equilibrium:
    """A shaft that spins on two bearings with cross-coupling."""
    scene = of.system(*DOWN)
    spin = scene.add_frame("spin", joint=kf.Translation(forces=(kf.CoordinateForce(stiffness=1e6 * of.kg), None, None)))
    tilt = scene.add_frame("tilt", parent=spin, joint=kf.Universal("y", "z"))
    motion = kf.Motion.steady(100.0)
    shaft = of.body(scene, "shaft", 5.0, 0.05, (0.5, 0, 0), parent=tilt, joint=kf.Revolute("x", motion=motion))
    for name, x in (("left", 0.0), ("right", 1.0)):
        at = of.at(x, 0, 0)
        K = of.kg * np.array(((2e5, 3e4), (-1e4, 3e5)))
        ends = scene.ground.frame(at=at), shaft.frame(at=at)
        scene.add(kf.Bearing(name, ends, stiffness=K, damping=1e-3 * K))
    return kf.equilibrium(scene)


def on_bristles(of: Units) -> kf.Equilibrium:
    """A block that bristles hold on a slope."""
    scene = of.system(9.81 * np.sin(0.1), 0.0, -9.81 * np.cos(0.1))
    block = of.body(scene, "block", 1.0, 0.01, (0, 0, 0.1), joint=kf.Translation())
    friction = kf.LuGre(1e4 / of.m, 30.0 / of.m, 0.0, coulomb=0.4, static=0.5, stribeck_speed=1e-3 * of.m)
    law = kf.HuntCrossley(1e5 * of.kg, 0.3 / of.m)
    scene.add_contact("c", block, floor(scene), normal=law, friction=friction)
    return kf.equilibrium(scene)


def dropped(of: Units, normal: object) -> kf.Equilibrium:
    scene = of.system(*DOWN)
    tip = scene.add_point("tip", 2.0 * of.kg, joint=kf.Prismatic("z"))
    scene.add_contact("c", tip, floor(scene), normal=normal)
    return kf.equilibrium(scene)


def on_a_bump_stop(of: Units) -> kf.Equilibrium:
    return dropped(of, kf.BumpStop(of.at(0.01, 0.05), of.newton * np.array((10.0, 50.0)), 0.2, 1e-3 * of.m))


def on_a_table(of: Units) -> kf.Equilibrium:
    return dropped(of, kf.TableLaw(of.at(0.01, 0.02, 0.05), of.newton * np.array((5.0, 30.0, 90.0)), 0.2 / of.m))


def bar_on_a_rail(of: Units) -> kf.Equilibrium:
    """Two curved bodies that touch at one point."""
    scene = of.system(*DOWN)
    bar = of.body(scene, "bar", 3.0, 0.2, (0, 0, 0), joint=kf.Prismatic("z", position=0.16 * of.m))
    skin = scene.add_surface("skin", bar, shapes.Cylinder(0.05 * of.m, 2.0 * of.m, "x"))
    rail = scene.add_surface("rail", scene.ground, shapes.Capsule(0.1 * of.m, 2.0 * of.m, "y"))
    scene.add_contact("c", skin, rail, normal=kf.HuntCrossley(1e5 * of.kg))
    return kf.equilibrium(scene)


def hull_on_a_plane(of: Units) -> kf.Equilibrium:
    """A lopsided pyramid that lies on its four lowest corners: which of them friction holds would be chance."""
    scene = of.system(*DOWN)
    corners = of.m * np.array(((0, 0, 0), (1, 0, 0), (1, 0.8, 0), (0, 0.7, 0), (0.4, 0.3, 0.5)))
    slider = of.body(scene, "slider", 0.1, 0.01, (0, 0, 0), joint=kf.Prismatic("z", position=1e-3 * of.m))
    hull = of.body(scene, "hull", 3.0, 0.2, (0.4, 0.3, 0.1), parent=slider, joint=kf.Universal("x", "y"))
    skin = scene.add_surface("skin", hull, shapes.Convex(corners))
    scene.add_contact("c", skin, floor(scene), normal=kf.KelvinVoigt(1e4 * of.kg, 50.0 * of.kg))
    return kf.equilibrium(scene)


def motored(of: Units) -> kf.Equilibrium:
    scene = of.system(*DOWN)
    arm = of.body(scene, "arm", 2.0, 0.1, (0.5, 0, 0), joint=kf.Revolute("y", position=0.8))
    scene.add_motor(arm, -4.0 * of.inertia)
    return kf.equilibrium(scene)


def on_a_rod(of: Units) -> kf.Equilibrium:
    """A pendulum on a ball joint whose tip a rigid distance holds aside."""
    scene = of.system(*DOWN)
    bob = of.body(scene, "bob", 2.0, 0.05, (0, 0, -0.5), joint=kf.Spherical())
    stay = scene.ground.frame(at=of.at(0.5, 0.2, -1.0))
    scene.add_distance("stay", stay, bob.frame(at=of.at(0, 0, -1.0)), float(np.hypot(0.5, 0.2)) * of.m)
    return kf.equilibrium(scene)


def rack(of: Units) -> kf.Equilibrium:
    scene = of.system(*DOWN)
    spring = kf.CoordinateForce(stiffness=200.0 * of.kg)
    pinion = of.body(scene, "pinion", 1.0, 0.02, (0.05, 0, 0), joint=kf.Revolute("y"))
    bar = of.body(scene, "bar", 2.0, 0.1, (0, 0, 0), at=of.at(0, 0, -0.1), joint=kf.Prismatic("x", forces=spring))
    scene.add_rack("mesh", pinion, bar, 0.1 * of.m)
    return kf.equilibrium(scene)


@cache
def cantilever(of: Units) -> kf.FlexibleBody:
    steel = Material(E=210e9 * of.pascal, nu=0.3, rho=7850.0 * of.kg / of.m**3)
    beam = straight_beam(of.m, Rectangle(*of.at(0.02, 0.03)), steel, elements=8)
    return beam_body(beam, {"root": "clamped", "tip": "rigid"}, kf.CraigBampton(modes=6))


def blown(of: Units, follows: bool) -> kf.Equilibrium:
    """A beam under a load along its line, which stays as it is or turns with it."""
    scene = of.system(0.0, 0.0, 0.0)
    hinge = kf.Revolute("y", forces=kf.CoordinateForce(stiffness=800.0 * of.inertia))
    beam = scene.add_flexible_body("beam", cantilever(of), joint=hinge)
    scene.add_line_load(beam, "span", (0.0, 20.0 * of.newton / of.m, 60.0 * of.newton / of.m), follows=follows)
    return kf.equilibrium(scene)


def blown_from_one_side(of: Units) -> kf.Equilibrium:
    return blown(of, follows=False)


def blown_across(of: Units) -> kf.Equilibrium:
    return blown(of, follows=True)


def along_a_path(of: Units) -> kf.Equilibrium:
    """Behind a limit point: half a truss that has snapped through."""
    scene = of.system(0.0, 0.0, 0.0)
    node = scene.add_point("node", of.kg, at=of.at(1.0, 0.1, 0), joint=kf.Prismatic("y"))
    scene.add_spring("bar", scene.ground, node, stiffness=1e4 * of.kg)
    scene.add_force(node, (0.0, -1.0 * of.newton, 0.0))
    return kf.equilibrium_path(scene, to=4.0).at(1.0, 2)


def from_a_given_start(of: Units) -> kf.Equilibrium:
    scene = of.system(*DOWN)
    of.body(scene, "rod", 1.0, 1 / 12, (0, 0, 0.5), joint=kf.Revolute("y"))
    return kf.equilibrium(scene, start=np.array((2.0, 0.0)))


SCENES: tuple[Callable[[Units], kf.Equilibrium], ...] = (
    *(in_the_plane, with_a_given_height, on_a_deck, on_a_damped_stop, on_a_stop_that_restitutes),
    *(on_an_oleo, on_a_winch, on_bearings, on_bristles, on_a_bump_stop, on_a_table),
    *(bar_on_a_rail, hull_on_a_plane, motored, on_a_rod, rack),
    *(blown_from_one_side, blown_across, along_a_path, from_a_given_start),
)


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.__name__)
@pytest.mark.parametrize("of", OTHERS, ids=["mm, t", "um", "a million times as small"])
def test_the_equilibrium_is_the_same_in_other_units(scene: Callable[[Units], kf.Equilibrium], of: Units) -> None:
    assert_same_as_in_si(scene, of)
