"""The element of the paper in space."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kanefe.checks.verification import Case, Check, Reference
from kanefe.frames import rotation_about, rotation_matrix
from kanefe_fem.beams import spatial_element as se

LENGTH, WIDTH, HEIGHT, DENSITY = 0.7, 0.04, 0.02, 2700.0
PLACE = (1.3, -0.4, 0.8)
"""Position of the centre of mass, m."""


def turned_element(reference: Reference) -> Iterator[Check]:
    """B11: mass, first moment and inertia of one spatial element by its mass matrix."""
    A_GL, rho_A = rotation_matrix(rotation_about((1.0, 2.0, -0.5), 2.2)), DENSITY * WIDTH * HEIGHT
    in_L = se.spatial_mass(LENGTH, rho_A, rho_A * HEIGHT**2 / 12, rho_A * WIDTH**2 / 12)
    mass, x = se.spatial_mass_in_G(in_L, A_GL), se.spatial_position_in_G(LENGTH, A_GL, np.array(PLACE))
    along = np.tile(np.eye(3, 6)[0], 2)
    values = reference.values
    yield Check.relative("mass [kg]", along @ mass @ along, values["mass"], 1e-14)
    yield Check.relative("first moment [kg m]", se.spatial_first_moment(mass, x), values["first_moment"], 1e-14)
    yield Check.relative("inertia [kg m2]", se.spatial_moment_of_inertia(mass, x), values["inertia"], 1e-14)


CASES = (Case("B11", turned_element),)
