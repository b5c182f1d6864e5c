"""Kernels of loads called from Python: ends and states become numbers, and what is written comes back.

A kernel of the package is a plain function until it is compiled: here it runs as that. Complex numbers pass through it,
from which come exact derivatives (Squire & Trapp 1998).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from kanefe.frames import Vector
from kanefe.kernels.addresses import call_in_python

if TYPE_CHECKING:
    from kanefe.loads.base import End, Load

Kernel = Callable[..., None] | int

COMPLEX_STEP = 1e-30
"""Imaginary part of what is changed: its square vanishes beside 1, so that nothing is cut off and nothing cancels."""


def numbers_of(ends: Sequence[End]) -> list[Any]:
    """Return the motion of ends one after the other, see `kanefe.LoadKernel`."""
    return [x for end in ends for part in (end.p, end.A.ravel(), end.v, end.w) for x in part.tolist()]


def written_by(
    function: Kernel, t: float, numbers: Vector, inputs: Vector, ends: list[Any], states: Vector, count: int
) -> list[Any]:
    """Return the first `count` numbers that a kernel writes, from the numbers of its ends: see `kanefe.LoadKernel`."""
    if callable(function):
        out: list[Any] = [0.0] * count
        with np.errstate(all="ignore"):  # compiled code gives infinities and NaN without a word
            function(t, numbers.tolist(), inputs.tolist(), ends, states.tolist(), out)
        return out
    kind = complex if any(isinstance(x, complex) for x in ends) else float
    found = np.zeros(count, dtype=kind)
    call_in_python(function, (t, numbers, inputs, np.array(ends, dtype=kind), states.astype(kind), found))
    return found.tolist()


class EventByKernel(NamedTuple):
    """A function of an event of a load that its kernel writes: see `LoadKernel.watch`; an object, so that it pickles.

    Attributes
    ----------
    load : Load
    watch : function
        A kernel of `kanefe.kernels`.
    place : int
        Which of the numbers that it writes.
    """

    load: Load
    watch: Callable[..., None]
    place: int

    def __call__(self, t: float, ends: Sequence[End], states: Vector) -> float:
        """Return the number that passes zero."""
        kernel = self.load.kernel
        if kernel is None:
            raise TypeError(f"{self.load.name!r} has no kernel")
        count = 6 * len(ends) + 3  # kernels use the room that their forces have
        return float(written_by(self.watch, t, kernel.numbers, NO_INPUTS, numbers_of(ends), states, count)[self.place])


NO_INPUTS = np.zeros(0)


def slopes(function: Callable[..., Any], *at: float) -> list[float]:
    """Return the partial derivatives of a function of numbers by each of them, by complex steps."""
    steps = [[complex(x, COMPLEX_STEP * (i == k)) for k, x in enumerate(at)] for i in range(len(at))]
    with np.errstate(all="ignore"):
        return [float(np.imag(function(*moved))) / COMPLEX_STEP for moved in steps]
