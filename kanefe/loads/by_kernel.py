"""Calls of the kernels of loads from Python, with ends and states as numbers.

Kernels of the package are called here as plain Python functions. They also accept complex numbers, for exact
derivatives by complex steps (Squire & Trapp 1998).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from kanefe.frames import Vector
from kanefe.kernels.compiler.addresses import call_in_python
from kanefe.kernels.force_elements.places import END_NUMBERS, WRENCH, WRENCHES, A, P, V
from kanefe.loads.action import NO_STATES, End, LoadKernel, Tangent

Kernel = Callable[..., None] | int

COMPLEX_STEP = 1e-30
"""Imaginary step relative to one: its square vanishes, so that there is neither truncation nor cancellation."""

AXES = 3

ROUND_OFF = 1e-12
"""Stiffness or damping, relative to the largest of a load, that counts as zero."""


def numbers_of(ends: Sequence[End]) -> list[Any]:
    """Return the motions of the ends as one list of numbers: see `kanefe.LoadKernel`."""
    return [x for end in ends for part in (end.p, end.A.ravel(), end.v, end.w) for x in part.tolist()]


def written_by(
    function: Kernel, t: float, numbers: Vector, inputs: Vector, ends: list[Any], states: Vector, count: int
) -> list[Any]:
    """Return the first `count` numbers that a kernel writes, from the numbers of its ends: see `kanefe.LoadKernel`."""
    if callable(function):
        out: list[Any] = [0.0] * count
        with np.errstate(all="ignore"):  # like compiled code, which returns infinities and NaN without a warning
            function(t, numbers.tolist(), inputs.tolist(), ends, states.tolist(), out)
        return out
    kind = complex if any(isinstance(x, complex) for x in ends) else float
    found = np.zeros(count, dtype=kind)
    call_in_python(function, (t, numbers, inputs, np.array(ends, dtype=kind), states.astype(kind), found))
    return found.tolist()


class HasKernel(Protocol):
    """A load that may have a kernel."""

    @property
    def name(self) -> str:
        """Unique among the loads between frames of a scene."""
        ...

    @property
    def kernel(self) -> LoadKernel | None:
        """Its compiled function and numbers."""
        ...

    @property
    def input_count(self) -> int:
        """Number of inputs from Python to compiled code in each evaluation."""
        ...

    def inputs(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return these inputs, (`input_count`,)."""
        ...


@dataclass(frozen=True, eq=False)
class EventByKernel:
    """The function of an event of a load by its `LoadKernel.watch`, as an object that can be pickled.

    Attributes
    ----------
    load : Load
    watch : function
        A kernel of `kanefe.kernels`.
    place : int
        Index of the number among those that it writes.
    """

    load: HasKernel
    watch: Callable[..., None]
    place: int

    def __call__(self, t: float, ends: Sequence[End], states: Vector) -> float:
        """Return the number that passes zero."""
        kernel = self.load.kernel
        if kernel is None:
            raise TypeError(f"{self.load.name!r} has no kernel")
        count = WRENCHES + WRENCH * len(ends)  # kernels may also write to the space of the forces
        inputs = self.load.inputs(t, ends, states) if self.load.input_count else NO_STATES
        return float(written_by(self.watch, t, kernel.numbers, inputs, numbers_of(ends), states, count)[self.place])


@dataclass(frozen=True, eq=False)
class ActionByKernel:
    """An action of an event of a load that its kernel does: see `LoadKernel.change`; an object, so that it pickles.

    Attributes
    ----------
    load : Load
    change : function
        A kernel of `kanefe.kernels`.
    event : int
        Which of the load's events it is.
    """

    load: HasKernel
    change: Callable[..., None]
    event: int

    def __call__(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return the states to continue with."""
        kernel = self.load.kernel
        if kernel is None:
            raise TypeError(f"{self.load.name!r} has no kernel")
        # kernels use the room that their forces have
        out = [0.0, *states.tolist(), *[0.0] * (WRENCHES + WRENCH * len(ends))]
        self.change(t, kernel.numbers.tolist(), [float(self.event)], numbers_of(ends), states.tolist(), out)
        return np.array(out[1 : 1 + len(states)])


def slopes(function: Callable[..., Any], *at: float) -> list[float]:
    """Return the partial derivatives of a function of numbers by each of them, by complex steps."""
    steps = [[complex(x, COMPLEX_STEP * (i == k)) for k, x in enumerate(at)] for i in range(len(at))]
    with np.errstate(all="ignore"):
        return [float(function(*moved).imag) / COMPLEX_STEP for moved in steps]


def resistances(kernel: LoadKernel, t: float, inputs: Vector, ends: Sequence[End], states: Vector) -> Tangent | None:
    """Return stiffness and damping that resist motions of the ends; None: there are none.

    They are the symmetric parts of the derivatives of the complex kernel, along their principal directions, without
    negative ones. Complex steps stay in the present branch of the law.
    """
    if kernel.complex_ is None:
        return None
    at, count, function = numbers_of(ends), WRENCH * len(ends), kernel.complex_

    def forces(moved: dict[int, float]) -> Vector:
        """Return the derivative of all wrenches along a change of the numbers of the ends."""
        own = [complex(x, COMPLEX_STEP * moved.get(i, 0.0)) for i, x in enumerate(at)]
        found = written_by(function, t, kernel.numbers, inputs, own, states, WRENCHES + count + len(states))
        return np.asarray(np.imag(found[WRENCHES : WRENCHES + count]) / COMPLEX_STEP)

    K, C = np.zeros((2, count, count))
    for i in range(len(ends)):
        first = END_NUMBERS * i
        for c in range(WRENCH):
            moved = {first + P + c: 1.0} if c < AXES else _turned(at, first + A, c - AXES)
            K[:, WRENCH * i + c], C[:, WRENCH * i + c] = -forces(moved), -forces({first + V + c: 1.0})
    parts = [np.linalg.eigh(0.5 * (matrix + matrix.T)) for matrix in (K, C)]
    rows, of_k, of_c = [], [], []
    for which, (values, along) in enumerate(parts):
        for value, row in zip(values, along.T, strict=True):
            if value > ROUND_OFF * np.abs(values).max():
                rows.append(row)
                of_k.append(value * (which == 0))
                of_c.append(value * (which == 1))
    return Tangent(np.array(rows), np.array(of_k), np.array(of_c)) if rows else None


def _turned(at: list[float], first: int, axis: int) -> dict[int, float]:
    """Return the rates of the entries of a rotation matrix, row by row, that rotates about an axis of N by 1 rad/s."""
    one, other = first + AXES * ((axis + 1) % AXES), first + AXES * ((axis + 2) % AXES)
    return {one + c: -at[other + c] for c in range(AXES)} | {other + c: at[one + c] for c in range(AXES)}
