"""A probe under the fuselage in a trap on the deck, as in RAST and ASIST. All numbers are assumed."""

from __future__ import annotations

import math

from kanefe.contact import KelvinVoigt
from kanefe.contact.shapes import Cylinder
from kanefe.errors import ModelError
from kanefe.system import System
from kanefe_fem.sramss import parameters as given
from kanefe_fem.sramss.aircraft_loads import deck_of

GAP, HEIGHT, DEPTH = 0.025, 0.25, 0.6
"""Radial play, height of the probe's tip above the deck, and depth of the hole around it, m."""

STIFFNESS, DAMPING = 2e6, 1e4
"""Stiffness (N/m) and damping (N s/m) of the trap."""


def add_probe(
    scene: System,
    *,
    gap: float = GAP,
    at: tuple[float, float] = (0.0, 0.0),
    stiffness: float = STIFFNESS,
    damping: float = DAMPING,
) -> str:
    """Add a probe under the middle of the airframe in a trap: a round hole that holds it in the plane of the deck.

    It is a frictionless contact "probe" between the tip of the probe and the surface "trap", with forces and events
    like any contact. The probe can slide up and down and rotate; `add_haul_down` holds it down. It does not break.

    Parameters
    ----------
    scene : System
        Scene of `spatial_scene`, with a body "airframe"; the deck is a body "deck" or the ground.
    gap : float
        Radial play between the probe and the trap, m.
    at : (float, float)
        x and y on the deck of the aircraft, as for the scene, m.
    stiffness, damping : float
        Stiffness and damping of the trap, N/m and N s/m.

    Returns
    -------
    str
        Name of the contact.

    Raises
    ------
    ModelError
        If the gap, the stiffness or the damping is out of range, or there is no airframe.

    Examples
    --------
    >>> scene = spatial_scene(gear, motion, mu=0.03)                # doctest: +SKIP
    >>> probe = add_probe(scene)                                    # doctest: +SKIP
    >>> scene.simulate((0.0, 20.0)).contact(probe).normal.max()     # doctest: +SKIP
    """
    if not (math.isfinite(gap) and gap > 0.0):
        raise ModelError(f"gap of a probe in its trap must be above zero m, not {gap!r}")
    hole = Cylinder(gap, DEPTH, axis="z", inside=True)  # the tip is a point, so the radius of the hole is the gap
    tip = scene.body("airframe").frame((0.0, 0.0, HEIGHT - given.CG_HEIGHT))
    trap = scene.add_surface("trap", deck_of(scene), hole, at=(*at, HEIGHT))
    scene.add_contact("probe", tip, trap, normal=KelvinVoigt(stiffness, damping=damping))
    return "probe"
