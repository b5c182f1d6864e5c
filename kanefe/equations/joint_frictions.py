"""Dry friction along joint coordinates, as loads of a frozen scene."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

import numpy as np

from kanefe.bodies.marker import CoordinateMarker
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.joints.coordinate_force import CoordinateForce
from kanefe.kane.assemble import mass_matrix
from kanefe.kane.state import State
from kanefe.loads.base import Load
from kanefe.loads.coordinate_friction import CoordinateFriction
from kanefe.tree.model_data import BodyTerms, ModelData

STRETCHES = {"m": 1e-5, "rad": 1e-4}
"""Of an anchor's spring under the cap, where its stiffness is not given: by so much a joint moves before it slips."""

SHARE_OF_CRITICAL = 0.1

DAMPING_TIME = 1e-3
"""Damping over stiffness in scenes with unreduced bodies, where inertias along joints are not at hand, s."""


def joint_frictions(model: ModelData, loads: Sequence[Load], t: float) -> tuple[CoordinateFriction, ...]:
    """Return a load for each joint coordinate with dry friction, called "friction of <body>" and the coordinate's name.

    Of a joint with one coordinate the name is left out. Damping that is not given is a tenth of what is critical for
    the inertia along the coordinate at the start of the scene, at time t (s).

    Raises
    ------
    ModelError
        If another load has the name.
    """
    rubbing = [
        (number, i, law)
        for number, body in enumerate(model.bodies)
        for i, law in enumerate(body.joint.coordinate_forces)
        if law is not None and law.friction > 0.0
    ]
    if not rubbing:
        return ()
    inertias = None
    if not model.has_unreduced and any(law.friction_damping is None for _, _, law in rubbing):
        inertias = np.diag(mass_matrix(State(model, t, model.initial_coordinates, model.initial_speeds)))
    found = tuple(_friction(model.bodies[number], number, i, law, inertias) for number, i, law in rubbing)
    taken = {load.name for load in loads}
    for load in found:
        if load.name in taken:
            raise ModelError(f"a load is called {load.name!r}, as the friction in that joint is. Remedy: another name")
    return found


def _friction(
    body: BodyTerms, number: int, i: int, law: CoordinateForce, inertias: Vector | None
) -> CoordinateFriction:
    """Return the friction along a coordinate of a body's joint; `inertias` along all speeds."""
    names, unit = body.joint.coordinate_names, body.joint.units[i]
    subject = body.name if len(names) == 1 else f"{body.name} {names[i].partition(' [')[0]}"
    static = law.friction if law.static_friction is None else law.static_friction
    stiffness = static / STRETCHES[unit] if law.friction_stiffness is None else law.friction_stiffness
    damping = law.friction_damping
    if damping is None and inertias is not None:
        damping = SHARE_OF_CRITICAL * 2.0 * sqrt(stiffness * float(inertias[body.speeds[i]]))
    return CoordinateFriction(
        f"friction of {subject}",
        (CoordinateMarker.of(number, i, f"the {names[i].partition(' [')[0]} of {body.name!r}"),),
        coordinate=subject,
        unit=unit,
        sliding=law.friction,
        static=static,
        stiffness=stiffness,
        damping=damping or DAMPING_TIME * stiffness,
    )
