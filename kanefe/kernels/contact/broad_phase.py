"""A broad phase: which of many balls overlap, found by sorting them along an axis and sweeping over it.

Nothing is kept from one state to the next: what is found depends on the state alone, and no pair is ever missed.
"""

from typing import Any

import numpy as np

from kanefe.kernels.language import inlined, kernel

BALL = 4
"""Number of values of a ball in a list: centre and radius; for complex lists the real parts count."""


@kernel
def sort_by(keys: np.ndarray, order: np.ndarray, count: int) -> None:
    """Sort the numbers of things, in `order`, by their keys, in place (Shell's sort, gaps of Tokuda)."""
    gap = 1
    while 9 * gap < 4 * count:
        gap = (9 * gap) // 4 + 1
    while gap > 0:
        sift(keys, order, count, gap)
        gap = 0 if gap == 1 else max(1, (4 * gap) // 9)


@kernel
def sift(keys: np.ndarray, order: np.ndarray, count: int, gap: int) -> None:
    """Bring things that are so far apart in the order into the order of their keys; 1: all of them."""
    for i in range(gap, count):
        moved = order[i]
        key, j = keys[int(moved.real)].real, i
        while j >= gap and keys[int(order[j - gap].real)].real > key:
            order[j] = order[j - gap]
            j -= gap
        order[j] = moved


@kernel
def sort_along_widest(balls: np.ndarray, count: int, keys: np.ndarray, order: np.ndarray) -> int:
    """Sort balls by where they begin along the axis over which they are spread most; return the axis.

    Parameters
    ----------
    balls : ndarray, shape (BALL count or more,)
    count : int
    keys, order : ndarray, shape (count,)
        Where each ball begins, and the numbers of the balls in order.
    """
    widest, spread = 0, -1.0
    for axis in range(3):
        low = high = balls[axis].real
        for b in range(1, count):
            x = balls[BALL * b + axis].real
            low, high = min(low, x), max(high, x)
        if high - low > spread:
            widest, spread = axis, high - low
    for b in range(count):
        keys[b] = balls[BALL * b + widest].real - balls[BALL * b + 3].real
        order[b] = b
    sort_by(keys, order, count)
    return widest


@inlined
def first_from(numbers: np.ndarray, least: int) -> int:
    """Return the first place in a rising list of what is not below a number."""
    low, high = 0, len(numbers)
    while low < high:
        middle = (low + high) // 2
        if numbers[middle] < least:
            low = middle + 1
        else:
            high = middle
    return low


@inlined
def overlap(balls: np.ndarray, a: int, b: int) -> Any:
    """Return whether two balls overlap."""
    x = balls[BALL * a].real - balls[BALL * b].real
    y = balls[BALL * a + 1].real - balls[BALL * b + 1].real
    z = balls[BALL * a + 2].real - balls[BALL * b + 2].real
    r = balls[BALL * a + 3].real + balls[BALL * b + 3].real
    return x * x + y * y + z * z <= r * r
