"""Extremes of scalars of the stress over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from kanefe.errors import ModelError
from kanefe.storage.watched import long_work
from kanefe_fem.recovery.scalars import Scalar
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
    """

    quantity: str
    values: np.ndarray
    times: np.ndarray
    positions: np.ndarray

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
    return Envelope(quantity, sign * best, times[when], positions)
