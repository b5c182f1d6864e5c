"""Damping ratios of flexible bodies alone, which are not those of the scene that has them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy.linalg

from kanefe.bodies.flexible import FlexibleBody
from kanefe.frames import Vector

if TYPE_CHECKING:
    from kanefe.equations.model import Model


def alone_in_words(model: Model) -> list[str]:
    """Return a line with the damping of each flexible body alone, or none without damped bodies."""
    found = []
    for body in model.bodies:
        own = None if body.flexible is None else body.flexible.body
        if type(own) is FlexibleBody and np.any(own.damping):
            ratios = 100.0 * ratios_alone(own)
            least, most = f"{ratios.min():.3g}", f"{ratios.max():.3g}"
            found.append(f"{body.name} {least if least == most else f'{least} to {most}'} %")
    return [f"damping of bodies alone, with fixed interfaces held: {', '.join(found)}"] if found else []


def ratios_alone(body: FlexibleBody) -> Vector:
    """Return the damping ratios of the modes of a body with its fixed interfaces held, lowest first."""
    k = body.free_count
    squares, shapes = scipy.linalg.eigh(body.stiffness[:k, :k], body.moments.elastic_mass[:k, :k])
    damping = np.einsum("ik,ij,jk->k", shapes, body.damping, shapes)
    omegas = np.sqrt(np.maximum(squares, 0.0))
    return np.divide(damping, 2.0 * omegas, out=np.zeros(k), where=omegas > 0.0)
