"""Viscoelastic bodies: their arms, as loads of a frozen scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.bodies.marker import ModalMarker
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.tree.model_data import ModelData
from kanefe.tree.scales import displacement_scales
from kanefe.tree.scene_state import SceneState

if TYPE_CHECKING:
    from kanefe.loads.body_relaxation import BodyRelaxation


def body_relaxations(model: ModelData) -> tuple[BodyRelaxation, ...]:
    """Return a load for each viscoelastic body, called "relaxation of <body>".

    Raises
    ------
    ModelError
        If another load has the name.
    """
    found, taken = [], {load.name for load in model.loads}
    for number, body in enumerate(model.bodies):
        terms = body.flexible
        if terms is None or terms.body.relaxation is None:
            continue
        from kanefe.loads.body_relaxation import BodyRelaxation  # most scenes have none

        own, name = terms.body.relaxation, f"relaxation of {body.name}"
        if name in taken:
            raise ModelError(f"a load is called {name!r}, like that of the body's material. Remedy: another name")
        k, m = own.factors.shape
        ends = tuple(ModalMarker.of(number, i, f"eta {i} of {body.name!r}") for i in range(k))
        scales = np.abs(own.factors).T @ displacement_scales(model)[terms.speeds]
        scales = np.where(scales > 0.0, scales, 1.0)
        found.append(BodyRelaxation(name, ends, of=own, scales=scales, first=np.zeros(m)))
    return tuple(found)


def with_relaxed_bodies(model: ModelData, state: SceneState, z: Vector) -> Vector:
    """Return internal states in which the arms of all bodies have relaxed at a state, and the others as they are."""
    z = z.copy()
    for number, load in enumerate(model.loads):
        if load.kind == "relaxation":
            where = model.load_states[number]
            z[where] = load.rested(state.load_ends(number), z[where])
    return z
