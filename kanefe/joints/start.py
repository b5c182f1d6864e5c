"""The start of a joint: numbers that are given and kept, guesses that may move, and None for what follows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Vector, numbers, orientation_parameters


@dataclass(frozen=True)
class Guess:
    """A start near which loops are closed, and which moves with them: it chooses the branch of a mechanism.

    A plain number in its place is kept; None is a guess of zero. It stands for a position, an orientation or a speed of
    any joint, or for one of several of them.

    Parameters
    ----------
    value : float or array_like
        rad, m, rad/s or m/s; an orientation.

    Raises
    ------
    ModelError
        If it is None or a guess: what it is put for says what shape it must have.

    Examples
    --------
    The elbow of an arm bends to the left:

    >>> import kanefe as kf
    >>> elbow = kf.Revolute("z", position=kf.Guess(0.8))
    """

    value: Any

    def __post_init__(self) -> None:
        if self.value is None or isinstance(self.value, Guess):
            raise ModelError(f"a Guess takes numbers, not {self.value!r}. Remedy: Guess(0.8), or None without Guess")


Start = float | Guess | None
"""A coordinate or speed of a joint at the start: given, near, or not given."""

Starts = Sequence[Start] | Guess | None
"""Several of them."""


def start_values(value: object, count: int, what: str) -> Vector:
    """Return `count` finite numbers of a joint's start, zero for None; a ModelError names them as `what`."""
    array = numbers(_plain(value, count))
    if array.shape != (count,) or not np.all(np.isfinite(array)):
        raise ModelError(f"{what} must be {count} finite numbers, Guess(...) or None, not {value!r}")
    return array


def start_value(value: object, what: str) -> float:
    """Return one finite number of a joint's start, zero for None; a ModelError names it as `what`."""
    array = numbers(0.0 if value is None else value.value if isinstance(value, Guess) else value)
    if array.shape != () or not np.isfinite(array):
        raise ModelError(f"{what} must be one finite number, Guess(...) or None; got {value!r}")
    return float(array)


def start_orientation(value: object, what: str) -> Vector:
    """Return unit Euler parameters of a joint's start, without rotation for None; a ModelError names it as `what`."""
    if value is None:
        return np.array((1.0, 0.0, 0.0, 0.0))
    return orientation_parameters(value.value if isinstance(value, Guess) else value, what)


def is_given(value: object) -> bool:
    """Return whether a coordinate, speed or orientation is given, and kept: neither None nor a guess."""
    return not (value is None or isinstance(value, Guess))


def are_given(value: object, count: int) -> list[bool]:
    """Return which of `count` coordinates or speeds are given."""
    if is_given(value) and isinstance(value, (tuple, list)) and len(value) == count:
        return [is_given(one) for one in value]
    return [is_given(value)] * count


def _plain(value: object, count: int) -> object:
    """Return a start with numbers in place of None and guesses."""
    if value is None:
        return np.zeros(count)
    if isinstance(value, Guess):
        return value.value
    if isinstance(value, (tuple, list)):
        return [0.0 if one is None else one.value if isinstance(one, Guess) else one for one in value]
    return value
