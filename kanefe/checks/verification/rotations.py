"""Case of the conversions between Tait-Bryan angles, Euler parameters and matrices."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kanefe.bodies.slopes import slope_measure, tait_bryan_angles, tait_bryan_euler_parameters
from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.frames import euler_parameters_from_matrix, rotation_matrix, rotation_vector

FORWARD, BACK = 1e-14, 1e-12


def conversions(reference: Reference) -> Iterator[Check]:
    """E03: conversions there and back; near 90 degrees of pitch the rotation is compared, not the single angles."""
    # intrinsic yaw, pitch, roll equals extrinsic roll about x, pitch about y, yaw about z
    angles = [np.radians(entry["ypr_deg"][::-1]) for entry in reference.values]
    parameters = [tait_bryan_euler_parameters(theta) for theta in angles]
    expected = [np.array(entry["q_wxyz"]) for entry in reference.values]
    matrices = [np.array(entry["R"]) for entry in reference.values]
    yield Check.absolute("Euler parameters of the angles", parameters, expected, FORWARD)
    yield Check.absolute("matrix of the angles", [rotation_matrix(e) for e in parameters], matrices, FORWARD)
    measure = slope_measure("tait-bryan")
    back = [measure.rotation(tait_bryan_angles(e)) for e in expected]
    yield Check.absolute("matrix, from the angles of the Euler parameters", back, matrices, BACK)
    back = [rotation_matrix(euler_parameters_from_matrix(A)) for A in matrices]
    yield Check.absolute("matrix, from the Euler parameters of the matrix", back, matrices, BACK)
    back = [slope_measure("rotation-vector").rotation(rotation_vector(e)) for e in expected]
    yield Check.absolute("matrix, from the rotation vector of the Euler parameters", back, matrices, BACK)


CASES = (Case("E03", conversions),)
