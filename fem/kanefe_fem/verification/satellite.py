"""A satellite with panels from a mesh (B10): a free hub with two plates, against beams in closed form."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.verification import Case, Check, Reference
from kanefe.checks.verification.scenes import system_modes, whole_run
from kanefe.joints import Planar
from kanefe.reduction import CraigBampton
from kanefe.result import Result
from kanefe.system import System
from kanefe_fem.beams.body import beam_body, straight_beam
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.simple import box_mesh
from kanefe_fem.solids.body import solid_body

LENGTH, WIDTH, THICKNESS = 1.0, 0.1, 0.01
"""Size of a panel, m. It bends in the x-y plane; its thickness is along y."""

BLANKET = Material(E=12e3 / (WIDTH * THICKNESS**3) * 1e-3, nu=0.0, rho=1.0 / (WIDTH * THICKNESS))
"""Material with EI = rho A = 1 in SI units; without lateral contraction the plate bends like a beam."""

TURN, IMPULSE_TIME = 0.05, 4.0
"""Amplitude of a full sine of the torque, N m, and its duration, s."""


def satellite_modes(reference: Reference) -> Iterator[Check]:
    """B10: frequencies of the free satellite, and a slew in comparison with a satellite with beams."""
    values = reference.values
    panel = mesh_panel()
    scene = satellite(panel, values)
    yield Check.relative("mass of a panel [kg]", panel.mass, 1.0, 1e-12)
    model = scene.freeze()
    frequencies, modes = system_modes(model)
    rigid = frequencies < 1e-3 * frequencies[3]
    yield Check.absolute("number of rigid modes", np.count_nonzero(rigid), 3, 0.0)
    share = np.abs(modes[model.bodies[0].speeds])  # hub: x, y, angle
    for row, kind in ((2, "rotates"), (1, "translates")):
        found = frequencies[~rigid & (share[row] > 1e3 * np.delete(share, row, axis=0).max(axis=0))][:4]
        yield Check.relative(f"omega 1-4, hub {kind}, panels of hexahedra [rad/s]", found, values[kind], 5e-3)
    beams = beam_body(
        straight_beam(LENGTH, Rectangle(THICKNESS, WIDTH), BLANKET, elements=20, planar=True),
        {"root": "clamped"},
        reduction=CraigBampton(modes=8),
    )
    angles, momenta = zip(*(slew(satellite(body, values)) for body in (panel, beams)), strict=True)
    yield Check.relative("turn of the hub in a slew, as with beams [rad]", angles[0], angles[1], 1e-4)
    # the integral of half a sine
    yield Check.relative("angular momentum half way [N m s]", momenta[0], TURN * IMPULSE_TIME / np.pi, 1e-6)


def mesh_panel() -> FlexibleBody:
    """Return a panel of 80 quadratic hexahedra, clamped at its root."""
    mesh = box_mesh((LENGTH, THICKNESS, WIDTH), (40, 1, 2), "hexahedron", start=(0.0, -THICKNESS / 2, -WIDTH / 2))
    return solid_body(mesh, BLANKET, {"root": "clamped"}, reduction=CraigBampton(modes=12))


def satellite(panel: FlexibleBody, values: dict[str, float]) -> System:
    """Return the free hub in the plane with two panels, and a torque on it."""
    scene = System()
    hub = scene.add_rigid_body("hub", values["hub_mass"], values["hub_inertia"], joint=Planar())
    scene.add_flexible_body("right", panel, parent=hub)
    scene.add_flexible_body("left", panel, parent=hub, orientation=(0.0, 0.0, 0.0, 1.0))
    scene.add_torque(hub, lambda t: (0.0, 0.0, TURN * np.sin(2 * np.pi * t / IMPULSE_TIME) * (t < IMPULSE_TIME)))
    return scene


def slew(scene: System) -> tuple[float, float]:
    """Return the angle of the hub when the torque ends, and the angular momentum half way."""
    model = scene.freeze()
    result = Result(model, whole_run(model, (0.0, IMPULSE_TIME), 1e-8, output_step=IMPULSE_TIME / 2))
    turn = result.rotation("hub")[-1]
    return float(2.0 * np.arctan2(turn[3], turn[0])), float(result.momentum.angular[1, 2])


CASES = (Case("B10", satellite_modes),)
