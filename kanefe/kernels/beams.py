"""Beams that bend far: what is given of each, and what changes with its state.

A beam has C cells with P Gauss points each, and k coordinates of its strains: see
`kanefe.bodies.exact.beam_line.BeamLine`. A section is at the root, and in each cell at its Gauss points and at its end.
What changes is seen from G.
"""

from typing import Annotated

import numpy as np

from kanefe.kernels.bodies import BorderedBody
from kanefe.kernels.language import Array, Matrix, One, Record, Rows, Start, Symmetric, Table, Vector


class Section(Record):
    """How a section moves.

    Attributes
    ----------
    A : Matrix
        Its axes.
    p, v, w : Vector
        Place, velocity and angular velocity.
    Z, Y : Vector
        Accelerations that are not linear in those of the coordinates.
    """

    A: Matrix
    p: Vector
    v: Vector
    w: Vector
    Z: Vector
    Y: Vector


class Sections(Rows[Section]):
    """All sections of a beam."""


class Slope(Record):
    """The slope of the places along the beam at a Gauss point, and its rates.

    Attributes
    ----------
    t, v, Z : Vector
        Along the beam: of the place, of its velocity, and of its acceleration that is not linear.
    """

    t: Vector
    v: Vector
    Z: Vector


class Slopes(Rows[Slope]):
    """The slopes at the Gauss points of a cell."""


class BeamPoint(Record):
    """Mass at a Gauss point.

    Attributes
    ----------
    mass : float
        kg.
    centre, inertia : Vector, Symmetric
        Centre of mass, and inertia about it, in axes of the section.
    """

    mass: float
    centre: Vector
    inertia: Symmetric


class BeamPoints(Rows[BeamPoint]):
    """All Gauss points of a beam."""


class Step(Record):
    """The three vectors of the Magnus expansion from section to section, of the undeformed beam."""

    a1: Vector
    a2: Vector
    a3: Vector


class Steps(Rows[Step]):
    """All steps from section to section."""


class ExactBeam(BorderedBody):
    """A beam that bends far.

    Attributes
    ----------
    cell_count, point_count : int
        C, P.
    end_count, step_count, mass_count, section_count : int
        P + 1, C (P + 1), C P, and 1 + C (P + 1).
    in_plane : bool
        Whether it bends in the x-y plane of G alone.
    root : Matrix
        Axes of the root in G.
    begins : ndarray, shape (7,)
        Where the coordinates of each of the six strains begin, and end.
    lengths : ndarray, shape (C,)
    integration : ndarray, shape (P + 1, P)
    steps : Steps
    step_values : ndarray, shape (3 C (P + 1), k)
        What a coordinate changes of their vectors.
    values : ndarray, shape (C P, k)
    masses : BeamPoints
    resistance : ndarray, shape (k, k)
        Stiffness.
    sections : Sections
    motions : ndarray, shape (6 sections, k)
        Derivatives of their velocity and angular velocity by the rates of the coordinates.
    slopes : Slopes
    slope_motions : ndarray, shape (3 P, k)
        Derivatives of the velocities in them.
    momenta : ndarray, shape (6, k)
        Of a section, by the rates of the coordinates.
    inertia_of_rates : ndarray, shape (k, k)
        M in its lower half, or its factor L.
    kept : ndarray, shape (1,)
        Whether motions and M are those of the last evaluation: not zero.
    """

    cell_count: int
    point_count: int
    end_count: int
    step_count: int
    mass_count: int
    section_count: int
    in_plane: bool
    line: Annotated[int, Start("pool")]
    root: Annotated[Matrix, One(Matrix)]
    begins: Annotated[np.ndarray, Array(7)]
    lengths: Annotated[np.ndarray, Array("cell_count")]
    integration: Annotated[np.ndarray, Array("end_count", "point_count")]
    steps: Annotated[Steps, Table(Steps, "step_count", Step.number_count)]
    step_values: Annotated[np.ndarray, Array("3step_count", "k")]
    values: Annotated[np.ndarray, Array("mass_count", "k")]
    masses: Annotated[BeamPoints, Table(BeamPoints, "mass_count", BeamPoint.number_count)]
    resistance: Annotated[np.ndarray, Array("k", "k")]
    moving: Annotated[int, Start("modal")]
    sections: Annotated[Sections, Table(Sections, "section_count", Section.number_count)]
    motions: Annotated[np.ndarray, Array("6section_count", "k")]
    slopes: Annotated[Slopes, Table(Slopes, "point_count", Slope.number_count)]
    slope_motions: Annotated[np.ndarray, Array("3point_count", "k")]
    momenta: Annotated[np.ndarray, Array(6, "k")]
    inertia_of_rates: Annotated[np.ndarray, Array("k", "k")]
    kept: Annotated[np.ndarray, Array(1)]
