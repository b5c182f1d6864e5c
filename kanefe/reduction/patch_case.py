"""Contact patches as load cases: single forces on the points of a part of the skin.

A contact acts on few nodes. Normal modes hardly represent their local compliance; the static shapes of such forces do
(attachment modes; MacNeal, "A hybrid method of component mode synthesis", Computers & Structures 1 (1971) 581). The
share of the compliance c that a basis V represents is

    c_V / c   with   c = f^T K^-1 f,   c_V = (V^T f)^T diag(1 / w^2) (V^T f)

for a unit force f on one of the points.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.fe_model.contact_points import contact_points
from kanefe.fe_model.model import TRANSLATIONS, FiniteElementModel
from kanefe.fe_model.node_shares import NodeShares
from kanefe.fe_model.places import Place
from kanefe.fe_model.statics import StaticProblem
from kanefe.reduction.orthonormal import Orthonormal

LOOKED_AT = 4
"""Number of points of each surface of a body at which the local compliance of the modes is compared."""


@checked("most")
@dataclass(frozen=True)
class PatchCase:
    """Unit forces along x, y and z on each point of a contact patch.

    Among the `loads` of a reduction it gives the body the local compliance of its mesh under contacts, by three shapes
    for each point. `FlexibleMember.patch` with the same place and number takes the same points.

    Parameters
    ----------
    place : str or Place
        Name of a group of the mesh, or a place on its outside such as `OnPlane`.
    most : int
        Largest number of points; those furthest from each other are taken.

    Raises
    ------
    ModelError
        If a parameter is not valid; in the reduction also if the model has no such nodes.

    Examples
    --------
    >>> import kanefe as kf
    >>> kf.CraigBampton(8, loads=(kf.PatchCase("skid", most=4),))
    CraigBampton(modes=8, loads=(PatchCase(place='skid', most=4),))
    """

    place: str | Place
    most: int = 16

    def __post_init__(self) -> None:
        if not isinstance(self.place, (str, Place)):
            raise ModelError(
                f"the place of a PatchCase must be a group's name, OnPlane, Near or so on, not {self.place!r}"
            )
        if isinstance(self.most, bool) or not isinstance(self.most, (int, np.integer)) or self.most < 1:
            raise ModelError(f"most of a PatchCase must be a whole number of points, 1 or more, not {self.most!r}")

    @property
    def name(self) -> str:
        """Name of its forces, in records."""
        return f"patch {self.place}"

    def forces(self, model: FiniteElementModel) -> np.ndarray:
        """Return the forces on the degrees of freedom of a model, shape (N, 3 points)."""
        groups = [NodeShares.of(name, group) for name, group in model.groups.items()]
        nodes, _ = contact_points(
            model.nodes, model.cells, groups, self.place, self.most, "the model", is_shell=_is_shell(model)
        )
        width = len(model.components)
        axes = [c for c, component in enumerate(model.components) if component in TRANSLATIONS]
        rows = (nodes[:, None] * width + np.array(axes)).ravel()
        forces = np.zeros((model.size, len(rows)))
        forces[rows, range(len(rows))] = 1.0
        return forces


def _is_shell(model: FiniteElementModel) -> bool:
    return model.elasticity is not None and model.elasticity.shell is not None


def contact_compliance(problem: StaticProblem, modes: Orthonormal) -> list[dict[str, Any]]:
    """Return for each surface of a body its compliance under single forces, and the share that modes represent.

    Parameters
    ----------
    problem : StaticProblem
    modes : Orthonormal

    Returns
    -------
    list of dict
        "surface", number of "points" examined, "compliance" (m/N, mean over points and directions) and "held" (the
        least share of any); json-able.
    """
    model, T = problem.model, problem.ties.transformation.T
    found = []
    for name, pattern in model.load_patterns.items():
        if name not in model.groups or pattern.kind != "surface":
            continue
        forces = T @ PatchCase(name, LOOKED_AT).forces(model)
        forces[problem.fixed] = 0.0
        forces = problem.relieved(forces)
        whole = np.einsum("ij,ij->j", forces, problem.solve(forces))
        held = np.einsum("ij,i->j", (modes.modes.T @ forces) ** 2, 1.0 / modes.squares)
        moved = whole > 0.0
        if moved.any():
            share = float((held[moved] / whole[moved]).min())
            found.append(
                {"surface": name, "points": LOOKED_AT, "compliance": float(whole[moved].mean()), "held": share}
            )
    return found
