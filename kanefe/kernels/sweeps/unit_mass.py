"""Coordinates of unit mass for beams that bend far, whose mass matrix M depends on the state.

With its factors ``M = L L^T`` the coordinates ``L^T q`` have unit mass, as the modes of other bodies have, so that the
elimination of `modal_elimination` is the same for both.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.layout import COUNT, EXACT, WORK_FORCE
from kanefe.kernels.scene import Scene, Work
from kanefe.kernels.sweeps.elastic import coupling_span, span, total
from kanefe.kernels.sweeps.exact_beam_layout import beam_work_in


@kernel
def scale_beams(scene: Scene, work: Work) -> None:
    """Factor the mass of all beams, and write their forces and couplings for coordinates of unit mass."""
    bodies, modal = scene.flexible.bodies, work.modal
    for f in range(len(bodies)):
        body = bodies[f]
        if body[EXACT] < 0:
            continue
        at, k = beam_work_in(body, modal), body[COUNT]
        L = at.mass
        if at.kept[0] == 0.0:
            for i in range(k):
                for j in range(i):
                    L[i, j] = (L[i, j] - total(L[i, :j], L[j, :j])) / L[j, j]
                L[i, i] = np.sqrt(L[i, i] - total(L[i, :i], L[i, :i]))
        _divide(L, modal[span(body, WORK_FORCE)])
        coupling = modal[coupling_span(body)].reshape(6, k)
        for a in range(6):
            _divide(L, coupling[a])


@inlined
def _divide(L: np.ndarray, x: np.ndarray) -> None:
    """Replace x by L^-1 x."""
    for i in range(len(x)):
        x[i] = (x[i] - total(L[i, :i], x[:i])) / L[i, i]


@kernel
def to_unit_mass(body: np.ndarray, rows: np.ndarray, modal: np.ndarray) -> None:
    """Replace each row, of forces or of a motion by the coordinates of a beam, by that of coordinates of unit mass."""
    L = beam_work_in(body, modal).mass
    for a in range(len(rows)):
        _divide(L, rows[a])


@kernel
def from_unit_mass(body: np.ndarray, x: np.ndarray, modal: np.ndarray) -> None:
    """Replace accelerations of coordinates of unit mass by those of the coordinates of a beam, L^-T x."""
    L = beam_work_in(body, modal).mass
    for i in range(len(x) - 1, -1, -1):
        x[i] = x[i] / L[i, i]
        for j in range(i):
            x[j] -= L[i, j] * x[i]
