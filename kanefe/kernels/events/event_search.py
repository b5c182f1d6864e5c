"""Where functions of the state pass zero within a step: brackets between samples, dips between them, and roots.

`value(data, t)` gives the function at a time of the step. In compiled code it is a kernel, in a search from Python any
function: the search is the same.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels.language import exact


class Limits(NamedTuple):
    """From where on numbers count in a search."""

    least_dip: float = 0.3
    """Minimum of the parabola through three samples, relative to their largest, below which it is examined closely."""
    closest: float = 1e-15
    """Distance between two times, relative to their size, below which there is hardly a number between them."""
    fineness: float = 1e-5
    """Accuracy of the minimum of a dip, relative to its width."""
    root_tolerance: float = 1e-13
    """Width of the interval in which a root is found, relative to the span of the run. States have the tolerance of the
    run."""
    at_once: float = 1e-6
    """Time relative to the span within which events that only end steps do so once."""
    noise: float = 10.0
    """Value below which the sign of a function is noise, in multiples of its values about the root found."""
    looks: int = 12
    """Values on either side of a root, at most, till two differ: up to 1e-10 of the span away."""
    round_off: float = 1e-15
    """Value below which the sign of a function is noise, relative to its largest value in the step, if its value at the
    root is zero by chance."""


LIMITS = Limits()

GOLDEN = 0.6180339887498949
"""Fraction of an interval that a golden section leaves."""


EPSILON = float(np.finfo(float).eps)


Value = Callable[[Any, float], float]


class StepSamples(NamedTuple):
    """Samples of a function in a step, from its start to its end.

    Attributes
    ----------
    times, values : ndarray, shape (number or more,)
    number : int
    first : int
        Number of the first value that has a sign.
    """

    times: np.ndarray
    values: np.ndarray
    number: int
    first: int


class Within(NamedTuple):
    """Start and end of a step, and the span of the run, s."""

    start: float
    end: float
    span: float


@exact
def sign_of(x: float) -> float:
    """Return 1, -1 or 0."""
    if x > 0.0:
        return 1.0
    return -1.0 if x < 0.0 else 0.0


@exact
def dips(v0: float, v1: float, v2: float, x: float) -> bool:
    """Return whether the parabola through three values above zero, at -1, x and 1, comes near zero between them."""
    b = 0.5 * (v2 - v0)
    c = (0.5 * (v0 + v2) + b * x - v1) / (1.0 - x * x)
    if not (c > 0.0 and abs(b) < 2.0 * c):
        return False
    lowest = 0.5 * (v0 + v2) - c - b * b / (4.0 * c)
    return bool(lowest <= LIMITS.least_dip * max(v0, v1, v2))


@exact
def dips_from(times: np.ndarray, values: np.ndarray, k: int) -> bool:
    """Return whether three samples from the k-th on have one sign and may come to zero between them."""
    sign = sign_of(values[k])
    v0, v1, v2 = sign * values[k], sign * values[k + 1], sign * values[k + 2]
    if not (v0 > 0.0 and v1 > 0.0 and v2 > 0.0):
        return False
    return dips(v0, v1, v2, 2.0 * (times[k + 1] - times[k]) / (times[k + 2] - times[k]) - 1.0)


@exact
def is_quiet(times: np.ndarray, values: np.ndarray, count: int) -> bool:
    """Return whether so many samples have one sign, and no three of them come near zero."""
    sign = sign_of(values[0])
    if sign == 0.0:
        return False
    for k in range(1, count):
        if not sign * values[k] > 0.0:
            return False
    found = False
    for k in range(count - 2):
        found = found or dips_from(times, values, k)
    return not found


@exact
def crossing_between(
    value: Value, data: Any, left: tuple[float, float], right: tuple[float, float], width: float
) -> float:
    """Return where a function passes zero between two places, to a width, by Chandrupatla's method.

    Inverse quadratic interpolation where three points let it be trusted, else halves (T. R. Chandrupatla, Advances in
    Engineering Software 28 (1997) 145-149).

    Parameters
    ----------
    value : function (data, t) -> float
    left, right : (float, float)
        The places with its values there, of different signs or zero.
    width : float
        Of the interval that is left.
    """
    (a, fa), (b, fb) = left, right
    if fa == 0.0 or fb == 0.0:
        return a if fa == 0.0 else b
    share = 0.5
    while True:
        x = a + share * (b - a)
        fx = value(data, x)
        if (fx > 0.0) == (fa > 0.0):
            c, fc = a, fa
        else:
            c, fc, b, fb = b, fb, a, fa
        a, fa = x, fx
        best, least_value = (a, fa) if abs(fa) < abs(fb) else (b, fb)
        if least_value == 0.0 or not abs(b - a) > width:
            return best
        least = 0.5 * width / abs(b - a)
        place, height = (a - b) / (c - b), (fa - fb) / (fc - fb)
        share = 0.5
        if height * height < place and (1.0 - height) * (1.0 - height) < 1.0 - place:
            share = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        share = min(1.0 - least, max(least, share)) if abs(share) < np.inf else 0.5


@exact
def lowest_between(value: Value, data: Any, sign: float, a: float, b: float, tolerance: float) -> tuple[float, float]:
    """Return where ``sign value`` with one minimum between a and b is lowest, by golden sections, and it there.

    It ends as soon as that is below zero, or where no numbers lie between.
    """
    tolerance = max(tolerance, LIMITS.closest * max(abs(a), abs(b)))
    c, d = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
    fc, fd = sign * value(data, c), sign * value(data, d)
    while b - a > tolerance and min(fc, fd) >= 0.0:
        if fc < fd:
            b, d, fd = d, c, fc
            c = b - GOLDEN * (b - a)
            fc = sign * value(data, c)
        else:
            a, c, fc = c, d, fd
            d = a + GOLDEN * (b - a)
            fd = sign * value(data, d)
    return (c, fc) if fc < fd else (d, fd)


@exact
def first_with_sign(values: np.ndarray, count: int, noise: float) -> int:
    """Return the number of the first value that has a sign; that of the last one if none has."""
    for k in range(count):
        if abs(values[k]) > noise:
            return k
    return count - 1


@exact
def find_brackets(value: Value, data: Any, of: StepSamples, direction: int, brackets: np.ndarray) -> int:
    """Write the intervals at whose ends a function has different signs, in order of time; return how many.

    A value of zero ends an interval, unless the function is back on its side at the next one. After an event the values
    have no sign until the first that has one: the place that was found lies before the root as often as behind it.

    Parameters
    ----------
    of : StepSamples
    direction : int
        1 where only rising through zero counts, -1 where only falling, else 0.
    brackets : ndarray, shape (2 count, 2)
    """
    found, (times, values, count, first) = 0, of
    last_time, last = 0.0, 0.0
    for k in range(first, count):
        if last != 0.0 and k + 1 < count and values[k] == 0.0 and sign_of(values[k + 1]) == sign_of(last):
            continue
        is_zero = last != 0.0 and sign_of(values[k]) != sign_of(last)
        if is_zero and last * direction <= 0.0:
            found = insert(brackets, found, last_time, times[k])
        last_time, last = times[k], values[k]
    after = times[0]
    for k in range(first, count - 2):
        if times[k] < after or not dips_from(times, values, k):
            continue
        a, b, sign = times[k], times[k + 2], sign_of(values[k])
        lowest, height = lowest_between(value, data, sign, a, b, LIMITS.fineness * (b - a))
        if height < 0.0:
            if sign * direction <= 0.0:
                found = insert(brackets, found, a, lowest)
            if sign * direction >= 0.0:
                found = insert(brackets, found, lowest, b)
            after = b
    return found


@exact
def insert(pairs: np.ndarray, count: int, a: float, b: float) -> int:
    """Put in a pair at its place among so many that rise; return how many there are then."""
    k = count
    while k > 0 and (pairs[k - 1, 0] > a or (pairs[k - 1, 0] == a and pairs[k - 1, 1] > b)):
        pairs[k, 0], pairs[k, 1] = pairs[k - 1, 0], pairs[k - 1, 1]
        k -= 1
    pairs[k, 0], pairs[k, 1] = a, b
    return count + 1


@exact
def time_tolerance(span: float, t: float) -> float:
    """Return how near to each other two moments are one, s."""
    return max(LIMITS.root_tolerance * span, 4.0 * EPSILON * abs(t))


@exact
def is_known(t: float, last: float, span: float) -> bool:
    """Return whether an event happened at a time that is that of its last one (s)."""
    return t - last <= 2.0 * time_tolerance(span, t)


@exact
def is_over(t: float, last: float, span: float) -> bool:
    """Return whether an event that only ends steps has just done so: contacts at rest touch again and again."""
    return t - last <= LIMITS.at_once * span


@exact
def root_in(value: Value, data: Any, a: float, b: float, span: float, is_beyond: bool) -> float:
    """Return where a function passes zero between a and b; on request where it has its new sign.

    A step from there on has a force that jumps behind it: rates that change sides within it have no solution.
    """
    fa, fb = value(data, a), value(data, b)
    if fa * fb > 0.0:  # at one of the ends, but for round-off
        return a if abs(fa) < abs(fb) else b
    tolerance = time_tolerance(span, b)
    found = crossing_between(value, data, (a, fa), (b, fb), tolerance)
    ahead = tolerance
    while is_beyond and found < b and value(data, found) * fb <= 0.0:
        found, ahead = min(found + ahead, b), 2.0 * ahead  # where it stays at zero the way is long
    return found


class Sought(NamedTuple):
    """What is looked for in a step: when a function passes zero.

    Attributes
    ----------
    direction : int
        1 where only rising through zero counts, -1 where only falling, else 0.
    noise : float
        Value below which it has no sign.
    is_bound : bool
        Whether it must not be below zero: that happens wherever it is.
    is_beyond : bool
        Whether the time is wanted from which on it has its new sign.
    span : float
        Of the run, s.
    """

    direction: int
    noise: float
    is_bound: bool
    is_beyond: bool
    span: float


@exact
def is_still(of: StepSamples, is_bound: bool) -> bool:
    """Return whether nothing happens in a step by what is seen of a function in it."""
    return is_quiet(of.times, of.values, of.number) and not (is_bound and of.values[0] < 0.0)


@exact
def zeros_of(value: Value, data: Any, raised: Any, of: StepSamples, wanted: Sought, zeros: np.ndarray) -> int:
    """Write when a function passes zero in a step, in order of time; return how often.

    Parameters
    ----------
    data, raised : any
        Of the function, and of the same above zero by its noise.
    of : StepSamples
        All of them.
    wanted : Sought
    zeros : ndarray, shape (2 count, 2)
        Its first column.
    """
    times, values, count, _ = of
    first, found, asked = first_with_sign(values, count, wanted.noise), 1, data
    if wanted.is_bound and values[first] < -wanted.noise:
        asked, zeros[0, 0], zeros[0, 1] = raised, times[max(first - 1, 0)], times[first]
    else:
        found = find_brackets(value, data, StepSamples(times, values, count, first), wanted.direction, zeros)
    for k in range(found):
        zeros[k, 0] = root_in(value, asked, zeros[k, 0], zeros[k, 1], wanted.span, wanted.is_beyond)
    return found


@exact
def noise_after(value: Value, data: Any, root: float, within: Within, largest: float) -> float:
    """Return below what a function has no sign after its root; of one that jumps across zero that is round-off.

    `largest` is the largest value of the function in the step. Of one place alone the
    value can be zero by chance, and some be the same: three are seen on either side, and more farther away until two
    differ. What differs between neighbours is noise, or a slope; where a function jumps across zero they have other
    signs.
    """
    tolerance = time_tolerance(within.span, root)
    before, behind, differ = 0.0, 0.0, 0.0
    for side in range(2):
        largest_of_side, last, of_side = 0.0, 0.0, 0.0
        reach = tolerance if side == 0 else 0.0
        for k in range(LIMITS.looks):
            t = max(root - reach, within.start) if side == 0 else min(root + reach, within.end)
            here = value(data, t)
            if k < 2 or of_side == 0.0:
                largest_of_side = max(largest_of_side, abs(here))
            if k > 0 and here * last >= 0.0:
                of_side = max(of_side, abs(here - last))
            last = here
            if k >= 2 and of_side > 0.0:
                break
            reach = reach + tolerance if k < 2 else 2.0 * reach  # values near each other can be one number
        differ = max(differ, of_side)
        if side == 0:
            before = largest_of_side
        else:
            behind = largest_of_side
    return max(LIMITS.noise * min(before, behind, differ), LIMITS.round_off * largest)


@exact
def passes_at(value: Value, data: Any, t: float, root: float, within: Within) -> bool:
    """Return whether a function with a root behind a time has no sign there but for noise: it passes zero then.

    From a step that begins at this time its zero could not be seen. `within` is of the last step.
    """
    return bool(abs(value(data, t)) <= noise_after(value, data, root, within, 0.0))
