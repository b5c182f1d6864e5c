"""A runner that is pressed onto a beam as it crosses it, guided by a stiffness."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.verification import Case, Check, Reference
from kanefe.checks.verification.tolerance import scaled
from kanefe.fe_model.interface import Interface
from kanefe.frames import Vector
from kanefe.joints import Motion, Translation
from kanefe.loads import Guide
from kanefe.reduction import CraigBampton
from kanefe.result import Result
from kanefe.system import System
from kanefe_fem.beams.body import beam_body, straight_beam
from kanefe_fem.beams.sections import Section

ELEMENTS, MODES = 24, 20
"""Number of elements and of modes of the beam: with 10 modes errors are 1.3e-4 to 2.6e-4 of the largest sag, with 20
they are those of the time steps."""

TERMS = 60
"""Number of terms of the series, which fall with its fourth power."""

PLACES = 50
"""Number of times at which sags are compared."""

RTOL = 1e-7
"""Tolerance of the runs, relative: it leaves 0.3e-4 to 0.5e-4 of the largest sag; 1e-6 leaves 0.6e-4 to 2.4e-4, by the
round-off of the machine."""


def moving_force(reference: Reference) -> Iterator[Check]:
    """C07: the light runner leaves the beam by P / k, and the beam sags as under the force."""
    values = reference.values
    times = np.linspace(0.0, values["end"] * values["L"] / values["speed"], PLACES + 1)
    under, middle = (sags(values, times, at) for at in (values["speed"] * times, np.full(PLACES + 1, values["L"] / 2)))
    most = values["close"] * float(np.abs(middle).max())
    beam = simply_supported(values)
    for stiffness in values["stiffnesses"]:
        result = crossing(beam, values, stiffness)
        found = result.nodal_positions("beam")[:, ELEMENTS // 2, 1]
        yield Check.absolute(f"sag of the middle, k = {stiffness:g} N/m [m]", found, middle, most)
        place, wanted = result.position("runner")[:, 1], under - values["force"] / stiffness
        yield Check.absolute(f"place of the runner, k = {stiffness:g} N/m [m]", place, wanted, most)


def sags(values: dict[str, float], times: Vector, places: Vector) -> Vector:
    """Return the deflection at a place at each time, upwards, m: modes of a simply supported beam (Fryba)."""
    L, rho_A, force = values["L"], values["rho_A"], values["force"]
    n = np.arange(1, TERMS + 1)
    natural, forcing = (n * math.pi / L) ** 2 * math.sqrt(values["EI"] / rho_A), n * math.pi * values["speed"] / L
    phases, free = np.multiply.outer(times, forcing), np.multiply.outer(times, natural)
    modes = (np.sin(phases) - forcing / natural * np.sin(free)) / (natural**2 - forcing**2)
    shapes = np.sin(np.multiply.outer(places, n * math.pi / L))
    return np.asarray(-2.0 * force / (rho_A * L) * (modes * shapes).sum(axis=1))


def simply_supported(values: dict[str, float]) -> FlexibleBody:
    """Return the beam; G is fixed to its left support."""
    section = Section.from_stiffness(EA=values["EA"], EI_z=values["EI"], rho_A=values["rho_A"])
    options = {"theory": "euler-bernoulli", "rotary_inertia": False, "planar": True}
    model = straight_beam(values["L"], section, None, elements=ELEMENTS, **options)  # type: ignore[arg-type]
    held = {"root": Interface(fixed=("x", "y")), "tip": Interface(fixed=("y",))}
    return beam_body(model, held, CraigBampton(modes=MODES))


def crossing(body: FlexibleBody, values: dict[str, float], stiffness: float) -> Result:
    """Return the run of a runner that is moved along the beam at a constant speed, critically damped across."""
    force, mass, end = values["force"], values["runner"], values["end"] * values["L"] / values["speed"]
    scene = System()
    beam = scene.add_flexible_body("beam", body)
    joint = Translation(position=(None, -force / stiffness, 0.0), motion=(Motion.steady(values["speed"]), None, None))
    runner = scene.add_point("runner", mass, joint=joint)
    scene.add_force(runner, (0.0, -force, 0.0))
    line = [beam.node(i) for i in range(ELEMENTS + 1)]
    scene.add(Guide("rail", (runner, *line), stiffness=stiffness, damping=2.0 * math.sqrt(stiffness * mass)))
    return scene.simulate((0.0, end), rtol=scaled(RTOL), method="radau5", output_step=end / PLACES)


CASES = (Case("C07", moving_force),)
