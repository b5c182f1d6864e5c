"""Section forces, and stresses in the fibres, of the beams along the lines of a shell.

Strains of their sections are best at the points of quadrature of the stiffness (Barlow 1976, as in
`kanefe_fem.recovery.cell_strains`), and linear between and beyond them. A fibre at (y, z) has the stress
``E (e + z k_y - y k_z)`` of stretch e and curvatures k.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.fe_model.drawn_shell import HALVES
from kanefe.fe_model.model import Cells
from kanefe.fe_model.ribs import NODES, Ribs
from kanefe.fe_model.shapes import shape
from kanefe_fem.recovery.mesh_error import Patch
from kanefe_fem.recovery.scalars import worst_of
from kanefe_fem.recovery.section_forces import SectionForces
from kanefe_fem.recovery.strain_fields import CHUNK
from kanefe_fem.shells.stiffeners import STATIONS, Station

UNIAXIAL: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "von_mises": np.abs,
    "tresca": np.abs,
    "max_principal": lambda s: np.maximum(s, 0.0),
    "min_principal": lambda s: np.minimum(s, 0.0),
    "max_shear": lambda s: 0.5 * np.abs(s),
}
"""Scalars of a stress along one axis."""


class RibFields:
    """Fields of the beams along the lines of a shell, m lines of three nodes.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
        Of the body, m.
    basis : ndarray or sparse matrix, shape (6 n, k)
    table : ndarray of int, shape (m, 3)
        Nodes of the lines.
    ribs : Ribs
    names : sequence of str
        Of the stiffeners.
    """

    def __init__(
        self, nodes: np.ndarray, basis: np.ndarray | sp.spmatrix, table: np.ndarray, ribs: Ribs, names: Sequence[str]
    ) -> None:
        self.places, self.table, self.ribs, self.names = nodes[table], table, ribs, tuple(names)
        dofs = (6 * table[:, :, None] + np.arange(6)).ravel()
        self.motion = basis[dofs]
        self._points = np.polynomial.legendre.leggauss(STATIONS["stiffness"])[0]
        at = [Station(self.places, ribs, 0.5 * (1.0 + xi)) for xi in self._points]
        self._strains = np.stack([one.strains for one in at], axis=1)
        sections = np.array([one.axes for one in at])
        dyads = sections[:, :, 0, [0, 1, 2, 1, 0, 0]] * sections[:, :, 0, [0, 1, 2, 2, 2, 1]]
        self._dyads = dyads.mean(axis=0)

    @property
    def cells(self) -> tuple[Cells, ...]:
        """The lines."""
        return (Cells("line3", self.table),)

    def positions(self, xi: np.ndarray) -> np.ndarray:
        """Return the undeformed places of stations on the axes, by fractions of the lines (s,), shape (m, s, 3), m."""
        return np.einsum("sn,mni->msi", shape("line3").values(xi[:, None]), self.places + self.ribs.arms)

    def strains(self, xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
        """Return stretch, shears along y and z, twist and curvatures at stations, (T, m, s, 6); 1 and rad/m."""
        x = 2.0 * xi - 1.0
        first, last = self._points
        shares = np.column_stack((last - x, x - first)) / (last - first)
        moved = np.asarray(self.motion @ eta.T).reshape(len(self.table), 1, 18, len(eta))
        return np.moveaxis(np.einsum("sg,mgij->msij", shares, self._strains) @ moved, -1, 0)

    def forces(self, xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
        """Return N, Vy, Vz in N and T, My, Mz in N m at stations for coordinates (T, k), shape (T, m, s, 6)."""
        D = self.ribs.stiffness[self.ribs.of_line]
        return np.einsum("mij,tmsj->tmsi", D, self.strains(xi, eta), optimize=True)

    def section_forces(self, times: np.ndarray, xi: np.ndarray, eta: np.ndarray, chosen: np.ndarray) -> SectionForces:
        """Return those of chosen lines (m,), with the names of their stiffeners."""
        groups = tuple(self.names[i] for i in self.ribs.of_line[chosen])
        return SectionForces(times, xi, self.positions(xi)[chosen], self.forces(xi, eta)[:, chosen], groups)

    def stress(self, xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
        """Return the stress along the axis in the fibres, shape (T, m, s, p), Pa; NaN where the outline is unknown."""
        y, z, E = np.moveaxis(self.ribs.fibres[self.ribs.of_line], -1, 0)[:, :, None]
        strains = self.strains(xi, eta)[..., None]
        stress = E * (strains[..., 0, :] + z * strains[..., 4, :] - y * strains[..., 5, :])
        return np.where(E > 0.0, stress, np.nan)

    def modes(self, rib: int | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Return nodes of the fibres (r,) and the stress of every unit coordinate in G there, (r, 6, k)."""
        stress = np.moveaxis(self.stress(NODES, np.eye(self.motion.shape[1])), 0, -1)  # (m, s, p, k)
        modes = stress[..., None, :] * self._dyads[:, None, None, :, None]
        chosen = np.full(len(self.table), True) if rib is None else self.ribs.of_line == rib
        nodes = np.repeat(self.table[chosen], modes.shape[2])
        return nodes, modes[chosen].reshape(len(nodes), 6, -1)

    def patches(self, node: int, eta: np.ndarray, rib: int | None = None) -> list[Patch]:
        """Return the stress around a node, for coordinates (1, k), in the fibre of each stiffener with the largest."""
        at_node = (self.table == node) & ((rib is None) | (self.ribs.of_line == rib))[:, None]
        xi, found = 0.5 * (1.0 + self._points), []
        for own in np.unique(self.ribs.of_line[at_node.any(axis=1)]):
            here = at_node & (self.ribs.of_line == own)[:, None]
            ring = np.isin(self.table, self.table[here.any(axis=1)]).any(axis=1) & (self.ribs.of_line == own)
            mean = self.stress(NODES, eta)[0][here].mean(axis=0)
            if np.isnan(mean).any():
                continue
            fibre = int(np.abs(mean).argmax())
            stress = self.stress(xi, eta)[0][ring][..., fibre].reshape(-1, 1) * np.eye(6)[0]
            places = (self.positions(xi)[ring] - self.positions(NODES)[here][0]).reshape(-1, 3)
            found.append(Patch(places, stress, mean[fibre] * np.eye(6)[0], 2))
        return found

    def drawn(self, eta: np.ndarray, rib: int | None = None) -> np.ndarray:
        """Return the stress of the points by which beams are drawn, of one or of all, shape (T, 4 m p)."""
        stress = self.stress(NODES, eta)[:, :, HALVES]
        if rib is not None:
            stress[:, self.ribs.of_line != rib] = np.nan
        return stress.reshape(len(eta), -1)

    def drawn_tensors(self, eta: np.ndarray) -> np.ndarray:
        """Return the same in components of G, shape (T, 4 m p, 6)."""
        stress = self.drawn(eta).reshape(len(eta), len(self.table), -1)
        return (stress[..., None] * self._dyads[:, None]).reshape(len(eta), -1, 6)

    def scalar(self, quantity: str, eta: np.ndarray, rib: int | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Return the worst of the fibres at the nodes of the lines (T, m, 3), and along the lines (T, m).

        Raises
        ------
        ModelError
            If one was chosen whose section has no shape.
        """
        if rib is not None and not self.ribs.has_shape[rib]:
            raise ModelError(
                f"the section of the stiffener {self.names[rib]!r} has constants but no shape, so the stress of its "
                "fibres is unknown. Remedy: SolidCircle, Tube, Rectangle or Box, or recover(...).section_forces()"
            )
        shown = np.full(len(self.table), True) if rib is None else self.ribs.of_line == rib
        size = max(1, CHUNK // (3 * self.ribs.fibres.shape[1] * len(self.table)))
        worst = worst_of(quantity)
        found = np.full((len(eta), len(self.table), 3), np.nan)
        for first in range(0, len(eta), size):
            values = UNIAXIAL[quantity](self.stress(NODES, eta[first : first + size])[:, shown])
            found[first : first + size, shown] = worst.reduce(values, axis=-1)
        return found, worst.reduce(found, axis=-1)
