"""The interface of beam sections."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from kanefe_fem.materials.isotropic import Material


class LineMass(NamedTuple):
    """Mass of a section.

    Attributes
    ----------
    rho_A : float
        kg/m.
    centre : ndarray, shape (2,)
        y and z of the centre of mass, from the axis of the beam, m.
    second : ndarray, shape (2, 2)
        ``int rho r r^T dA`` of r = (y, z) from the centre of mass, kg m.
    """

    rho_A: float
    centre: np.ndarray
    second: np.ndarray


class BeamSection(ABC):
    """A section of a beam."""

    @property
    @abstractmethod
    def needs_material(self) -> bool:
        """Whether stiffness and mass follow from a material only."""

    @property
    @abstractmethod
    def turns_freely(self) -> bool:
        """Whether stiffness and mass do not depend on the orientation about the axis."""

    @abstractmethod
    def stiffness_of(self, material: Material | None, *, planar: bool) -> np.ndarray:
        """Return the section's stiffness (N, V_y, V_z, T, M_y, M_z), shape (6, 6); ``inf`` where shear is rigid."""

    def fibres_of(self, material: Material | None) -> np.ndarray | None:
        """Return fibres around the outline, y and z (m) and Young's modulus (Pa), (p, 3); None if unknown."""
        return None

    @abstractmethod
    def mass_of(self, material: Material | None) -> LineMass:
        """Return the section's mass."""
