"""A normal force by a table with hysteresis: bump stops and mounts of rubber or foam, which give back less."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from kanefe.arguments import positive
from kanefe.errors import ModelError
from kanefe.frames import numbers as as_numbers
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.contact.laws.normal_law import NormalLaw
from kanefe.kernels.contact.laws.table_law import PIECE, of_pieces, tabulated
from kanefe.kernels.force_elements.blocks import places

BUMP_STOP = 4.0


class BumpStopNumbers(NamedTuple):
    """Numbers of `BumpStop`, in its words and units, and those of its table."""

    hysteresis: float
    turning: float
    length: float
    pieces: Any


AT = places(BumpStopNumbers)


@inlined
def with_hysteresis(numbers: Any, at: int, share: float, depth: Any, rate: Any, more: Any, branch: Any) -> Any:
    """Return what a table with hysteresis gives: see `NormalLaw.law`."""
    elastic, energy = of_pieces(numbers, int(numbers[at + AT.length]), at + AT.pieces, share, depth)
    speed = rate if rate.real >= 0.0 else -rate
    return (
        elastic * (1.0 + numbers[at + AT.hysteresis] * branch),
        elastic,
        energy,
        (rate - speed * branch) / numbers[at + AT.turning],
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
    law = staticmethod(with_hysteresis)
    has_branch = True
    stiffness: float = 0.0
    damping: float = field(default=0.0, init=False)
    hysteresis: float = 0.0
    turning: float = 0.0
    depths: tuple[float, ...] = ()
    forces: tuple[float, ...] = ()
    pieces: np.ndarray = field(default_factory=lambda: np.zeros((0, PIECE)), compare=False, repr=False)

    def __init__(self, depths: Any, forces: Any, hysteresis: float, turning: float) -> None:
        share = as_numbers(hysteresis)
        if share.shape != () or not 0.0 <= share < 1.0:
            raise ModelError(f"hysteresis of BumpStop must be a number of 0 to below 1, not {hysteresis!r}")
        self._set(**tabulated(depths, forces, "of BumpStop"), damping=0.0, hysteresis=float(share))
        self._set(turning=positive(turning, "turning of BumpStop"))

    @property
    def block(self) -> BumpStopNumbers:
        """Its numbers for compiled code."""
        return BumpStopNumbers(self.hysteresis, self.turning, len(self.pieces), self.pieces)
