"""Where a load between frames finds the motion of its ends, and where it writes what it does."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from kanefe.kernels.addresses import COMPLEX_NUMBERS, NUMBER, NUMBERS, house_address

# Of an end, in components of N
P, A, V, W = 0, 3, 12, 15
END_NUMBERS = 18

# Of what is written; then force and moment of each end, then the rates of the states
POTENTIAL, TAKEN, GIVEN, WRENCHES = range(4)
WRENCH = 6


def addresses(real: Callable[..., Any] | int, complex_: Callable[..., Any] | int | None) -> tuple[int, int]:
    """Return the addresses of a load's function for real and for complex numbers, 0 if there is none for them.

    Functions are those of the house, compiled when they are first used; whole numbers are addresses already.
    """
    return _address(real, NUMBERS), 0 if complex_ is None else _address(complex_, COMPLEX_NUMBERS)


def _address(function: Callable[..., Any] | int, numbers: str) -> int:
    if isinstance(function, int):
        return function
    return house_address(function, NUMBER, NUMBERS, NUMBERS, numbers, numbers, numbers)
