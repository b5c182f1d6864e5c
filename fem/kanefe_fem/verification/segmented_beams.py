"""Beams that are cut into segments."""

from __future__ import annotations

from collections.abc import Iterator

from kanefe.checks.verification import Case, Check, Reference
from kanefe.linear.equilibrium.equilibria import equilibrium
from kanefe.reduction.stiffening import StiffeningLevel
from kanefe.system import System
from kanefe_fem.segments.segmented import segmented
from kanefe_fem.verification.stiffened_beams import thin_beam

LOADS = {"1": (8, 1e-4), "2": (16, 1e-3), "5": (16, 1e-3)}
"""Number of segments and tolerance by P L^2 / EI: errors decrease with the third power of the number."""


def tip_of_elastica(load: float, segments: int, stiffening: StiffeningLevel) -> list[float]:
    """Return angle, y and x of the tip of a cantilever with EI = L = 1 under a dead load (N) across it."""
    scene = System()
    chain = segmented(
        thin_beam(2 * segments), {"root": "clamped", "tip": "rigid"}, segments=segments, stiffening=stiffening
    )
    scene.add_force(scene.add_segmented_body("beam", chain).interface("tip"), (0.0, load, 0.0))
    x, y, _, _, _, angle = equilibrium(scene).deflection("beam", "tip")
    return [angle, y, 1.0 + x]


def elastica(reference: Reference) -> Iterator[Check]:
    """G05: a cantilever cut into linear bodies, each stiffened by the forces at its ends."""
    for load, (segments, tolerance) in LOADS.items():
        expected = [reference.values[load][key] for key in ("tip_angle", "deflection_over_L", "x_over_L")]
        quantity = f"angle, y and x of the tip at P L^2 / EI = {load}, {segments} segments"
        yield Check.absolute(quantity, tip_of_elastica(float(load), segments, "full"), expected, tolerance)


CASES = (Case("G05", elastica),)
