"""Extremes of scalars of the stress over time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from kanefe.errors import ModelError
from kanefe.storage.watched import long_work
from kanefe_fem.recovery.scalars import FAILURES, Scalar
from kanefe_fem.recovery.strain_fields import CHUNK, StrainFields


@dataclass(frozen=True, eq=False)
class Envelope:
    """Extreme values of a scalar over time.

    Attributes
    ----------
    quantity : str
    values : ndarray, shape (n,) or (cells,)
        Greatest value over time at each node or cell, Pa (failure indices: 1); the least for "min_principal".
    times : ndarray, shape (n,) or (cells,)
        Time of each value, s.
    positions : ndarray, shape (n, 3) or (cells, 3)
        Positions of the nodes, or of the centres of the cells, in G, m.
    error_at : callable
        Function of a node and a time that gives `mesh_error`.
    """

    quantity: str
    values: np.ndarray
    times: np.ndarray
    positions: np.ndarray
    error_at: Callable[[int, float], float]

    @property
    def where(self) -> int:
        """Number of the node or cell with the overall extreme."""
        return int(np.nanargmin(self.values) if self.quantity == "min_principal" else np.nanargmax(self.values))

    @property
    def peak(self) -> float:
        """Overall extreme, Pa."""
        return float(self.values[self.where])

    @property
    def peak_time(self) -> float:
        """Time of the overall extreme, s."""
        return float(self.times[self.where])

    @property
    def peak_position(self) -> np.ndarray:
        """Position of the overall extreme, shape (3,), in G, m."""
        return self.positions[self.where]

    @cached_property
    def mesh_error(self) -> float:
        """Estimated error of the stress at the overall extreme due to the size of the cells, relative to it.

        By a fit to the best points of the cells around; see `kanefe_fem.recovery.mesh_error`. Where the stress is
        singular it does not fall as the mesh is refined. NaN of cells, where too few of them are around, and for
        elements that give their stresses at nodes.
        """
        return self.error_at(self.where, self.peak_time)

    def __str__(self) -> str:
        """Return the overall extreme in words."""
        value = f"{self.peak:.3g}" if self.quantity in FAILURES else f"{self.peak / 1e6:.4g} MPa"
        place = ", ".join(f"{x:.4g}" for x in self.peak_position)
        error = "not known" if np.isnan(self.mesh_error) else f"about {100.0 * self.mesh_error:.2g} %"
        return f"{self.quantity} {value} at {self.peak_time:.6g} s, at ({place}) m; error of the mesh {error}"


def envelope_of(
    fields: StrainFields,
    eta: np.ndarray,
    times: np.ndarray,
    quantity: Scalar,
    at: Literal["nodes", "cells"],
    material: int | None,
) -> Envelope:
    """Return the extremes of a scalar of the stress over coordinates (T, k) at times (T,).

    Raises
    ------
    ModelError
        If there is no such quantity or place.
    """
    if quantity not in fields.scalars:
        raise ModelError(f"there is no envelope of {quantity!r}. There are: {', '.join(fields.scalars)}")
    if at not in ("nodes", "cells"):
        raise ModelError(f"an envelope is at 'nodes' or 'cells', not {at!r}")
    positions = fields.nodes if at == "nodes" else fields.centroids
    sign = -1.0 if quantity == "min_principal" else 1.0
    best, when = np.full(len(positions), -np.inf), np.zeros(len(positions), dtype=np.int64)
    step = max(1, CHUNK // (6 * len(positions)))
    for first in long_work(f"envelope of {quantity}", range(0, len(eta), step)):
        values = sign * fields.scalar(quantity, at, eta[first : first + step], material)
        local = values.argmax(axis=0)
        top = np.take_along_axis(values, local[None], axis=0)[0]
        better = ~(top <= best)  # true for NaN, outside of the material
        best[better], when[better] = top[better], first + local[better]
    if at == "cells":
        best[~fields.chosen_cells(material)] = np.nan

    def error_at(node: int, time: float) -> float:
        own = eta[[int(np.abs(times - time).argmin())]]
        return error_of_mesh(fields, own, node, material) if at == "nodes" else np.nan

    return Envelope(quantity, sign * best, times[when], positions, error_at)


def error_of_mesh(fields: StrainFields, eta: np.ndarray, node: int | None, material: int | None) -> float:
    """Return the estimated error of the stress at a node for coordinates (1, k), relative to it; NaN: not known.

    None is the node with the largest von Mises stress.
    """
    stress = fields.scalar("von_mises", "nodes", eta, material)[0]
    at = int(np.nanargmax(stress)) if node is None else node
    errors = [patch.error for patch in fields.patches(at, eta, material)]
    return max(errors, default=np.nan) / float(stress[at]) if stress[at] > 0.0 else np.nan
