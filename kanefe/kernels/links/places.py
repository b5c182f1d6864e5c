"""Where the function of a link writes the motion of its frame M seen from its frame F, in components of F."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from kanefe.kernels.addresses import COMPLEX_NUMBERS, NUMBERS, house_address

# Position, axes of M, partial velocities, and their derivatives by the coordinate
P, A, V, W, DV, DW = 0, 3, 12, 15, 18, 21
MOTION_NUMBERS = 24


def addresses(real: Callable[..., Any] | int, complex_: Callable[..., Any] | int | None) -> tuple[int, int]:
    """Return the addresses of a link's function for real and for complex numbers, 0 if there is none for them.

    Functions are those of the house, compiled when they are first used; whole numbers are addresses already.
    """
    return _address(real, NUMBERS), 0 if complex_ is None else _address(complex_, COMPLEX_NUMBERS)


def _address(function: Callable[..., Any] | int, numbers: str) -> int:
    return function if isinstance(function, int) else house_address(function, NUMBERS, numbers, numbers)
