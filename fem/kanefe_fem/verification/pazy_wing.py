"""The Pazy wing of the Technion under weights, without its skin: measured, and computed by UM/NAST on the same data.

Axes of the data: x aft, y along the span, z up; here x along the span, y forward, z up.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from kanefe.bodies.exact.beam import ExactBeam
from kanefe.checks.verification import Case, Check, Reference
from kanefe.frames import rotation_matrix
from kanefe.linear.equilibrium.equilibria import equilibrium
from kanefe.linear.equilibrium.rest import Equilibrium
from kanefe.system import System
from kanefe_fem.beams.beam_section import BeamSection
from kanefe_fem.beams.exact import exact_beam
from kanefe_fem.beams.sections import Section
from kanefe_fem.verification.experiments import STANDARD_GRAVITY

LINE_MASS, LINE_INERTIA = 1e-4, 1e-8
"""Mass of the beam itself, kg/m, and moment of inertia of its sections, kg m: the data have lumped masses alone, of
0.6 kg/m, and a beam has some mass of its own."""

RIGID = 1e7
"""Stiffness against shear, which the data do not have and the beam does not use, N."""

DATA_TO_BODY = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""Rotation matrix from the axes of the data to those of the body."""


def wing_beam(values: Mapping[str, Any]) -> ExactBeam:
    """Return the beam between the lumped masses, with a stiffness that is constant between two of them."""
    places, sections = np.array(values["places"]), []
    for row in values["stiffness"]:
        coupled = np.zeros((4, 4))
        coupled[np.triu_indices(4)] = row
        K = np.diag([0.0, RIGID, RIGID, 0.0, 0.0, 0.0])
        K[np.ix_([0, 3, 4, 5], [0, 3, 4, 5])] = coupled + np.triu(coupled, 1).T
        sections.append(Section.from_stiffness(stiffness=K, rho_A=LINE_MASS, rho_I=LINE_INERTIA))

    def section(s: float) -> BeamSection:
        return sections[min(max(int(np.searchsorted(places, s, side="right")) - 1, 0), len(sections) - 1)]

    names = {f"n{i}": float(place) for i, place in enumerate(places)}
    return exact_beam(float(places[-1]), section, theory="stretching", basis=8, interfaces=names)


def wing(values: Mapping[str, Any], beam: ExactBeam, weight: float = 0.0, aft: float = 0.0) -> System:
    """Return the wing under its weight and one (kg) that hangs at the tip, some distance (m) behind the axis."""
    scene = System(gravity=(0, 0, -STANDARD_GRAVITY))
    member = scene.add_flexible_body("wing", beam)
    for i, (mass, *numbers) in enumerate(values["masses"]):
        (xx, yy, zz, xy, xz, yz), centre = numbers[3:], numbers[:3]
        inertia = np.array([[xx, -xy, -xz], [-xy, yy, -yz], [-xz, -yz, zz]])
        turned = DATA_TO_BODY @ inertia @ DATA_TO_BODY.T
        place = DATA_TO_BODY @ np.array(centre)
        scene.add_rigid_body(f"m{i}", mass, turned, parent=member.interface(f"n{i}"), com=place.tolist())
    tip = f"n{len(values['masses']) - 1}"
    scene.add_force(member.interface(tip), (0, 0, -STANDARD_GRAVITY * weight), point=(0, -aft, 0))
    return scene


def tip_of(values: Mapping[str, Any], rest: Equilibrium) -> np.ndarray:
    """Return the height of the middle of the chord at the tip (m) and the twist there (rad)."""
    tip = f"n{len(values['masses']) - 1}"
    across = rotation_matrix(np.ravel(rest.rotation("wing", tip)))[:, 1]
    place = np.ravel(rest.position("wing", tip)) + (values["axis"] - 0.5 * values["chord"]) * across
    return np.array((place[2], math.atan2(across[2], across[1])))


def weights_on_wing(reference: Reference) -> Iterator[Check]:
    """X4: displacement and twist from the state under the own weight, and frequencies there."""
    values = reference.values
    beam = wing_beam(values)
    rest = equilibrium(wing(values, beam))
    start = tip_of(values, rest)
    for name, test in values["tests"].items():
        rows = np.array(test["rows"], dtype=float)
        moved = (
            np.array([tip_of(values, equilibrium(wing(values, beam, kg, test["aft"]))) for kg in rows[:, 0]]) - start
        )
        down, largest = -100.0 * moved[:, 0] / values["places"][-1], rows[:, 1].max()
        label = f"{name}: displacement of the tip over the largest measured one"
        yield Check.absolute(f"{label}, measured", down / largest, rows[:, 1] / largest, 0.08)
        yield Check.absolute(f"{label}, UM/NAST", down / largest, rows[:, 2] / largest, 1e-3)
        if rows.shape[1] > 3:
            twist, most = np.degrees(moved[:, 1]), rows[:, 3].max()
            label = f"{name}: twist of the tip over the largest measured one"
            yield Check.absolute(f"{label}, measured", twist / most, rows[:, 3] / most, 0.08)
    found = rest.linearise().modes().frequencies[: len(values["frequencies"])]
    yield Check.relative("frequencies under its weight [Hz]", found, values["frequencies"], 0.045)


CASES = (Case("X4", weights_on_wing),)
