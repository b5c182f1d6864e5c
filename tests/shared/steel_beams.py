"""Beams of steel: one of 1 m by 20 x 30 mm, and a short stiff one on a hinge."""

from typing import Any

import kanefe as kf
from kanefe_fem.beams.body import beam_body, straight_beam
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.materials.isotropic import Material

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
BAR_LENGTH = 0.3


def steel_beam(elements: int = 20, **options: Any) -> kf.FiniteElementModel:
    """Return the beam of 1 m; options of `straight_beam`."""
    return straight_beam(1.0, Rectangle(0.02, 0.03), STEEL, elements=elements, **options)


def steel_bar(width: float = 0.01, height: float = 0.02, *, gravity: float = 9.81, **options: Any) -> kf.System:
    """Return a bar of 0.3 m with modes up to some 100 kHz, level on a hinge in gravity; options of `beam_body`."""
    model = straight_beam(BAR_LENGTH, Rectangle(width, height), STEEL, elements=10)
    scene = kf.System(gravity=(0.0, 0.0, -gravity))
    scene.add_flexible_body("bar", beam_body(model, {"root": "clamped"}, **options), joint=kf.Revolute("y"))
    return scene
