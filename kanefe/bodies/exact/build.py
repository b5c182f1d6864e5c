"""From sections along a line to a beam that bends far."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kanefe.bodies.exact.beam_line import BeamLine, magnus_vectors
from kanefe.bodies.exact.strain_basis import StrainBasis
from kanefe.frames import Matrix

STRAINS = ("stretch", "shear_y", "shear_z", "twist", "curvature_y", "curvature_z")
"""Strains of a section in the order of their numbers: of its forces along x, y, z, then of its moments about them."""


@dataclass(frozen=True)
class SectionFields:
    """Properties of the sections of a beam over the arc length s (m); each takes s (n,).

    Attributes
    ----------
    stiffness : callable
        (n, 6, 6): forces along x, y, z (N) and moments about them (N m) from the strains.
    mass : callable
        (n,), kg/m.
    centre : callable
        (n, 3): centre of mass in axes of the section, m.
    inertia : callable
        (n, 3, 3): about it, kg m.
    curvature : callable
        (n, 3): twist and curvatures at rest, 1/m.
    """

    stiffness: Callable[[np.ndarray], np.ndarray]
    mass: Callable[[np.ndarray], np.ndarray]
    centre: Callable[[np.ndarray], np.ndarray]
    inertia: Callable[[np.ndarray], np.ndarray]
    curvature: Callable[[np.ndarray], np.ndarray]


def beam_line(
    length: float,
    fields: SectionFields,
    bases: Mapping[int, StrainBasis],
    breaks: Sequence[float],
    points: int,
    axes: Matrix,
) -> tuple[BeamLine, Matrix]:
    """Return the strain fields of a beam, and the stiffness K of its coordinates (k, k).

    Parameters
    ----------
    length : float
        m.
    fields : SectionFields
    bases : mapping of int to StrainBasis
        Functions of each strain that the beam has, in rising order.
    breaks : sequence of float
        Places within the beam (m), in order, where cells end besides the breaks of the functions.
    points : int
        Gauss points of each cell.
    axes : ndarray, shape (3, 3)
        Of the root section, at the origin of G.
    """
    inner = np.concatenate([np.asarray(breaks, dtype=float), *(length * basis.breaks for basis in bases.values())])
    ends = np.unique(np.concatenate(([0.0, length], inner)))
    lengths = np.diff(ends)
    x, weights = np.polynomial.legendre.leggauss(points)
    x, weights = 0.5 * (x + 1.0), 0.5 * weights
    strain_of = np.concatenate([np.full(basis.count, strain) for strain, basis in bases.items()])
    k = len(strain_of)

    def values(s: np.ndarray) -> np.ndarray:
        return np.concatenate([basis.values(s / length) for basis in bases.values()], axis=1)

    cells = len(lengths)
    turn_rest, turn_values = np.zeros((cells, points + 1, 3, 3)), np.zeros((cells, points + 1, 3, k))
    gauss_values = np.zeros((cells, points, k))
    masses, centres = np.zeros((cells, points)), np.zeros((cells, points, 3))
    inertias = np.zeros((cells, points, 3, 3))
    stiffness = np.zeros((cells, points, 6, 6))
    for c, (start, h) in enumerate(zip(ends[:-1], lengths, strict=True)):
        stations = start + h * np.concatenate(([0.0], x, [1.0]))
        for g, step in enumerate(np.diff(stations)):
            s = stations[g] + step * x
            turn_rest[c, g] = magnus_vectors(step, x, weights, fields.curvature(s))
            turn_values[c, g] = magnus_vectors(step, x, weights, values(s))
        s, w = stations[1:-1], h * weights
        gauss_values[c] = values(s)
        masses[c], centres[c] = w * fields.mass(s), fields.centre(s)
        inertias[c] = w[:, None, None] * fields.inertia(s)
        stiffness[c] = fields.stiffness(s)
    D = stiffness[..., strain_of[:, None], strain_of]
    K = np.einsum("c,g,cgi,cgij,cgj->ij", lengths, weights, gauss_values, D, gauss_values, optimize=True)
    last = [basis.is_hierarchical and basis.count - i <= 2 for basis in bases.values() for i in range(basis.count)]
    line = BeamLine(
        *(axes, strain_of, lengths, x, weights, turn_rest, turn_values, gauss_values),
        *(masses, centres, inertias, stiffness, np.array(last)),
    )
    return line, 0.5 * (K + K.T)
