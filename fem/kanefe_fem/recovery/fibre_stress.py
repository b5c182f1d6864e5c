"""Normal stress of stretch and bending in the outer fibres of beams, ``E (N/EA + z My/EI_y - y Mz/EI_z)``.

The section forces are those of the kept modes. Shear stresses of shear forces and torsion are not included. In an exact
beam it follows from its strains, ``E (e + z k_y - y k_z)``: it is that of bending alone if its theory has no stretch,
and its components are in G as if the sections had not turned.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.errors import ModelError
from kanefe.results.body_shape import BodyShape
from kanefe_fem.recovery.section_forces import BeamFrame

if TYPE_CHECKING:
    from kanefe.bodies.exact.beam_line import BeamLine

ENDS = np.array([0.0, 1.0])


def fibre_stress(shape: BodyShape, eta: np.ndarray) -> np.ndarray:
    """Return the stress of p fibres at both ends of m beams for coordinates (r, k), shape (r, m 2 p, 6), Pa.

    Ordered by elements, then ends, then fibres; components xx, yy, zz, yz, xz, xy in G.
    """
    normal = normal_stress(shape, eta)
    x, y, z = _frame(shape).axes[:, :, 0].T
    dyads = np.stack((x * x, y * y, z * z, y * z, x * z, x * y), axis=-1)  # (m, 6)
    return np.asarray((normal[..., None] * dyads[:, None, None]).reshape(len(eta), -1, 6))


def normal_stress(shape: BodyShape, eta: np.ndarray) -> np.ndarray:
    """Return the normal stress in the fibres at both ends of each beam, (r, m, 2, p), Pa, for coordinates (r, k).

    NaN where the section couples stretch, bending and twist, or its shape is not known.

    Raises
    ------
    ModelError
        If the body is not made of beams, or the shape of no section is known.
    """
    frame = _frame(shape)
    elasticity = shape.elasticity
    if elasticity is None or elasticity.fibres is None:
        raise ModelError(
            f"the sections of body {shape.name!r} have section constants but no shape, so the stress of their outer "
            "fibres is unknown. Remedy: SolidCircle, Tube, Rectangle or Box, or recover(...).section_forces()"
        )
    fibres = elasticity.fibres[elasticity.of_cell]
    if shape.line is not None:
        return _exact_stress(shape.line, fibres, np.asarray(eta))
    y, z, E = np.moveaxis(fibres, -1, 0)[:, None, :, None, :]
    forces = frame.along(frame.end_forces(np.asarray(eta @ shape.basis.T)), ENDS, None)[..., None]  # (r, m, 2, 6, 1)
    own = frame.properties
    stretch = forces[..., 0, :] / own.EA[:, None, None]
    about_y = forces[..., 4, :] / own.EI_y[:, None, None]
    about_z = forces[..., 5, :] / own.EI_z[:, None, None]
    stress = E * (stretch + z * about_y - y * about_z)
    is_unknown = E[0] <= 0.0  # (m, 1, p)
    is_unknown[own.coupled] = True
    return np.where(is_unknown, np.nan, stress)


def _exact_stress(line: BeamLine, fibres: np.ndarray, eta: np.ndarray) -> np.ndarray:
    """Return those of an exact beam between its stations, from its strains."""
    strains = line.through(np.concatenate(([0.0], line.points, [1.0]))) @ line.strains(eta)  # (r, C, P + 2, 6)
    ends = np.stack((strains[:, :, :-1], strains[:, :, 1:]), axis=3).reshape(len(eta), -1, 2, 6, 1)
    y, z, E = np.moveaxis(fibres, -1, 0)[:, None, :, None, :]
    stress = E * (ends[..., 0, :] + z * ends[..., 4, :] - y * ends[..., 5, :])
    return np.where(E > 0.0, stress, np.nan)


def _frame(shape: BodyShape) -> BeamFrame:
    return BeamFrame.of_body(shape.name, shape.nodes, shape.components, shape.elasticity, shape.cells)
