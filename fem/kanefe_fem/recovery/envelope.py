"""Scalars of stress and strain (von Mises, Tresca, principal values), and their extremes over time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from kanefe.errors import ModelError
from kanefe.storage.watched import long_work
from kanefe_fem.recovery.strain_fields import CHUNK, StrainFields

COMPONENTS = ("xx", "yy", "zz", "yz", "xz", "xy")
"""Order of the components of stress and strain; shear strains are engineering strains, 2 e_yz."""


def von_mises(stress: np.ndarray) -> np.ndarray:
    """Return von Mises' equivalent stress, shape (...,), from stresses of shape (..., 6).

    Examples
    --------
    >>> von_mises(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])).round(6)
    1.732051
    """
    xx, yy, zz, yz, xz, xy = np.moveaxis(np.asarray(stress, dtype=float), -1, 0)
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.asarray(np.sqrt(0.5 * normal + 3.0 * (yz**2 + xz**2 + xy**2)))


def principal(stress: np.ndarray) -> np.ndarray:
    """Return the principal values, greatest first, shape (..., 3), of stresses (..., 6)."""
    tensors = tensor(stress)
    known = np.isfinite(tensors).all(axis=(-1, -2))  # fields are NaN outside of a chosen material
    values = np.linalg.eigvalsh(np.where(known[..., None, None], tensors, 0.0))[..., ::-1]
    return np.where(known[..., None], values, np.nan)


def principal_strains(strain: np.ndarray) -> np.ndarray:
    """Return the principal strains, greatest first, shape (..., 3), of strains (..., 6) with engineering shears."""
    return principal(strain * np.array([1.0, 1.0, 1.0, 0.5, 0.5, 0.5]))


def tresca(stress: np.ndarray) -> np.ndarray:
    """Return Tresca's equivalent stress, the difference of the greatest and least principal value, shape (...,)."""
    values = principal(stress)
    return np.asarray(values[..., 0] - values[..., 2])


def tensor(components: np.ndarray) -> np.ndarray:
    """Return the symmetric tensors (..., 3, 3) of components (..., 6)."""
    return np.asarray(components)[..., [[0, 5, 4], [5, 1, 3], [4, 3, 2]]]


def along(direction: np.ndarray) -> np.ndarray:
    """Return the row (6,) that takes strains to the strain along a unit direction (3,)."""
    x, y, z = direction
    return np.array([x * x, y * y, z * z, y * z, x * z, x * y])


Scalar = Literal["von_mises", "tresca", "max_principal", "min_principal", "max_shear"]


SCALARS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "von_mises": von_mises,
    "tresca": tresca,
    "max_principal": lambda stress: principal(stress)[..., 0],
    "min_principal": lambda stress: principal(stress)[..., 2],
    "max_shear": lambda stress: 0.5 * tresca(stress),
}
"""Scalar functions of the stress, Pa."""


TITLES = {
    "von_mises": "von Mises stress",
    "tresca": "Tresca stress",
    "max_principal": "greatest principal stress",
    "min_principal": "least principal stress",
    "max_shear": "greatest shear stress",
}


@dataclass(frozen=True, eq=False)
class Envelope:
    """Extreme values of a scalar over time.

    Attributes
    ----------
    quantity : str
    values : ndarray, shape (n,) or (cells,)
        Greatest value over time at each node or cell, Pa; the least for "min_principal".
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
    if quantity not in SCALARS:
        raise ModelError(f"there is no envelope of {quantity!r}. There are: {', '.join(SCALARS)}")
    if at not in ("nodes", "cells"):
        raise ModelError(f"an envelope is at 'nodes' or 'cells', not {at!r}")
    positions = fields.nodes if at == "nodes" else fields.centroids
    sign = -1.0 if quantity == "min_principal" else 1.0
    best, when = np.full(len(positions), -np.inf), np.zeros(len(positions), dtype=np.int64)
    step = max(1, CHUNK // (6 * len(positions)))
    for first in long_work(f"envelope of {quantity}", range(0, len(eta), step)):
        values = sign * SCALARS[quantity](fields.evaluate("stress", at, eta[first : first + step], material))
        local = values.argmax(axis=0)
        top = np.take_along_axis(values, local[None], axis=0)[0]
        better = ~(top <= best)  # true for NaN, outside of the material
        best[better], when[better] = top[better], first + local[better]
    if at == "cells":
        best[~fields.chosen_cells(material)] = np.nan
    return Envelope(quantity, sign * best, times[when], positions)
