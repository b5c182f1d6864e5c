"""Stresses at the nodes of elements of the user, from those of unit coordinates: `StrainFields` without strains."""

from __future__ import annotations

import numpy as np

from kanefe.errors import ModelError
from kanefe.fe_model.model import Elasticity
from kanefe.results.body_shape import BodyShape
from kanefe_fem.recovery.mesh_error import Patch
from kanefe_fem.recovery.strain_fields import Place, StrainFields, Tensor


class GivenStresses(StrainFields):
    """Stresses of a body whose elements brought them.

    Parameters
    ----------
    name : str
        Name of the body, for messages.
    body : BodyShape
    stresses : ndarray, shape (n, 6, k)
        Pa by coordinate.
    """

    def __init__(self, name: str, body: BodyShape, stresses: np.ndarray) -> None:
        super().__init__(
            body.nodes, body.components, body.basis, body.cells, Elasticity(np.zeros((0, 6, 6)), np.zeros(0))
        )
        self.name = name
        self.stresses = stresses

    def evaluate(self, what: Tensor, at: Place, eta: np.ndarray, material: int | None = None) -> np.ndarray:
        """Return the stress at the nodes; raise a ModelError for anything else."""
        return np.tensordot(eta, self.modes(what, at, material), axes=(1, -1))

    def modes(self, what: Tensor, at: Place, material: int | None = None) -> np.ndarray:
        """Return the stress of each unit coordinate at the nodes, (n, 6, k), or the means of cells, (cells, 6, k)."""
        if what != "stress" or at == "gauss" or material is not None:
            raise ModelError(
                f"the elements of {self.name!r} give stresses at nodes, no {what} at {at} or of one material. Remedy: "
                "stress_at_nodes, stress_at_cells, von_mises, envelope"
            )
        if at == "nodes":
            return self.stresses
        return np.concatenate([self.stresses[block.nodes].mean(axis=1) for block in self.cells])

    def patches(self, node: int, eta: np.ndarray, material: int | None = None) -> list[Patch]:
        """Return none: the stresses of the cells are not known."""
        return []

    def around(self, chosen: np.ndarray) -> tuple[StrainFields, np.ndarray]:
        """Return these stresses themselves."""
        return self, chosen
