"""The lowest place of a function of one number: that of scipy takes longer to import than a short run."""

from __future__ import annotations

from collections.abc import Callable

GOLDEN = 0.6180339887498949

CLOSEST = 1e-15
"""Relative distance of two numbers below which there is hardly a number between them."""


def lowest_between(f: Callable[[float], float], a: float, b: float, tolerance: float) -> tuple[float, float]:
    """Return the minimiser of a unimodal function between a and b, by golden sections, and its value there.

    It ends as soon as the value is below zero, or where no numbers lie between.
    """
    tolerance = max(tolerance, CLOSEST * max(abs(a), abs(b)))
    c, d = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
    fc, fd = f(c), f(d)
    while b - a > tolerance and min(fc, fd) >= 0.0:
        if fc < fd:
            b, d, fd = d, c, fc
            c = b - GOLDEN * (b - a)
            fc = f(c)
        else:
            a, c, fc = c, d, fd
            d = a + GOLDEN * (b - a)
            fd = f(d)
    return (c, fc) if fc < fd else (d, fd)
