"""Coordinates of unit mass for beams that bend far, whose mass matrix M depends on the state.

With its factors ``M = L L^T`` the coordinates ``L^T q`` have unit mass, as the modes of other bodies have, so that the
elimination of `modal_elimination` is the same for both.
"""

import numpy as np

from kanefe.kernels.beams import ExactBeam
from kanefe.kernels.language import inlined, kernel
from kanefe.kernels.scene import Scene, Work, bodies_of
from kanefe.kernels.sweeps.elastic import total


@kernel
def scale_beams(scene: Scene, work: Work) -> None:
    """Factor the mass of all beams, and write their forces and couplings for coordinates of unit mass."""
    bodies = bodies_of(scene, work)
    for f in range(len(bodies)):
        if not bodies[f].is_exact:
            continue
        beam = ExactBeam(bodies[f])
        L, k = beam.inertia_of_rates, beam.k
        if beam.kept[0] == 0.0:
            for i in range(k):
                for j in range(i):
                    L[i, j] = (L[i, j] - total(L[i, :j], L[j, :j])) / L[j, j]
                L[i, i] = np.sqrt(L[i, i] - total(L[i, :i], L[i, :i]))
        _divide(L, beam.p)
        for a in range(3):
            _divide(L, beam.linear.numbers[a * k : (a + 1) * k])
            _divide(L, beam.angular.numbers[a * k : (a + 1) * k])


@inlined
def _divide(L: np.ndarray, x: np.ndarray) -> None:
    """Replace x by L^-1 x."""
    for i in range(len(x)):
        x[i] = (x[i] - total(L[i, :i], x[:i])) / L[i, i]


@inlined
def to_unit_mass(beam: ExactBeam, rows: np.ndarray) -> None:
    """Replace each row, of forces or of a motion by the coordinates of a beam, by that of coordinates of unit mass."""
    for a in range(len(rows)):
        _divide(beam.inertia_of_rates, rows[a])


@kernel
def from_unit_mass(beam: ExactBeam, x: np.ndarray) -> None:
    """Replace accelerations of coordinates of unit mass by those of the coordinates of a beam, L^-T x."""
    L = beam.inertia_of_rates
    for i in range(len(x) - 1, -1, -1):
        x[i] = x[i] / L[i, i]
        for j in range(i):
            x[j] -= L[i, j] * x[i]
