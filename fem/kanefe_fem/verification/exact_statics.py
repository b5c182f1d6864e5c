"""Exact beams at rest under loads, turned as a whole, and stretched by their spin."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np

from kanefe.bodies.exact.beam import ExactBeam
from kanefe.bodies.exact.build import STRAINS
from kanefe.checks.verification import Case, Check, Reference
from kanefe.checks.verification.scenes import whole_run
from kanefe.errors import SimulationWarning
from kanefe.frames import axis_rotation, rotation_about
from kanefe.joints import Fixed, Free, Motion, Revolute
from kanefe.linear.equilibrium.equilibria import equilibrium
from kanefe.linear.equilibrium.rest import Equilibrium
from kanefe.linear.paths.equilibrium_path import equilibrium_path
from kanefe.linear.paths.path_of_equilibria import EquilibriumPath
from kanefe.system import System
from kanefe_fem.beams.beam_section import BeamSection
from kanefe_fem.beams.exact import exact_beam
from kanefe_fem.beams.sections import Section

CLOSE = 1e-8
"""Largest error of the tip over the length, with 24 coordinates of bending and twist, or 12 in a plane."""

BENDING = 8
"""Number of functions of twist and of each curvature."""

STRETCH = 6
"""Number of functions of stretch and of each shear, which are small beside bending."""

BASIS = {
    **dict.fromkeys(("twist", "curvature_y", "curvature_z"), BENDING),
    **dict.fromkeys(("stretch", "shear_y", "shear_z"), STRETCH),
}

TURN = dict.fromkeys(("twist", "curvature_y", "curvature_z"), 14)
"""Numbers of functions of twist and of each curvature of a beam that coils by a whole turn."""

PLANAR = 12


def stiff_section(values: dict[str, float]) -> BeamSection:
    """Return a section of a reference's EA, GA, GJ, EI_y and EI_z, with 1 kg/m."""
    EA, GA, GJ, EI_y, EI_z = (values[name] for name in ("EA", "GA", "GJ", "EI_y", "EI_z"))
    return Section.from_stiffness(EA=EA, GA_y=GA, GA_z=GA, GJ=GJ, EI_y=EI_y, EI_z=EI_z, rho_A=1.0)


def under_loads(beam: ExactBeam, force: Any = (0.0, 0.0, 0.0), torque: Any = (0.0, 0.0, 0.0)) -> Equilibrium:
    """Return a beam clamped at its root under a dead force (N) and a dead torque (N m) at its tip."""
    scene = System()
    tip = scene.add_flexible_body("beam", beam).interface("tip")
    scene.add_force(tip, force)
    scene.add_torque(tip, torque)
    return equilibrium(scene)


def tip_axes(rest: Equilibrium) -> np.ndarray:
    """Return the axes of the tip."""
    return np.asarray(rest.model.kinematics("beam", rest.time, rest.state, "tip").rotation)


def elastica(reference: Reference) -> Iterator[Check]:
    """G05: one planar exact beam, for all loads."""
    section = Section.from_stiffness(EA=1.0, EI_z=1.0, rho_A=1.0)
    beam = exact_beam(1.0, section, planar=True, basis=PLANAR)
    for load, expected in reference.values.items():
        rest = under_loads(beam, force=(0.0, float(load), 0.0))
        A, (x, y, _) = tip_axes(rest), rest.position("beam", "tip")
        found = [math.atan2(A[1, 0], A[0, 0]), y, x]
        wanted = [expected[key] for key in ("tip_angle", "deflection_over_L", "x_over_L")]
        quantity = f"angle, y and x of the tip at P L^2 / EI = {load}, exact beam of {PLANAR} coordinates"
        yield Check.absolute(quantity, found, wanted, CLOSE)


def princeton(reference: Reference) -> Iterator[Check]:
    """G03a: soft and stiff directions are coupled through twist."""
    length, width, height, E, nu = 0.508, 12.377e-3, 3.2024e-3, 71.7e9, 0.31
    area, inertia = width * height, width * height / 12.0
    section = stiff_section(
        {
            "EA": E * area,
            "GA": 5.0 / 6.0 * E / (2.0 * (1.0 + nu)) * area,
            "GJ": 3.103,
            "EI_y": E * inertia * height**2,
            "EI_z": E * inertia * width**2,
        }
    )
    beam = exact_beam(length, section, theory="shear-deformable", basis=BASIS)
    places, wanted, twists, wanted_twists = [], [], [], []
    for name, (*expected, twist, other_twist) in reference.values.items():
        load, angle = (float(part.split("=")[1]) for part in name.split(","))
        angle = math.radians(angle)
        rest = under_loads(beam, force=(0.0, load * math.cos(angle), load * math.sin(angle)))
        A = tip_axes(rest)
        places.append((rest.position("beam", "tip") - (length, 0.0, 0.0)) / length)
        wanted.append(np.array(expected) / length)
        twists.append([math.atan2(A[2, 1] - A[1, 2], A[1, 1] + A[2, 2]), math.atan2(A[2, 1], A[1, 1])])
        wanted_twists.append(np.radians([twist, other_twist]))
    label = f"{len(places)} loads, 24 coordinates of bending and twist"
    yield Check.absolute(f"displacement of the tip over the length, {label}", places, wanted, CLOSE)
    yield Check.absolute(f"twist of the tip by two measures, {label} [rad]", twists, wanted_twists, CLOSE)


def bend(reference: Reference) -> Iterator[Check]:
    """G06: an eighth of a circle, loaded out of its plane, with and without shear."""
    for part in reference.values:
        rigid = part["theory"] == "shear-rigid"
        length = part["R"] * math.pi / 4.0
        basis = dict.fromkeys(("twist", "curvature_y", "curvature_z"), BENDING) if rigid else BASIS
        curved = (0.0, 0.0, 1.0 / part["R"])
        beam = exact_beam(length, stiff_section(part), theory=part["theory"], basis=basis, curvature=curved)
        found = under_loads(beam, force=(0.0, 0.0, part["load"])).position("beam", "tip")
        quantity = f"place of the tip over the length, load {part['load']:g}, GJ = {part['GJ']:g}, {part['theory']}"
        yield Check.absolute(quantity, found / length, np.array(part["tip"]) / length, CLOSE)


def composite(reference: Reference) -> Iterator[Check]:
    """G13 and G14: a section that couples twist and bending, and one that turns along the beam."""
    values = reference.values
    length, turns = values["L"], (values["twist"] / values["L"], 0.0, 0.0)
    section = Section.from_stiffness(stiffness=values["stiffness"], rho_A=1.0)
    beam = exact_beam(length, section, theory="shear-deformable", basis=BASIS, curvature=turns)
    rest = under_loads(beam, force=(0.0, 0.0, values["force"]))
    found = (rest.position("beam", "tip") - (length, 0.0, 0.0)) / length
    quantity = "displacement of the tip over the length, 24 coordinates of bending and twist"
    yield Check.absolute(quantity, found, np.array(values["displacement"]) / length, CLOSE)


def helix(reference: Reference) -> Iterator[Check]:
    """G07: a straight beam that is coiled by a couple and pulled along its axis, by half a turn and by a whole one."""
    values = reference.values
    # an interface in the middle halves the steps from section to section, whose error is the larger one here (2e-8)
    places = {"middle": 0.5 * values["L"], "tip": values["L"]}
    for share, name, count, basis, close in (
        (1.0, "tip", 24, BASIS, CLOSE),
        (2.0, "tip_under_twice", 42, {**BASIS, **TURN}, 10.0 * CLOSE),
    ):
        beam = exact_beam(values["L"], stiff_section(values), theory="shear-deformable", basis=basis, interfaces=places)
        found = under_loads(beam, (0.0, 0.0, share * values["force"]), (0.0, 0.0, share * values["moment"]))
        loads = "" if share == 1.0 else "twice the loads, "
        quantity = f"place of the tip over the length, {loads}{count} coordinates of bending and twist"
        place = found.position("beam", "tip") / values["L"]
        yield Check.absolute(quantity, place, np.array(values[name]) / values["L"], close)


def roll_up(reference: Reference) -> Iterator[Check]:
    """G08: a couple at the tip makes circles, up to two turns."""
    section = Section.from_stiffness(EA=1.0, EI_z=1.0, rho_A=1.0)
    beam = exact_beam(1.0, section, planar=True, basis=PLANAR)
    found, expected = [], []
    for turns in reference.values["turns"]:
        angle = 2.0 * math.pi * turns
        rest = under_loads(beam, torque=(0.0, 0.0, angle))
        found.append(rest.position("beam", "tip")[:2])
        expected.append([math.sin(angle) / angle, (1.0 - math.cos(angle)) / angle])
    quantity = f"x and y of the tip over the length, up to {max(reference.values['turns'])} turns, {PLANAR} coordinates"
    yield Check.absolute(quantity, found, expected, CLOSE)


def path_past_limit(scene: System, load: float, points: int) -> EquilibriumPath:
    """Return the equilibria under a load (N) raised over its limit; they end some way behind that."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "equilibrium_path: the path ended after", SimulationWarning)
        return equilibrium_path(scene, to=1.05 * load, longest=0.2, points=points)


def lees_frame(reference: Reference) -> Iterator[Check]:
    """G12: two legs, hinged at both ends, snap through; pieces are joined at the corner and at the load."""
    values = reference.values
    leg, at = values["L"], values["load_at"]
    E, area = values["E"], values["A"]
    GA = 5.0 / 6.0 * E / (2.0 + 2.0 * values["nu"]) * area
    section = Section.from_stiffness(EA=E * area, GA_y=GA, EI_z=E * values["I"], rho_A=1.0)
    for theory, limit in values["limit"].items():
        column, short, long = (
            exact_beam(length, section, theory=theory, planar=True, basis=BENDING) for length in (leg, at, leg - at)
        )
        scene, up, down = System(), rotation_about("z", 0.5 * math.pi), rotation_about("z", -0.5 * math.pi)
        first = scene.add_flexible_body("column", column, joint=Revolute("z"), orientation=up)
        second = scene.add_flexible_body("short", short, parent=first.interface("tip"), orientation=down)
        third = scene.add_flexible_body("long", long, parent=second.interface("tip"))
        scene.add_loop_joint("pin", Revolute("z"), scene.ground.frame(at=(leg, leg, 0.0)), third.interface("tip"))
        scene.add_force(second.interface("tip"), (0.0, -1.0, 0.0))
        path = path_past_limit(scene, limit["load"], points=26)
        (found,) = path.limit_points
        quantity = f"limit load over the reference, 24 coordinates of bending, {theory}"
        yield Check.absolute(quantity, found.factor / limit["load"], 1.0, values["close"])
        sag = leg - path.point(found.number).position("short", "tip")[1]
        # the load is flat there: its digits leave the root of them for the place
        yield Check.absolute(f"sag there over the length, {theory}", sag / leg, limit["sag"] / leg, 1e-4)


def arch(reference: Reference) -> Iterator[Check]:
    """G15: a deep arch, of two halves joined at the crown, gives way to the side of its hinge."""
    values = reference.values
    radius, angle = values["R"], math.radians(0.5 * values["degrees"])
    section = Section.from_stiffness(EA=1.0, EI_z=values["EI"], rho_A=1.0)
    half = exact_beam(radius * angle, section, planar=True, basis=2 * BENDING, curvature=(0.0, 0.0, -1.0 / radius))
    scene, foot = System(), radius * np.array((math.sin(angle), math.cos(angle), 0.0))
    at, up = foot * (-1.0, 1.0, 1.0), rotation_about("z", angle)
    left = scene.add_flexible_body("left", half, joint=Fixed(), at=at, orientation=up)
    crown = left.interface("tip")
    right = scene.add_flexible_body("right", half, parent=crown, orientation=half.section_orientation("tip"))
    scene.add_loop_joint("pin", Revolute("z"), scene.ground.frame(at=foot), right.interface("tip"))
    scene.add_force(crown, (0.0, -1.0, 0.0))
    found = path_past_limit(scene, values["load"], points=40).limit_points[0]  # others lie behind it
    quantity = f"limit load over the reference, {2 * half.free_count} coordinates"
    yield Check.absolute(quantity, found.factor / values["load"], 1.0, values["close"])


def spinning_bar(reference: Reference) -> Iterator[Check]:
    """G09: the stretch of a bar that spins about its end, which grows beyond all bounds at k = pi/2."""
    values = reference.values
    section = Section.from_stiffness(EA=1.0, EI_z=1.0, rho_A=1.0)
    beam = exact_beam(1.0, section, theory="stretching", planar=True, basis={"stretch": PLANAR, "curvature_z": 1})
    for k in values["k"]:
        scene = System()
        scene.add_flexible_body("beam", beam, joint=Revolute("z", motion=Motion.steady(k)))
        x, y, _ = equilibrium(scene).position("beam", "tip")
        quantity = f"stretch over the length at k = {k:g}, {PLANAR} coordinates"
        yield Check.absolute(quantity, math.hypot(x, y) - 1.0, math.tan(k) / k - 1.0, CLOSE)


def rigid_motion(reference: Reference) -> Iterator[Check]:
    """G11: two couples about the soft axis hold a beam bent to a circle, its first function, turned and in flight."""
    values = reference.values
    section = stiff_section(values["section"])
    beam = exact_beam(1.0, section, theory="shear-deformable", basis=BASIS)
    couple = np.array((0.0, values["couple"], 0.0))
    bent = np.zeros(beam.free_count)
    bent[np.flatnonzero(beam.line.strain_of == STRAINS.index("curvature_y"))[0]] = couple[1] / values["section"]["EI_y"]
    turn = axis_rotation(np.array((1.0, 2.0, -2.0)) / 3.0, values["turn"])
    scene = System()
    joint = Free(position=(0.3, -0.2, 0.1), orientation=turn, velocity=values["velocity"])
    # a tight tolerance: steps at the limit of stability are controlled by it alone
    flying = scene.add_flexible_body("beam", beam, joint=joint, modal_coordinates=bent.tolist())
    scene.add_torque(flying.interface("tip"), turn @ couple)
    scene.add_torque(flying.interface("root"), -turn @ couple)
    model = scene.freeze()
    run = whole_run(model, (0.0, values["end"]), 1e-12, method="dop853", output_step=values["end"] / 10)
    eta = run.coordinates[:, model.flexible_terms("beam").eta]
    yield Check.absolute("change of the strains", eta, np.tile(bent, (len(eta), 1)), 1e-12)


CASES = (
    Case("G03a", princeton),
    Case("G05", elastica),
    Case("G06", bend),
    Case("G07", helix),
    Case("G08", roll_up),
    Case("G09", spinning_bar),
    Case("G11", rigid_motion),
    Case("G12", lees_frame),
    Case("G13", composite),
    Case("G14", composite),
    Case("G15", arch),
)
