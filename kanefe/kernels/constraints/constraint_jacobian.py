"""A row of J: the generalised forces of a wrench on the way from its row to N, and the largest they could be."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, cross, dot, matrix, numbers_of, plus, rotated_back, vector
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.joints.by_kind import partials
from kanefe.kernels.layout import (
    BASIS,
    BENT,
    COUNT,
    DETA,
    FIXED,
    FLEXIBLE,
    FREE,
    GIVEN,
    INTERFACE,
    KIND,
    OFFSET,
    PARENT,
    SPEED,
    SPHERICAL,
    TANGENT,
    R,
)
from kanefe.kernels.scene import Scene, Work, links_of


@kernel
def walk_inward(
    scene: Scene, work: Work, i: int, force: Numbers, moment: Numbers, J: np.ndarray, reach: np.ndarray
) -> None:
    """Add the generalised forces of a wrench on a row, and the largest they could be, on the way to N."""
    rows, links, flexible, frames, modal = (
        scene.tables.rows,
        links_of(scene),
        scene.flexible,
        work.frames.numbers,
        work.modal,
    )
    # of a vector whose real part is zero, the square of a complex step is negative
    f_size, m_size = np.sqrt(abs(dot(force, force).real)), np.sqrt(abs(dot(moment, moment).real))
    while i >= 0:
        kind, speed = rows[i, KIND], rows[i, SPEED]
        if kind == INTERFACE:
            body = flexible.bodies[rows[i, FLEXIBLE]]
            k, first = body[COUNT], body[DETA]
            G = matrix(frames, rows[i, PARENT], R)
            a, b = rotated_back(G, force), rotated_back(matrix(frames, i, TANGENT), rotated_back(G, moment))
            at, bent = rows[i, BASIS], rows[i, BENT]
            own, own_reach = J[first : first + k], reach[first : first + k]
            if bent < 0:
                _add_modal_row(flexible.pool[at : at + 6 * k].reshape(6, k), a, b, f_size, m_size, own, own_reach)
            else:
                _add_modal_row(modal[bent : bent + 6 * k].reshape(6, k), a, b, f_size, m_size, own, own_reach)
        elif FIXED < kind <= GIVEN:
            along, about = partials(links[i], work.frames[i])
            v, w = numbers_of(along), numbers_of(about)
            J[speed] += dot(v, force) + dot(w, moment)
            reach[speed] += np.sqrt(abs(dot(v, v).real)) * f_size + np.sqrt(abs(dot(w, w).real)) * m_size
        elif kind in (SPHERICAL, FREE):
            last = speed
            if kind == FREE:
                for c in range(3):  # in N: the length is what matters
                    J[speed + c] += force[c]
                    reach[speed + c] += f_size
                last += 3
            for c in range(3):
                J[last + c] += moment[c]
                reach[last + c] += m_size
        lever = vector(frames, i, OFFSET)
        moment = plus(moment, cross(lever, force))
        m_size += np.sqrt(abs(dot(lever, lever).real)) * f_size
        i = rows[i, PARENT]


@kernel
def _add_modal_row(
    basis: np.ndarray, a: Numbers, b: Numbers, f_size: float, m_size: float, J: np.ndarray, reach: np.ndarray
) -> None:
    """Add the generalised forces of a wrench in G on the modes of a body, and the largest they could be."""
    for j in range(len(J)):
        size, turn = 0.0, 0.0
        for c in range(3):
            J[j] += basis[c, j] * a[c] + basis[3 + c, j] * b[c]
            size += (basis[c, j] * basis[c, j]).real
            turn += (basis[3 + c, j] * basis[3 + c, j]).real
        reach[j] += np.sqrt(size) * f_size + np.sqrt(turn) * m_size


@inlined
def row_scale(J: np.ndarray, reach: np.ndarray, extents: np.ndarray, work: np.ndarray) -> Any:
    """Return the square of how much of its reach a row has, between 0 and 1, over displacements of the scene's size."""
    own = full = 0.0
    for i in range(len(extents)):
        moved, reached = extents[i] * J[i].real, extents[i] * reach[i].real
        own += moved * moved
        full += reached * reached
    share = 0.0 * work[0, R]
    return share + (own / full if full > 0.0 else 0.0)
