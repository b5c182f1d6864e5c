"""Scenes of many rigid contacts, whose impacts are too many to end a step at each."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from kanefe.equations.model import Model
from kanefe.tree.scales import scene_length

if TYPE_CHECKING:
    from kanefe.contact.rigid.granular_contacts import GranularContacts

LEAST_MOTION, FEWEST_STEPS = 0.02, 500.0
"""Motion of a falling body in a step over impacts, relative to the radius of the smallest ball; and least number of
steps of a run."""


def many_impacts(model: Model, granular: GranularContacts, span: float) -> tuple[str, float]:
    """Return why impacts of a scene of many rigid contacts are stepped over, and by which step, s."""
    length = scene_length(model)
    speed = max(
        math.sqrt(2.0 * float(np.linalg.norm(model.gravity)) * length),
        *(float(np.abs(body.joint.initial_speeds()[:3]).max()) for body in model.bodies if len(body.speeds) > 2),
    )
    radius = min(ball.radius for ball in granular.balls) or 0.1 * length
    step = min(span / FEWEST_STEPS, LEAST_MOTION * radius / speed if speed > 0.0 else span)
    pairs = len(granular.balls) * (len(granular.balls) - 1) // 2 + len(granular.balls) * len(granular.walls)
    return f"{pairs} pairs of rigid surfaces may collide too often to end a step each time", step
