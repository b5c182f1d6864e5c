"""The nodes of a named part of a mesh, each with its share of the area."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from kanefe.fe_model.model import NodeGroup


@dataclass(frozen=True, eq=False)
class NodeShares:
    """A named part of a mesh: its nodes, and of each the share of the area (or length), together 1.

    Shares are as the diagonal of ``int N_i N_j``, which is above zero for elements of all orders.
    """

    name: str
    nodes: np.ndarray
    shares: np.ndarray

    @classmethod
    def of(cls, name: str, group: NodeGroup) -> NodeShares:
        """Return the nodes of a group; those of one without facets share alike."""
        nodes = np.asarray(group.nodes)
        shares = np.ones(len(nodes)) if group.measure is None else group.measure.diagonal()
        return cls(name, nodes, shares / shares.sum())
