"""What is computed for all states of a run at once: motions of frames, energies, forces."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from kanefe.frames import Matrix

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame

OutputFunction = Callable[..., None] | int
"""A function of the signature of `kanefe.LoadKernel`, or its address."""


class FrameMotions(NamedTuple):
    """Motion of a frame F at T times; all but the axes in components of N.

    Attributes
    ----------
    position : ndarray, shape (T, 3)
        m.
    axes : ndarray, shape (T, 3, 3)
        A_NF.
    velocity, angular_velocity : ndarray, shape (T, 3)
        m/s and rad/s.
    acceleration, angular_acceleration : ndarray, shape (T, 3), or None
        m/s2 and rad/s2; None if they were not requested.
    """

    position: Matrix
    axes: np.ndarray
    velocity: Matrix
    angular_velocity: Matrix
    acceleration: Matrix | None
    angular_acceleration: Matrix | None


class RunForces(Protocol):
    """Forces of T states of a run: of joints, drives, loops and loads, and parts of those at interfaces.

    Attributes
    ----------
    reactions : ndarray, shape (T, bodies, 6)
        Wrench of each joint on its body, about the origin of the body's frame, in its axes.
    driving : ndarray, shape (T, driven)
        Forces on the driven coordinates.
    loops : ndarray, shape (T, loops, 6)
        Wrench of each constraint with two ends on its end b, about its origin, in its axes.
    gears : ndarray, shape (T, coordinates of all gears)
        Force of each coupler on each coordinate that it couples.
    """

    @property
    def reactions(self) -> np.ndarray:
        """See above."""
        ...

    @property
    def driving(self) -> Matrix:
        """See above."""
        ...

    @property
    def loops(self) -> np.ndarray:
        """See above."""
        ...

    @property
    def gears(self) -> Matrix:
        """See above."""
        ...

    def part(self, number: int) -> Matrix:
        """Return a part of the force at an interface, by its number among `parts_of`, in axes of G, (T, 6)."""
        ...

    def on_end(self, number: int, end: int) -> Matrix:
        """Return the wrench of a load between frames on one of its ends, in N, (T, 6)."""
        ...

    def contact(self, number: int) -> Matrix:
        """Return the outputs of a rigid contact, by its number among these, (T, 12)."""
        ...

    def contact_points(self, number: int) -> np.ndarray:
        """Return those of its points, (T, points, 12)."""
        ...


class RunSweeps(Protocol):
    """Quantities that a route computes for all states of a run at once."""

    @property
    def rates(self) -> Matrix:
        """The rates dy/dt of all states, (T, state and quadratures)."""
        ...

    @property
    def balances(self) -> Matrix:
        """Kinetic, elastic and gravity energy (J), linear and angular momentum about N's origin, (T, 9)."""
        ...

    @property
    def forces(self) -> RunForces:
        """All forces."""
        ...

    def outputs_of_loads(self, functions: Mapping[int, tuple[OutputFunction, int]]) -> dict[int, Matrix]:
        """Return what compiled functions, and how many outputs they write, tell of loads, by their numbers."""
        ...

    def frame(self, number: int, interface: InterfaceFrame | None, is_accelerated: bool = False) -> FrameMotions:
        """Return the motion of a body's frame or of one of its interfaces."""
        ...

    def rotation(self, number: int, interface: InterfaceFrame | None) -> Matrix:
        """Return the Euler parameters of a frame, (T, 4), with signs that do not depend on the choice of times."""
        ...
