"""Inertia in the rows: what a body brings, and how a child's comes to its parent, by a shift since all is in N."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import (
    Numbers,
    accumulate,
    accumulate_matrix,
    accumulate_symmetric,
    congruent,
    cross,
    full,
    matrix,
    plus,
    product_skew,
    put,
    put_matrix,
    put_symmetric,
    rotated,
    skew_product,
    symmetric_times,
    times,
    vector,
)
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.layout import FORCE, MOMENT, OMEGA, H, J, M, R, Y, Z


@inlined
def hand_inward(
    work: np.ndarray, parent: int, r: Numbers, m: Numbers, h: Numbers, j: Numbers, force: Numbers, moment: Numbers
) -> None:
    """Add inertia and force about a point at r from the parent's origin to the parent."""
    accumulate_symmetric(work, parent, M, m)
    # H' = H - M r~,   J' = J - H^T r~ + r~ H'
    mr = product_skew(full(m), r)
    hs = (
        h[0] - mr[0], h[1] - mr[1], h[2] - mr[2],
        h[3] - mr[3], h[4] - mr[4], h[5] - mr[5],
        h[6] - mr[6], h[7] - mr[7], h[8] - mr[8],
    )  # fmt: skip
    accumulate_matrix(work, parent, H, hs)
    rh = skew_product(r, hs)
    accumulate_symmetric(
        work,
        parent,
        J,
        (
            j[0] - (h[3] * r[2] - h[6] * r[1]) + rh[0],
            j[1] - (h[6] * r[0] - h[0] * r[2]) + rh[1],
            j[2] - (h[0] * r[1] - h[3] * r[0]) + rh[2],
            j[3] - (h[7] * r[0] - h[1] * r[2]) + rh[4],
            j[4] - (h[1] * r[1] - h[4] * r[0]) + rh[5],
            j[5] - (h[2] * r[1] - h[5] * r[0]) + rh[8],
        ),
    )
    accumulate(work, parent, FORCE, force)
    accumulate(work, parent, MOMENT, plus(moment, cross(r, force)))


@inlined
def hand_force_inward(work: np.ndarray, parent: int, r: Numbers, m: Numbers, force: Numbers, moment: Numbers) -> None:
    """Add a mass that resists translations only, and a force, at r from the parent's origin to the parent."""
    accumulate_symmetric(work, parent, M, m)
    mr = product_skew(full(m), r)
    rmr = skew_product(r, mr)
    accumulate_matrix(work, parent, H, (-mr[0], -mr[1], -mr[2], -mr[3], -mr[4], -mr[5], -mr[6], -mr[7], -mr[8]))
    accumulate_symmetric(work, parent, J, (-rmr[0], -rmr[1], -rmr[2], -rmr[4], -rmr[5], -rmr[8]))
    accumulate(work, parent, FORCE, force)
    accumulate(work, parent, MOMENT, plus(moment, cross(r, force)))


@inlined
def put_inertia(
    work: np.ndarray, i: int, mass: float, c: Numbers, inertia: Numbers, force: Numbers, moment: Numbers
) -> None:
    """Write what a body brings to its row; c is its mass times its centre of mass."""
    zero = 0.0 * c[0]
    put_symmetric(work, i, M, (zero + mass, zero, zero, zero + mass, zero, zero + mass))
    put_matrix(work, i, H, (zero, c[2], -c[1], -c[2], zero, c[0], c[1], -c[0], zero))
    put_symmetric(work, i, J, inertia)
    put(work, i, FORCE, force)
    put(work, i, MOMENT, moment)


@inlined
def set_rigid(work: np.ndarray, i: int, mass: float, first: Numbers, second: Numbers, rotor: Numbers) -> None:
    """Write inertia and force of a rigid body; the gyroscopic moment is w~ I w (Eq. 17, 37).

    Parameters
    ----------
    first, second, rotor : tuple
        Mass times centre of mass, inertia about the origin, and angular momentum of rotors, in axes of the row.
    """
    axes, w = matrix(work, i, R), vector(work, i, OMEGA)
    c = rotated(axes, first)
    inertia = congruent(axes, second)
    a, alpha = vector(work, i, Z), vector(work, i, Y)
    force = plus(times(mass, a), plus(cross(alpha, c), cross(w, cross(w, c))))
    momentum = plus(symmetric_times(inertia, w), rotated(axes, rotor))
    moment = plus(cross(c, a), plus(symmetric_times(inertia, alpha), cross(w, momentum)))
    put_inertia(work, i, mass, c, inertia, force, moment)


@inlined
def clear_forces(work: np.ndarray, i: int) -> None:
    """Write no force."""
    for at in range(FORCE, MOMENT + 3):
        work[i, at] = 0.0


@inlined
def clear(work: np.ndarray, i: int) -> None:
    """Write no inertia and no force."""
    for at in range(M, MOMENT + 3):
        work[i, at] = 0.0
