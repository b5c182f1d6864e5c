"""A normal force by a table: measured pads, stops that stiffen, layers."""

from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.kernels.contact.laws.normal_law import NormalForce, NormalLaw, Pressing, not_negative
from kanefe.kernels.language import Behind, Record, Rows, inlined

TABLE = 2.0


class Piece(Record):
    """A cubic piece: its start (m), coefficients of the powers of the depth beyond, the energy (J) up to its start."""

    start: float
    force: float
    a: float
    b: float
    c: float
    energy: float


Pieces = Rows[Piece]


class TableNumbers(Record):
    """Numbers of `TableLaw`: s/m, how many pieces there are, and these."""

    damping: float
    length: float
    pieces: Annotated[Any, Behind()]


@inlined
def by_table(numbers: Any, at: int, point: Pressing) -> NormalForce:
    """Return what a table with damping gives: see `NormalLaw.law`."""
    own = TableNumbers(numbers, at)
    elastic, energy = of_pieces(Pieces(own.pieces), int(own.length), point)
    return NormalForce(elastic * (1.0 + own.damping * point.rate), elastic, energy, 0.0 * point.rate)


@inlined
def of_pieces(pieces: Pieces, count: int, point: Pressing) -> tuple[Any, Any]:
    """Return the elastic force and its energy by cubic pieces."""
    i = 0
    while i < count - 1 and point.depth.real > pieces[i + 1].start:
        i += 1
    piece = pieces[i]
    f0, a, b, c, s = piece.force, piece.a, piece.b, piece.c, point.depth - piece.start
    force = f0 + s * (a + s * (b + s * c))
    energy = piece.energy + s * (f0 + s * (0.5 * a + s * (b / 3.0 + 0.25 * s * c)))
    return point.share * force, point.share * energy


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

    kind = TABLE
    numbers = TableNumbers
    law = staticmethod(by_table)
    stiffness: float = 0.0
    damping: float = 0.0
    # two laws are one where these are
    depths: tuple[float, ...] = ()
    forces: tuple[float, ...] = ()
    pieces: np.ndarray = field(default_factory=lambda: np.zeros((0, Piece.number_count)), compare=False, repr=False)

    def __init__(self, depths: Any, forces: Any, damping: float = 0.0) -> None:
        self._set(**tabulated(depths, forces, "of TableLaw"), damping=not_negative(damping, "damping of TableLaw"))

    @property
    def length(self) -> int:
        """Number of pieces."""
        return len(self.pieces)


def tabulated(depths: Any, forces: Any, label: str) -> dict[str, Any]:
    """Return the attributes of a law by a table; a ModelError says what is wrong with it."""
    d, f = numbers(depths), numbers(forces)
    if d.ndim != 1 or d.shape != f.shape or not len(d) or not np.all(np.isfinite((d, f))):
        raise ModelError(f"depths and forces {label} must be as many finite numbers, at least one")
    if d[0] > 0.0:
        d, f = np.append(0.0, d), np.append(0.0, f)
    if d[0] < 0.0 or f[0] != 0.0 or len(d) < 2:
        raise ModelError(f"a table {label} must start with zero force at zero depth, not {f[0]:g} N at {d[0]:g} m")
    if np.any(np.diff(d) <= 0.0) or np.any(np.diff(f) < 0.0) or f[-1] <= 0.0:
        raise ModelError(f"depths {label} must rise, and forces must not fall. Remedy: sort them, smooth them")
    stiffness, of_table = float(f[-1] / d[-1]), {"depths": tuple(d.tolist()), "forces": tuple(f.tolist())}
    return {"stiffness": stiffness, "pieces": _pieces(d, f), **of_table}


def _pieces(d: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Return the pieces of a table, (n, PIECE), the last one straight."""
    from scipy.interpolate import PchipInterpolator

    curve = PchipInterpolator(d, f)
    c, b, a, f0 = curve.c
    h = np.diff(d)
    energy = np.cumsum(h * (f0 + h * (a / 2.0 + h * (b / 3.0 + h * c / 4.0))))
    found = np.zeros((len(d), Piece.number_count))
    found[:-1] = np.column_stack((d[:-1], f0, a, b, c, np.append(0.0, energy[:-1])))
    found[-1] = d[-1], f[-1], float(curve(d[-1], 1)), 0.0, 0.0, energy[-1]
    return found
