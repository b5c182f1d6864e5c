"""Comparison of functions of time with their given rates, throughout a run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector

SHARE = 0.01
"""Largest error of a rate relative to the largest rate nearby: far below a factor 2 pi or a wrong sign."""

NOISE = 1e-13
"""Round-off of a value relative to its largest: some hundred units in the last place."""

STRIDE = 8
"""Samples of the second rate per sample of the value and of its rate."""

NEARBY = 32
"""Number of samples in a block; the largest rate nearby is that of a block and of its two neighbours."""

OF_FOURTH = 0.25
"""Bound of the error of the corrected trapezoidal rule relative to the fourth difference: 11/720 for smooth functions,
and (1/2 + 1/12) / 3 if the function jumps."""

FEW = 40
"""Number of intervals of a first check."""

CLOSEST = 1e-5
"""Length of the interval in which a contradiction is reported, relative to the distance of the samples."""

MOST_FOLLOWED = 8
"""Largest number of suspicious intervals that are examined: if vibrations are faster than the samples, all may be
suspicious."""

LOCAL, PLACES = 1e-4, 4
"""Length of the intervals, relative to the distance of the samples, in which the rates are checked against the value
even without suspicion, because vibrations of any frequency have correct rates there; and the number of these intervals.
"""

SPLIT = 0.41
"""Position at which an interval is divided, relative to its length: no multiple of the period of a vibration is divided
at equal phases."""

WEIGHTS = (
    (3.0 * SPLIT - 1.0) / (6.0 * SPLIT),
    1.0 / (6.0 * SPLIT * (1.0 - SPLIT)),
    (2.0 - 3.0 * SPLIT) / (6.0 * (1.0 - SPLIT)),
)
"""Weights of the integral of the parabola through start, split and end of an interval."""

Function = Callable[[float], Any]


class Contradiction(NamedTuple):
    """A contradiction between a function and its rate.

    Attributes
    ----------
    of_rate : bool
        Whether the rate contradicts the second rate; else the value contradicts the rate.
    time : float
        s.
    change : ndarray, shape (k,)
        Change of the function in a short interval.
    found, given : ndarray, shape (k,)
        This change per second, and the given rate.
    is_jump : bool
        Whether the change is as large in the short interval as it is from one sample to the next.
    """

    of_rate: bool
    time: float
    change: Vector
    found: Vector
    given: Vector
    is_jump: bool


def refuse(found: Contradiction | None, names: tuple[str, str, str], what: str) -> None:
    """Raise a ModelError that describes a contradiction, if there is one.

    Parameters
    ----------
    found : Contradiction or None
    names : (str, str, str)
        Names of the value, its rate and its second rate.
    what : str
        Beginning of the message.
    """
    if found is None:
        return
    name, rate = (text.replace("_", " ") for text in names[found.of_rate : found.of_rate + 2])
    given = f"where its {rate} is {_text(found.given)}"
    if found.is_jump:
        why = "a speed takes time to change" if found.of_rate else "no speed makes that"
        fault = f"its {name} jumps by {_text(found.change)}, {given}: {why}"
    else:
        fault = f"its {name} changes by {_text(found.found)} a second, {given}"
    raise ModelError(
        f"{what}: at t = {found.time:.6g} s {fault}. Remedy: no jumps of the {name} and its time derivative as {rate}, "
        "or a table of points: Motion.table, PoseTable"
    )


def contradiction(
    functions: tuple[Function, Function, Function], times: Vector, seconds: Matrix | None = None
) -> Contradiction | None:
    """Return the worst contradiction between functions of time and their rates; None: there is none.

    The second rate is sampled at all times, value and rate at each `STRIDE`-th. Between these the changes are integrals
    of the second rate by the corrected trapezoidal rule, whose error the fourth differences bound, also where the
    second rate jumps. `_followed` examines intervals with a larger deviation. If a few samples agree clearly, as for
    most motions, no closer examination is needed: see `_fits`.
    """
    value, rate, second = functions
    if _fits(functions, times, seconds):
        return None
    a = finite_rows(values_at(second, times) if seconds is None else seconds)
    v = finite_rows(values_at(rate, times[::STRIDE]))
    x = finite_rows(values_at(value, times[::STRIDE]))
    count = min(len(x), len(v), (len(a) - 1) // STRIDE + 1)
    if count < 2:
        return None
    a, v, x, times = a[: STRIDE * (count - 1) + 1], v[:count], x[:count], times[: STRIDE * (count - 1) + 1]
    h, coarse = times[1] - times[0], times[::STRIDE]
    length, latest = STRIDE * h, float(np.abs(times).max())
    d2 = _differences(a)
    bound = OF_FOURTH * h * _norm(_differences(d2))
    error = np.add.reduceat(np.maximum(bound[1:], bound[:-1]), np.arange(0, len(times) - 1, STRIDE))
    gains = (h * (0.5 * (a[1:] + a[:-1]) - (d2[1:] + d2[:-1]) / 24.0)).reshape(count - 1, STRIDE, -1)
    ends = np.cumsum(gains, axis=1)
    within = h * (ends - 0.5 * gains).sum(axis=1) - h**2 / 12.0 * (a[STRIDE::STRIDE] - a[:-1:STRIDE])
    sizes = [_nearby(_norm(rows), block) for rows, block in ((a, NEARBY), (v, NEARBY // STRIDE))]
    sizes = [np.maximum(sizes[0][STRIDE::STRIDE], sizes[0][:-1:STRIDE]), np.maximum(sizes[1][1:], sizes[1][:-1])]
    left_of_rate = _norm(np.diff(v, axis=0) - ends[:, -1])
    left_of_value = _norm(np.diff(x, axis=0) - length * v[:-1] - within)
    for of_rate, pair, y, left, size, far in (
        (False, (value, rate), x, left_of_value, sizes[1], length * error),
        (True, (rate, second), v, left_of_rate, sizes[0], error),
    ):
        noise = NOISE * (float(np.abs(y).max()) + latest * float(size.max()))
        allowed = SHARE * length * size + far + noise
        suspicious = np.flatnonzero(left > allowed)
        worst = suspicious[np.argsort(allowed[suspicious] / left[suspicious])][:MOST_FOLLOWED]
        looked_at = [(coarse[i], coarse[i + 1], size[i]) for i in worst]
        places = ((np.arange(PLACES) * 0.618034 + 0.3) % 1.0 * (count - 1)).astype(int)
        looked_at += [(coarse[i] + 0.37 * h, coarse[i] + (0.37 + LOCAL * STRIDE) * h, size[i]) for i in places]
        for first, last, near in looked_at:
            with suppress(ArithmeticError, LookupError, TypeError, ValueError):  # reported by the run if it gets there
                found = _followed(*pair, float(first), float(last), float(near), noise)
                if found is not None:
                    return Contradiction(of_rate, *found)
    return None


def _fits(functions: tuple[Function, Function, Function], times: Vector, seconds: Matrix | None) -> bool:
    """Return whether values agree with their rates at all of a few samples, and at a place between them.

    The corrected trapezoidal rule is used, with tolerances not above those of the closer examination. Functions that
    are wrong only during a fortieth of the run may be missed.
    """
    stride, value, rate = (len(times) - 1) // FEW, functions[0], functions[1]
    coarse = times[::stride] if stride else times
    x, v = (finite_rows(values_at(function, coarse)) for function in (value, rate))
    a = finite_rows(values_at(functions[2], coarse)) if seconds is None else seconds[::stride] if stride else seconds
    if len(coarse) < FEW or not x.shape == v.shape == a.shape or len(x) < len(coarse):
        return False
    length, latest = float(coarse[1] - coarse[0]), float(np.abs(times[[0, -1]]).max())
    if seconds is None:
        d2 = _differences(a)
        gained = length * (0.5 * (a[1:] + a[:-1]) - (d2[1:] + d2[:-1]) / 24.0)
    else:
        starts = np.arange(0, stride * (len(coarse) - 1), stride)
        sums = np.add.reduceat(seconds[: starts[-1] + stride], starts, axis=0)
        gained = length / stride * (sums + 0.5 * (a[1:] - a[:-1]))
    moved = 0.5 * length * (v[1:] + v[:-1]) - length**2 / 12.0 * (a[1:] - a[:-1])
    for pair, y, change, rates in ((functions[:2], x, moved, v), (functions[1:], v, gained, a)):
        sizes = _norm(rates)
        near = np.maximum(sizes[1:], sizes[:-1])
        near[1:] = np.maximum(near[1:], sizes[:-2])
        noise = NOISE * (float(np.abs(y).max()) + latest * float(sizes.max()))
        if not (_norm(y[1:] - y[:-1] - change) <= SHARE * length * near + noise).all():
            return False
        # finds vibrations that all samples meet at the same phase
        at = len(near) // 3
        start, share = float(coarse[at]) + 0.0231 * length, LOCAL * length
        try:
            y0, y1 = np.array([pair[0](t) for t in (start, start + share)], dtype=float).reshape(2, -1)
            r = np.array([pair[1](start + part * share) for part in (0.0, 0.5, 1.0)], dtype=float).reshape(3, -1)
        except (ArithmeticError, LookupError, TypeError, ValueError):
            return False
        size = max(float(near[at]), float(_norm(r).max()))
        if not float(_norm(y1 - y0 - share / 6.0 * (r[0] + 4.0 * r[1] + r[2]))) <= SHARE * share * size + noise:
            return False
    return True


def _followed(
    value: Function, rate: Function, a: float, b: float, size: float, noise: float
) -> tuple[float, Vector, Vector, Vector, bool] | None:
    """Return the time, change, rates and jump flag of a contradiction between two times; None: there is none.

    The interval is divided repeatedly, towards the larger part of the change that the integral of the rate does not
    explain. This vanishes if the two agree and vibrate faster than the samples. It is a contradiction if it remains
    outside the range of the rates around it.
    """
    least = max(CLOSEST * (b - a), 1e-11 * max(abs(a), abs(b)))
    start, stop, first = a, b, 0.0
    xa, xb, va, vb = (_row(f(t)) for f in (value, rate) for t in (a, b))
    while True:
        w, m = b - a, a + SPLIT * (b - a)
        xm, vm = _row(value(m)), _row(rate(m))
        left = float(_norm(xb - xa - w * (WEIGHTS[0] * va + WEIGHTS[1] * vm + WEIGHTS[2] * vb)))
        first = first or left
        if not left > SHARE * w * max(size, float(_norm(va)), float(_norm(vm)), float(_norm(vb))) + noise:
            return None
        if w <= least:
            break
        before = _norm(xm - xa - 0.5 * (m - a) * (va + vm))
        after = _norm(xb - xm - 0.5 * (b - m) * (vm + vb))
        if before > after:
            b, xb, vb = m, xm, vm
        else:
            a, xa, va = m, xm, vm
    about = np.clip(m + w * np.linspace(-1.5, 1.5, 5), start, stop).tolist()
    rates = np.array([va, vm, vb, *(_row(rate(t)) for t in about)])
    found = (xb - xa) / w
    outside = float(_norm(found - np.clip(found, rates.min(axis=0), rates.max(axis=0))))
    if not outside > SHARE * max(size, float(_norm(found))) + noise / w:
        return None
    return m, xb - xa, found, vm, left > 0.5 * first


def values_at(function: Function, times: Vector) -> list[Any]:
    """Return the values of a function at times, up to the first where it fails."""
    values: list[Any] = []
    with suppress(Exception):  # of the user's function, reported by the run if it gets there
        values.extend(map(function, times.tolist()))
    return values


def finite_rows(values: Sequence[Any] | Matrix) -> Matrix:
    """Return values as rows, up to the first that is not finite, (T, k)."""
    try:
        rows = np.array(values, dtype=float).reshape(len(values), -1)
    except (TypeError, ValueError):  # strings or different shapes, reported by the run
        return np.zeros((0, 1))
    finite = np.isfinite(rows).all(axis=1)
    return rows if finite.all() else rows[: int(np.argmin(finite))]


def _row(value: Any) -> Vector:
    return np.array(value, dtype=float).ravel()


def _norm(rows: Matrix) -> Vector:
    return np.abs(rows[..., 0]) if rows.shape[-1] == 1 else np.asarray(np.linalg.norm(rows, axis=-1))


def _differences(rows: Matrix) -> Matrix:
    """Return the second differences at each row, at the ends those of the row beside it."""
    inner = np.diff(rows, 2, axis=0)
    return np.concatenate((inner[:1], inner, inner[-1:]))


def _nearby(sizes: Vector, block: int) -> Vector:
    """Return the largest of the sizes about each."""
    blocks = np.maximum.reduceat(sizes, np.arange(0, len(sizes), block))
    padded = np.concatenate((blocks[:1], blocks, blocks[-1:]))
    return np.repeat(np.maximum(np.maximum(padded[:-2], blocks), padded[2:]), block)[: len(sizes)]


def _text(value: Vector) -> str:
    return f"{value[0]:.6g}" if len(value) == 1 else str([float(f"{number:.6g}") for number in value])
