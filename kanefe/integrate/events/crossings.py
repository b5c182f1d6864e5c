"""Where a function of one number passes zero: what scipy has for that takes longer to import than a short run."""

from __future__ import annotations

import math
from collections.abc import Callable


def crossing_between(f: Callable[[float], float], a: float, b: float, ends: tuple[float, float], width: float) -> float:
    """Return where a function passes zero between a and b, to a width, by Chandrupatla's method.

    Inverse quadratic interpolation where three points let it be trusted, else halves (T. R. Chandrupatla, Advances in
    Engineering Software 28 (1997) 145-149).

    Parameters
    ----------
    f : function
    a, b : float
    ends : (float, float)
        Its values there, of different signs or zero.
    width : float
        Of the interval that is left.
    """
    fa, fb = ends
    if fa == 0.0 or fb == 0.0:
        return a if fa == 0.0 else b
    share = 0.5
    while True:
        x = a + share * (b - a)
        fx = f(x)
        if (fx > 0.0) == (fa > 0.0):
            c, fc = a, fa
        else:
            c, fc, b, fb = b, fb, a, fa
        a, fa = x, fx
        best, value = (a, fa) if abs(fa) < abs(fb) else (b, fb)
        if value == 0.0 or abs(b - a) <= width:
            return best
        least = 0.5 * width / abs(b - a)
        place, height = (a - b) / (c - b), (fa - fb) / (fc - fb)
        share = 0.5
        if height**2 < place and (1.0 - height) ** 2 < 1.0 - place:
            share = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        share = min(1.0 - least, max(least, share)) if math.isfinite(share) else 0.5
