"""Inertia of every row and the force that keeps it moving with du = 0 (Eq. 12, 17, 20, 37, 38)."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, accumulate, cross, matrix, rotated_back, symmetric, times, vector
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.layout import (
    COUNT,
    EXACT,
    FIRST,
    FLEXIBLE,
    FORCE,
    HAS_GRAVITY,
    INTERFACE,
    KIND,
    MASS,
    MOMENT,
    POOL,
    POOL_MASS,
    ROTOR,
    SECOND,
    WORK_FORCE,
    FlexibleTables,
    H,
    R,
    Tables,
)
from kanefe.kernels.sweeps.body_inertia import clear, set_rigid
from kanefe.kernels.sweeps.elastic import coupling_span, set_flexible, set_stiff, span
from kanefe.kernels.sweeps.exact_beam_inertia import set_exact


@kernel
def set_inertia(tables: Tables, flexible: FlexibleTables, work: np.ndarray, modal: np.ndarray) -> None:
    """Write inertia, force and moment of all rows: those of their bodies alone."""
    rows, geometry, gravity = tables.rows, tables.geometry, tables.gravity
    for i in range(len(rows)):
        if rows[i, KIND] != INTERFACE and rows[i, FLEXIBLE] >= 0:
            f = rows[i, FLEXIBLE]
            if flexible.bodies[f, EXACT] >= 0:
                set_exact(flexible, f, i, work, modal)
            elif flexible.bodies[f, COUNT] > 0:
                set_flexible(flexible, f, i, work, modal)
            else:
                set_stiff(flexible, f, i, work)
            if not rows[i, HAS_GRAVITY]:
                _lift(flexible, f, i, work, modal, gravity)
        elif geometry[i, MASS] == 0.0:
            clear(work, i)
        else:
            set_rigid(
                work,
                i,
                geometry[i, MASS],
                vector(geometry, i, FIRST),
                symmetric(geometry, i, SECOND),
                vector(geometry, i, ROTOR),
            )
            if not rows[i, HAS_GRAVITY]:
                h = matrix(work, i, H)
                _take_gravity_off(work, i, geometry[i, MASS], (h[5], h[6], h[1]), gravity)


@inlined
def _take_gravity_off(work: np.ndarray, i: int, mass: float, c: Numbers, gravity: np.ndarray) -> None:
    """Undo gravity, which is part of Z, for a body without gravity."""
    g = (gravity[0], gravity[1], gravity[2])
    accumulate(work, i, FORCE, times(mass, g))
    accumulate(work, i, MOMENT, cross(c, g))


@kernel
def _lift(flexible: FlexibleTables, f: int, i: int, work: np.ndarray, modal: np.ndarray, gravity: np.ndarray) -> None:
    """Undo gravity for a flexible body without gravity."""
    body = flexible.bodies[f]
    h = matrix(work, i, H)
    _take_gravity_off(work, i, flexible.pool[body[POOL] + POOL_MASS], (h[5], h[6], h[1]), gravity)
    g = rotated_back(matrix(work, i, R), (gravity[0], gravity[1], gravity[2]))
    p = modal[span(body, WORK_FORCE)]
    coupling = modal[coupling_span(body)].reshape(6, body[COUNT])
    for j in range(len(p)):
        p[j] -= g[0] * coupling[0, j] + g[1] * coupling[1, j] + g[2] * coupling[2, j]
