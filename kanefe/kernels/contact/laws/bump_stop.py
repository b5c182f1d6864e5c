"""A normal force by a table with hysteresis: bump stops and mounts of rubber or foam, which give back less."""

from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np

from kanefe.arguments import positive
from kanefe.errors import ModelError
from kanefe.frames import numbers as as_numbers
from kanefe.kernels.contact.laws.normal_law import NormalForce, NormalLaw, Pressing
from kanefe.kernels.contact.laws.table_law import Piece, Pieces, of_pieces, tabulated
from kanefe.kernels.language import Behind, Record, inlined

BUMP_STOP = 4.0


class BumpStopNumbers(Record):
    """Numbers of `BumpStop`, in its words and units, and those of its table."""

    hysteresis: float
    turning: float
    length: float
    pieces: Annotated[Any, Behind()]


@inlined
def with_hysteresis(numbers: Any, at: int, point: Pressing) -> NormalForce:
    """Return what a table with hysteresis gives: see `NormalLaw.law`."""
    own, rate, branch = BumpStopNumbers(numbers, at), point.rate, point.branch
    elastic, energy = of_pieces(Pieces(own.pieces), int(own.length), point)
    speed = rate if rate.real >= 0.0 else -rate
    return NormalForce(
        elastic * (1.0 + own.hysteresis * branch), elastic, energy, (rate - speed * branch) / own.turning
    )


@dataclass(frozen=True, init=False)
class BumpStop(NormalLaw):
    """``F = f(d) (1 + hysteresis z)``, f by a table, ``dz/dt = (v - |v| z) / turning`` with the rate v of the depth.

    z is the branch that the point is on: it goes to 1 on the way in and to -1 on the way out, over a depth of `turning`
    and however fast, as Dahl's friction (1968) does. A closed loop of depths loses the area between both branches. A
    point starts in the middle, z = 0, and keeps its branch while it does not touch. In equilibria and small motions
    it is held: the force follows f.

    Parameters
    ----------
    depths : array_like, shape (n,)
        m, ascending, from 0 or above; at depth 0 the force is 0.
    forces : array_like, shape (n,)
        Mean of loading and unloading, N, not falling; of all points of a contact together, which share it.
    hysteresis : float
        Half the difference of both over their mean, 0 to 1.
    turning : float
        Depth over which the force goes from one branch to the other, to a share of exp(-1), m.

    Raises
    ------
    ModelError
        If the table is none, falls, or does not begin with nothing, or a number is out of its range.

    Examples
    --------
    >>> import kanefe as kf
    >>> stop = kf.BumpStop((0.01, 0.02, 0.03), (200.0, 600.0, 3000.0), hysteresis=0.2, turning=1e-3)
    >>> float(stop.pressed(0.02).force)
    600.0
    """

    kind = BUMP_STOP
    numbers = BumpStopNumbers
    law = staticmethod(with_hysteresis)
    has_branch = True
    stiffness: float = 0.0
    damping: float = field(default=0.0, init=False)
    hysteresis: float = 0.0
    turning: float = 0.0
    depths: tuple[float, ...] = ()
    forces: tuple[float, ...] = ()
    pieces: np.ndarray = field(default_factory=lambda: np.zeros((0, Piece.number_count)), compare=False, repr=False)

    def __init__(self, depths: Any, forces: Any, hysteresis: float, turning: float) -> None:
        share = as_numbers(hysteresis)
        if share.shape != () or not 0.0 <= share < 1.0:
            raise ModelError(f"hysteresis of BumpStop must be a number of 0 to below 1, not {hysteresis!r}")
        self._set(**tabulated(depths, forces, "of BumpStop"), damping=0.0, hysteresis=float(share))
        self._set(turning=positive(turning, "turning of BumpStop"))

    @property
    def length(self) -> int:
        """Number of pieces of the table."""
        return len(self.pieces)
