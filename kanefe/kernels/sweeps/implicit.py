"""The linearly implicit sweep: ``(M + s C + r K) z = F + C a + K b`` in place of ``M du = F``.

C and K are the diagonals of the modes of unit mass, and springs, dampers and stops along joint coordinates,
each at the current state. In modes of unit mass the block of a body becomes ``d = 1 + s c + r k``; with the modes
scaled by the root of d it is the identity again, so that the elimination of the modes is that of the plain sweep.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.layout import (
    COUNT,
    DAMPING,
    DETA,
    EXACT,
    MODAL,
    POOL,
    POOL_STIFFNESS,
    TRANSFORM,
    WORK_FORCE,
    WORK_PRODUCTS,
    WORK_SCALE,
    FlexibleTables,
    Tables,
)
from kanefe.kernels.loads.coordinate_law import coordinate_slopes
from kanefe.kernels.planar.layout import PlanarTables
from kanefe.kernels.sweeps.elastic import coupling_span, span, transposed_product
from kanefe.kernels.sweeps.exact_beam_inertia import stiffen_beam


@kernel
def stiffen_modes(
    flexible: FlexibleTables,
    share_damping: float,
    share_stiffness: float,
    damping_direction: np.ndarray,
    stiffness_direction: np.ndarray,
    modal: np.ndarray,
) -> None:
    """Scale forces and coupling of all modes by ``1 / sqrt(d)``, after adding directional products, over the speeds."""
    for f in range(len(flexible.bodies)):
        body = flexible.bodies[f]
        k, speed = body[COUNT], body[DETA]
        if body[EXACT] >= 0:
            here = slice(speed, speed + k)
            stiffen_beam(
                flexible, f, share_damping, share_stiffness, damping_direction[here], stiffness_direction[here], modal
            )
            continue
        p, scale = modal[span(body, WORK_FORCE)], modal[span(body, WORK_SCALE)]
        coupling = modal[coupling_span(body)].reshape(6, k)
        workspace = modal[body[MODAL] + WORK_PRODUCTS * k : body[MODAL] + (WORK_PRODUCTS + 2) * k]
        of_damping, of_stiffness = workspace[:k], workspace[k:]
        if body[TRANSFORM] < 0:
            copy(damping_direction[speed : speed + k], of_damping)
            copy(stiffness_direction[speed : speed + k], of_stiffness)
        else:
            transform = flexible.pool[body[TRANSFORM] : body[TRANSFORM] + k * k].reshape(k, k)
            transposed_product(transform, 0, damping_direction[speed : speed + k], of_damping)
            transposed_product(transform, 0, stiffness_direction[speed : speed + k], of_stiffness)
        diagonal = flexible.pool[body[POOL] + POOL_STIFFNESS :]
        for j in range(k):
            stiffness, damping = diagonal[j], 0.0
            if body[DAMPING] >= 0:
                damping = flexible.pool[body[DAMPING] + j * k + j]
            s = 1.0 / np.sqrt(1.0 + share_damping * damping + share_stiffness * stiffness)
            scale[j] = s
            p[j] = s * (p[j] + damping * of_damping[j] + stiffness * of_stiffness[j])
            for c in range(6):
                coupling[c, j] *= s


@kernel
def stiffen_joints(
    tables: Tables | PlanarTables,
    share_damping: float,
    share_stiffness: float,
    damping_direction: np.ndarray,
    stiffness_direction: np.ndarray,
    q: np.ndarray,
    u: np.ndarray,
    applied: np.ndarray,
    added: np.ndarray,
) -> None:
    """Write the inertia that ``s C + r K`` adds along each joint coordinate; add directional products to the forces."""
    added[:] = 0.0
    for n in range(len(tables.joint_forces)):
        at, speed, law = tables.joint_forces[n, 0], tables.joint_forces[n, 1], tables.joint_forces[n, 2]
        if at >= 0 and law >= 0:
            stiffness, damping = coordinate_slopes(tables.laws[law], q[at].real, u[speed].real)
            added[speed] += share_damping * damping + share_stiffness * stiffness
            applied[speed] += damping * damping_direction[speed] + stiffness * stiffness_direction[speed]
