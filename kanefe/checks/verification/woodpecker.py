"""The woodpecker toy: a bird on a spring whose sleeve jams, slides and is struck on a pole, again and again."""

from __future__ import annotations

from collections.abc import Iterator

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.checks.verification.contact import GRAVITY, run_of
from kanefe.contact import Coulomb, Rigid
from kanefe.contact.shapes import Plane
from kanefe.joints import CoordinateForce, Motion, Prismatic, Revolute, Translation
from kanefe.system import System

SLEEVE, SLEEVE_INERTIA, BIRD, BIRD_INERTIA, SPRING = 3e-4, 5e-9, 4.5e-3, 7e-7, 5.6e-3
"""Masses (kg) and moments of inertia (kg m2) of sleeve and bird, and the stiffness of the spring (N m/rad)."""

POLE, HOLE, HALF_HEIGHT, TO_SPRING, TO_BIRD, BEAK_UP, BEAK_OUT = 2.5e-3, 3.1e-3, 5.8e-3, 0.010, 0.015, 0.020, 0.0201
"""Radii of pole and hole, half the height of the sleeve, and the ways from the pole to the spring, from there to the
bird's centre of mass, and to the beak, up and out, m."""

TINY = 1e-8
"""Mass of a point that only leads a contact, kg: it is taken from the parts that carry it."""


def toy() -> System:
    """Return it at the start of a cycle; its contacts are "beak", "low" and "high".

    Angles are small and all places linear in them, as in the source: gears lead bird and contact points along lines.
    """
    scene, still = System(gravity=(0.0, -GRAVITY, 0.0)), Motion.steady(0.0, 0.0)
    speed, lean, bird, spin = -0.3411, -(HOLE - POLE) / HALF_HEIGHT, -0.2788, -7.4583
    sleeve = scene.add_point("sleeve", SLEEVE - 2.0 * TINY, joint=Prismatic("y", speed=speed))
    own = SLEEVE_INERTIA - TINY * (HALF_HEIGHT**2 + HOLE**2 + TO_SPRING**2)
    turn = scene.add_rigid_body("turn", 1e-3, (0.0, 0.0, own), joint=Revolute("z", position=lean), gravity=False)
    own = BIRD_INERTIA - TINY * (BEAK_UP**2 + (TO_BIRD - BEAK_OUT) ** 2)
    joint = Revolute("z", position=bird - lean, speed=spin, forces=CoordinateForce(stiffness=SPRING))
    nod = scene.add_rigid_body("nod", 1e-3, (0.0, 0.0, own), parent=turn, gravity=False, joint=joint)
    start, rate = TO_SPRING * lean + TO_BIRD * bird, speed + TO_BIRD * spin
    head = scene.add_point("bird", BIRD, joint=Prismatic("y", position=start, speed=rate))
    scene.add_gear("bird", {head: 1.0, sleeve: -1.0, turn: -TO_SPRING - TO_BIRD, nod: -TO_BIRD})
    place = Translation(
        position=(HALF_HEIGHT * lean, HOLE * lean, None), velocity=(0.0, speed, None), motion=(None, None, still)
    )
    edge = scene.add_point("edge", TINY, joint=place)
    scene.add_gear("edge across", {(edge, 0): 1.0, turn: -HALF_HEIGHT})
    scene.add_gear("edge along", {(edge, 1): 1.0, sleeve: -1.0, turn: -HOLE})
    out = TO_BIRD - BEAK_OUT
    place = Translation(
        position=(-BEAK_UP * bird, TO_SPRING * lean + out * bird, None),
        velocity=(-BEAK_UP * spin, speed + out * spin, None),
        motion=(None, None, still),
    )
    beak = scene.add_point("beak", TINY, joint=place)
    scene.add_gear("beak across", {(beak, 0): 1.0, turn: BEAK_UP, nod: BEAK_UP})
    scene.add_gear("beak along", {(beak, 1): 1.0, sleeve: -1.0, turn: -TO_SPRING - out, nod: -out})
    off = TO_SPRING + TO_BIRD - BEAK_OUT - POLE
    for name, point, normal, at, restitution in (
        ("beak", beak, "x", -off, 0.5),
        ("low", edge, "x", POLE - HOLE, 0.0),
        ("high", edge, "-x", HOLE - POLE, 0.0),
    ):
        pole = scene.add_surface(f"pole {name}", scene.ground, Plane(normal), at=(at, 0.0, 0.0))
        scene.add_contact(name, point, pole, normal=Rigid(restitution, "newton"), friction=Coulomb(0.3))
    return scene


def woodpecker(reference: Reference) -> Iterator[Check]:
    """K26: impacts of the beak, and the cycle to which it comes."""
    values = reference.values
    beak = run_of(toy(), 2.4, 1e-8, output_step=0.1).events["beak touch"]
    yield Check.absolute("first impacts of the beak [s]", beak[:3], values["impacts"], 5e-6)
    # it comes to its cycle in turns, longer and shorter
    yield Check.absolute("mean period of the last four cycles [s]", (beak[-1] - beak[-5]) / 4.0, values["period"], 1e-5)
    height = run_of(toy(), 2.4, 1e-8, output_times=beak[[-5, -1]]).position("sleeve")[:, 1]
    yield Check.absolute("mean descent in a cycle [m]", (height[0] - height[1]) / 4.0, values["descent"], 1e-5)


CASES = (Case("K26", woodpecker),)
