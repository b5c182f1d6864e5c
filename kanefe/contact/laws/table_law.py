"""A normal force by a table: measured pads, stops that stiffen, layers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from kanefe.contact.laws.normal_laws import NormalLaw, Pressed
from kanefe.errors import ModelError
from kanefe.frames import numbers

TABLE = 2.0
PIECE = 6
"""Numbers of a piece: where it begins (m), the force and the coefficients of the powers of the depth beyond, the energy
up to there (J)."""


@dataclass(frozen=True, init=False)
class TableLaw(NormalLaw):
    """``F = f(d) max(0, 1 + lambda dd/dt)``, f by a table: monotone and smooth between its points, straight beyond.

    Cubic pieces whose slopes keep f monotone (Fritsch and Carlson 1980, as `scipy.interpolate.PchipInterpolator`).

    Parameters
    ----------
    depths : array_like, shape (n,)
        m, ascending, from 0 or above; at depth 0 the force is 0.
    forces : array_like, shape (n,)
        N, not falling; of all points of a contact together, which share them.
    damping : float
        lambda, s/m.

    Raises
    ------
    ModelError
        If the table is none, falls, or does not begin with nothing.

    Examples
    --------
    >>> import kanefe as kf
    >>> pad = kf.TableLaw((1e-3, 2e-3, 3e-3), (10.0, 40.0, 120.0))
    >>> float(pad.pressed(2e-3, 0.0, 1.0, 0.0).force)
    40.0
    """

    kind: ClassVar[float] = TABLE
    # two laws are one where these are
    depths: tuple[float, ...] = ()
    forces: tuple[float, ...] = ()
    pieces: np.ndarray = field(default_factory=lambda: np.zeros((0, PIECE)), compare=False, repr=False)

    def __init__(self, depths: Any, forces: Any, damping: float = 0.0) -> None:
        d, f = numbers(depths), numbers(forces)
        label = "of TableLaw"
        if d.ndim != 1 or d.shape != f.shape or not len(d) or not np.all(np.isfinite((d, f))):
            raise ModelError(f"depths and forces {label} must be as many finite numbers, at least one")
        if d[0] > 0.0:
            d, f = np.append(0.0, d), np.append(0.0, f)
        if d[0] < 0.0 or f[0] != 0.0 or len(d) < 2:
            raise ModelError(f"a table {label} begins with no force at no depth, not {f[0]:g} N at {d[0]:g} m")
        if np.any(np.diff(d) <= 0.0) or np.any(np.diff(f) < 0.0) or f[-1] <= 0.0:
            raise ModelError(f"depths {label} must rise, and forces must not fall. Remedy: sort them, smooth them")
        brake = numbers(damping)
        if brake.shape != () or not np.isfinite(brake) or brake < 0.0:
            raise ModelError(f"damping {label} must be one number, finite and >= 0, not {damping!r}")
        for name, value in (
            ("stiffness", float(f[-1] / d[-1])),
            ("damping", float(brake)),
            ("exponent", 0.0),
            ("restitution", None),
            ("depths", tuple(d.tolist())),
            ("forces", tuple(f.tolist())),
            ("pieces", _pieces(d, f)),
        ):
            object.__setattr__(self, name, value)

    def pressed(self, d: float, rate: float, share: float, damping: float) -> Pressed:
        """Return the force at a depth d > 0 (m) and its rate (m/s) of a point with a share of it."""
        x0, f0, a, b, c, energy = self._piece(d)
        s = d - x0
        elastic = share * (f0 + s * (a + s * (b + s * c)))
        potential = share * (energy + s * (f0 + s * (a / 2.0 + s * (b / 3.0 + s * c / 4.0))))
        return Pressed(elastic * max(0.0, 1.0 + damping * rate), elastic, potential)

    def slope(self, d: float, share: float) -> float:
        """Return how fast the force grows with the depth, N/m."""
        x0, _, a, b, c, _ = self._piece(d)
        s = d - x0
        return float(share * (a + s * (2.0 * b + 3.0 * s * c)))

    def _piece(self, d: float) -> np.ndarray:
        return np.asarray(self.pieces[int(np.searchsorted(self.pieces[1:, 0], d, side="left"))])


def _pieces(d: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Return the pieces of a table, (n, PIECE), the last one straight."""
    from scipy.interpolate import PchipInterpolator

    curve = PchipInterpolator(d, f)
    c, b, a, f0 = curve.c
    h = np.diff(d)
    energy = np.cumsum(h * (f0 + h * (a / 2.0 + h * (b / 3.0 + h * c / 4.0))))
    found = np.zeros((len(d), PIECE))
    found[:-1] = np.column_stack((d[:-1], f0, a, b, c, np.append(0.0, energy[:-1])))
    found[-1] = d[-1], f[-1], float(curve(d[-1], 1)), 0.0, 0.0, energy[-1]
    return found
