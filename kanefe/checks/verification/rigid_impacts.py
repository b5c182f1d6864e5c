"""Cases of impacts of rigid contacts: rods and pendulums that strike with friction, balls that touch."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator

import numpy as np

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.contact import Coulomb, HuntCrossley, Rigid
from kanefe.contact.shapes import Plane, Sphere
from kanefe.equations.model import Model
from kanefe.errors import SimulationWarning
from kanefe.frames import rotation_about
from kanefe.joints import Free, Prismatic, Revolute
from kanefe.system import System

ROD = 1.0 / 12.0, 1.0 / 12.0, 1e-4
"""Moments of inertia of a rod of 1 kg and 1 m, kg m2."""


def struck_rod(reference: Reference) -> Iterator[Check]:
    """K27: a rod whose lower end strikes a rough floor: impulses of pieces of slip, stick and reversed slip."""
    for row in reference.values["rows"]:
        angle = math.radians(row["degrees"])
        x, z = 0.5 * math.cos(angle), 0.5 * math.sin(angle)
        scene = System()
        floor = scene.add_surface("floor", scene.ground, Plane("z"))
        velocity = row["along"], 0.0, -row["down"]
        start = Free(position=(x, 0.0, z), orientation=rotation_about("y", -angle), velocity=velocity)
        rod = scene.add_rigid_body("rod", 1.0, (1e-4, 1.0 / 12.0, 1.0 / 12.0), joint=start)
        law = Rigid(row["e"])
        scene.add_contact("end", rod.frame(at=(-0.5, 0, 0)), floor, normal=law, friction=Coulomb(row["mu"]))
        model = scene.freeze()
        before, after = (model.parts(y)[1] for y in (model.initial_state, model.route.start(0.0)))
        found = np.array([(after - before)[i] for i in (2, 0)])
        what = (
            f"impulses on 1 kg of a rod at {row['degrees']} degrees, mu {row['mu']}, e {row['e']}, which {row['what']}"
        )
        yield Check.absolute(f"{what} [N s]", found, [row["normal"], row["friction"]], 1e-10)


def double_pendulum(scene_of: dict[str, float], impact: str) -> Model:
    """Return a double pendulum whose tip is on a rough floor and goes down."""
    a, b = math.radians(scene_of["upper"]), math.radians(scene_of["lower"])
    first, second = scene_of["upper_rate"], scene_of["lower_rate"]
    scene = System()
    floor = scene.add_surface("floor", scene.ground, Plane("z"))
    hinge, height = Revolute("y", position=a, speed=first), math.cos(a) + math.cos(b)
    upper = scene.add_rigid_body("upper", 1.0, ROD, com=(0, 0, -0.5), at=(0, 0, height), joint=hinge)
    hinge = Revolute("y", position=b - a, speed=second - first)
    lower = scene.add_rigid_body("lower", 1.0, ROD, com=(0, 0, -0.5), at=(0, 0, -1), parent=upper, joint=hinge)
    law = Rigid(scene_of["e"], impact)
    scene.add_contact("tip", lower.frame(at=(0, 0, -1)), floor, normal=law, friction=Coulomb(scene_of["mu"]))
    return scene.freeze()


def kane_levinson(reference: Reference) -> Iterator[Check]:
    """K28: a double pendulum that strikes a rough floor, to which Newton's law of restitution gives energy."""
    for row in reference.values["rows"]:
        for impact in ("stronge", "newton"):
            model = double_pendulum(row, impact)
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always")
                y = model.route.start(0.0)
            after, before = (model.energy(0.0, state).kinetic for state in (y, model.initial_state))
            what = f"rods at {row['upper']} and {row['lower']} degrees, impact={impact!r}"
            yield Check.absolute(f"energy left, of that before, {what}", after / before, row[impact], 1e-9)
            says = any(one.category is SimulationWarning and "made" in str(one.message) for one in told)
            yield Check.absolute(f"1 where energy made is told, {what}", float(says), float(row[impact] > 1.0), 1e-12)


def touching_balls(reference: Reference) -> Iterator[Check]:
    """K29: balls that touch and share an impact: those of Hertz."""
    for count in reference.values["counts"]:
        found = []
        for law in (Rigid(1.0, "distributing"), HuntCrossley(1e9, exponent=1.5)):
            scene, skins = System(), []
            for i in range(count):
                start = Prismatic("x", position=0.2 * (i - 1) if i else -0.3, speed=float(i == 0))
                ball = scene.add_rigid_body(f"ball {i}", 1.0, 0.004, joint=start)
                skins.append(scene.add_surface(f"skin {i}", ball, Sphere(0.1)))
            for i in range(count - 1):
                scene.add_contact(f"pair {i}", skins[i], skins[i + 1], normal=law)
            result = scene.simulate((0.0, 0.15), rtol=1e-8, output_times=(0.15,), progress=False)
            found.append([float(result.joint_speeds(f"ball {i}")[-1, 0]) for i in range(count)])
        yield Check.absolute(f"speeds of {count} balls [m/s]", found[0], found[1], 1e-3)


CASES = Case("K27", struck_rod), Case("K28", kane_levinson), Case("K29", touching_balls)
