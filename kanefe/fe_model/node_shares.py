"""The nodes of a named part of a mesh and their shares of its area."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from kanefe.fe_model.model import NodeGroup


@dataclass(frozen=True, eq=False)
class NodeShares:
    """A named part of a mesh: its nodes, and the share of each in the area (or length), of sum 1.

    Shares are proportional to the diagonal of ``int N_i N_j``, which is above zero for elements of all orders.
    """

    name: str
    nodes: np.ndarray
    shares: np.ndarray

    @classmethod
    def of(cls, name: str, group: NodeGroup) -> NodeShares:
        """Return the nodes of a group; without facets their shares are equal."""
        nodes = np.asarray(group.nodes)
        shares = np.ones(len(nodes)) if group.measure is None else group.measure.diagonal()
        return cls(name, nodes, shares / shares.sum())
