"""Motions: joint coordinates as given functions of time."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from kanefe.errors import KanefeError, ModelError
from kanefe.frames import Matrix, numbers, shaped_numbers

LEAST_POINTS = 4

PIECES_NEAR = 3
"""Number of table pieces next to an overshoot among which the jump that causes it is searched."""

MOST_OVERSHOOT = 1.0
"""Largest overshoot of a spline beyond the points of its table, relative to their range: next to a jump among evenly
spaced points it is a tenth."""


@dataclass(frozen=True)
class LinearFunction:
    """``start + rate t``, as an object that can be pickled."""

    start: float
    rate: float

    def __call__(self, t: float) -> float:
        return self.start + self.rate * t


def check_increasing(times: np.ndarray, what: str) -> None:
    """Check the times of a table, s; a ModelError names the first that does not increase."""
    falling = np.flatnonzero(np.diff(times) <= 0)
    if len(falling):
        before, after = times[falling[0] : falling[0] + 2]
        raise ModelError(
            f"{what} must increase, but {before:.6g} s is followed by {after:.6g} s. "
            "Remedy: sort the points and leave out doubled ones"
        )
    steps = np.diff(times)  # below round-off of the largest one they are none
    if not np.isfinite(steps).all() or np.finfo(float).eps * steps.max() > steps.min():
        raise ModelError(
            f"{what} have steps of {steps.min():.3g} to {steps.max():.3g} s, between which no curve is known. Remedy: "
            "check the times, in s"
        )


def check_between(spline: Any, points: np.ndarray, what: str) -> None:
    """Check that a cubic spline (n - 1 pieces) stays near its points (n,) or (n, k), of a table described by `what`.

    A step between points much closer than their neighbours causes overshoot, the more the steeper the step is.
    """
    t, h = spline.x, np.diff(spline.x)[:, None]
    size = np.abs(points).max() or 1.0
    c, y = spline.c.reshape(4, len(h), -1) / size, points.reshape(len(points), -1) / size
    root = np.sqrt(np.maximum(c[1] ** 2 - 3.0 * c[0] * c[2], 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        places = np.array([(-c[1] + sign * root) / (3.0 * c[0]) for sign in (-1.0, 1.0)] + [-0.5 * c[2] / c[1]])
    places = np.clip(np.nan_to_num(places, nan=0.0), 0.0, h)
    values = ((c[0] * places + c[1]) * places + c[2]) * places + c[3]
    low, high = y.min(axis=0), y.max(axis=0)
    beyond = np.maximum(values - high, low - values)
    allowed = MOST_OVERSHOOT * (high - low) + 1e-9 * np.abs(y).max(axis=0)
    if not np.any(beyond > allowed):
        return
    _, piece, column = np.unravel_index(int(np.argmax(beyond - allowed)), beyond.shape)
    worst = size * values[np.argmax(beyond[:, piece, column]), piece, column]
    low, high, changes = size * low[column], size * high[column], size * np.diff(y[:, column])
    start = max(int(piece) - PIECES_NEAR, 0)
    near = slice(start, int(piece) + PIECES_NEAR + 1)
    short = start + int(np.argmax(np.abs(changes[near]) / h[near, 0]))
    raise ModelError(
        f"{what} cannot be followed: between {t[piece]:.6g} and {t[piece + 1]:.6g} s the spline through its points "
        f"overshoots to {worst:.3g}, but these lie within {low:.3g} and {high:.3g}; they change by "
        f"{changes[short]:.3g} in {h[short, 0]:.3g} s from {t[short]:.9g} s on. Remedy: a slower change there, or more "
        "points about it, at gradually growing steps"
    )


def check_span(span: object, what: str) -> None:
    """Check the first and last time of a motion, s, which may be infinite; a ModelError names it as `what`."""
    ends = numbers(span)
    if ends.shape != (2,) or not ends[0] < ends[1]:
        raise ModelError(f"span of {what} must be its first and last time, s, not {span!r}")


def of_body(name: str) -> str:
    """Return what the motion of a driven joint of a body is named in messages."""
    return f"the motion of body {name!r}"


def polyline(times: np.ndarray, values: np.ndarray) -> Motion:
    """Return the motion straight from point to point, constant before and after them: its rate jumps, as of a winch."""
    from scipy.interpolate import PPoly

    starts, positions = np.append(times[0] - 1.0, times), np.append(values[0], values)
    rates = np.concatenate(((0.0,), np.diff(values) / np.diff(times), (0.0,)))
    line = PPoly(np.array((rates, positions)), np.append(starts, times[-1] + 1.0))
    motion = Motion(line, line.derivative(1), line.derivative(2))
    return motion._of_pieces(np.column_stack((starts, positions, rates, np.zeros((len(starts), 2)))))


def clock(times: np.ndarray) -> Motion:
    """Return the time as a motion, in the span of a table with these times and with their pieces."""
    motion = Motion(*TIME, span=(float(times[0]), float(times[-1])))
    starts, none = times[:-1], np.zeros(len(times) - 1)
    return motion._of_pieces(np.column_stack((starts, starts, none + 1.0, none, none)))


TIME = LinearFunction(0.0, 1.0), LinearFunction(1.0, 0.0), LinearFunction(0.0, 0.0)
"""The time and its two derivatives, as functions of the time."""


@dataclass(frozen=True)
class Motion:
    """A joint coordinate as a given function of time.

    Parameters
    ----------
    position, velocity, acceleration : callable
        t in s -> coordinate in rad or m, and its two time derivatives.
    span : (float, float)
        First and last time at which the motion is defined, s.

    Runs stay in compiled code if a motion is `steady` or from a `table`, or its three functions are compiled by numba:
    see `compiled`.

    Attributes
    ----------
    pieces : ndarray or None, shape (n, 5)
        For a steady motion and a table: the start of each piece (s), and the coefficients of the powers 0 to 3 of the
        time since.

    Raises
    ------
    ModelError
        If a function is missing: driving forces need the acceleration.

    Examples
    --------
    >>> spin = Motion(lambda t: 3.0 * t, lambda t: 3.0, lambda t: 0.0)
    """

    position: Callable[[float], float]
    velocity: Callable[[float], float] | None = None
    acceleration: Callable[[float], float] | None = None
    span: tuple[float, float] = (-math.inf, math.inf)
    pieces: np.ndarray | None = field(init=False, default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        missing = [name for name in ("velocity", "acceleration") if getattr(self, name) is None]
        if missing:
            raise ModelError(
                f"a Motion needs position, velocity and acceleration; {' and '.join(missing)} is missing. "
                "Remedy: give the time derivatives, or sample the position and use Motion.table(times, positions)"
            )
        for name in ("position", "velocity", "acceleration"):
            if not callable(getattr(self, name)):
                raise ModelError(f"{name} of a Motion must be a function of time, not {getattr(self, name)!r}")
        check_span(self.span, "a Motion")

    @classmethod
    def steady(cls, rate: float, start: float = 0.0) -> Motion:
        """Return the motion ``start + rate t`` (rad/s or m/s); a ModelError names what is not a finite number."""
        rate, start = (
            float(shaped_numbers(value, (), f"{name} of a steady Motion"))
            for name, value in (("rate", rate), ("start", start))
        )
        motion = cls(LinearFunction(start, rate), LinearFunction(rate, 0.0), LinearFunction(0.0, 0.0))
        return motion._of_pieces(np.array([[0.0, start, rate, 0.0, 0.0]]))

    @classmethod
    def table(cls, times: Sequence[float], positions: Sequence[float]) -> Motion:
        """Return the motion through points of a table: a cubic spline, whose acceleration is continuous.

        The spline has no knot at the second and last but one point (not-a-knot), so that its rates at the ends follow
        from the points there. Outside the table the motion is not defined, and evaluating it is an error.

        Parameters
        ----------
        times : array_like, shape (n,)
            Increasing, at least four, s.
        positions : array_like, shape (n,)
            rad or m.

        Raises
        ------
        ModelError
            If the times do not increase, the lengths differ, a number is not finite, or the spline overshoots between
            the points, as it does beside a jump.

        Examples
        --------
        >>> times = np.linspace(0.0, 1.0, 11)
        >>> round(float(Motion.table(times, times**3).acceleration(0.5)), 12)
        3.0
        """
        t, x = numbers(times), numbers(positions)
        if t.ndim != 1 or x.shape != t.shape or not (np.all(np.isfinite(t)) and np.all(np.isfinite(x))):
            raise ModelError(
                f"the table of a Motion needs as many finite positions as times; shapes {t.shape} and {x.shape} "
                "were given, or a number is not finite"
            )
        if len(t) < LEAST_POINTS:
            raise ModelError(
                f"the table of a Motion has {len(t)} points, a spline needs {LEAST_POINTS}. Remedy: more points"
            )
        check_increasing(t, "the times of a Motion's table")
        from scipy.interpolate import CubicSpline

        spline = CubicSpline(t, x, bc_type="not-a-knot")
        check_between(spline, x, "the table of a Motion")
        motion = cls(spline, spline.derivative(1), spline.derivative(2), (float(t[0]), float(t[-1])))
        return motion._of_pieces(np.column_stack((spline.x[:-1], spline.c[::-1].T)))

    def compiled(self) -> Motion:
        """Return the motion with its functions compiled by numba, so that runs need not leave compiled code for them.

        The functions may use numbers, `math` and numpy as far as numba supports them. They use the present values of
        variables outside of them: later changes have no effect.

        Raises
        ------
        ModelError
            If numba cannot compile one of them.

        Examples
        --------
        >>> swing = Motion(lambda t: 0.1 * t * t, lambda t: 0.2 * t, lambda t: 0.2).compiled()
        """
        from kanefe.kernels.compiler._numba_functions import compiled_of_time

        position, velocity, acceleration = self.position, self.velocity, self.acceleration
        if self.pieces is not None or velocity is None or acceleration is None:
            return self
        return Motion(
            compiled_of_time(position, "position of a Motion"),
            compiled_of_time(velocity, "velocity of a Motion"),
            compiled_of_time(acceleration, "acceleration of a Motion"),
            self.span,
        )

    def _of_pieces(self, pieces: np.ndarray) -> Motion:
        pieces.flags.writeable = False
        object.__setattr__(self, "pieces", pieces)
        return self

    @property
    def is_compiled(self) -> bool:
        """Whether all three functions are compiled by numba."""
        return all(hasattr(function, "py_func") for function in (self.position, self.velocity, self.acceleration))

    @property
    def known(self) -> tuple[float, float]:
        """First and last time of the motion, s, with a margin for round-off at the end of a step."""
        first, last = self.span
        round_off = 1e-9 * (last - first) if math.isfinite(last - first) else 0.0
        return first - round_off, last + round_off

    def at(self, name: str, t: float, what: str) -> float:
        """Return the position, velocity or acceleration (by name) at time t.

        Raises
        ------
        ModelError
            If it is not finite or not defined there; the message names the motion as `what`, and the time.
        """
        self.check_known(t, what)
        try:
            given = getattr(self, name)(t)
        except KanefeError:
            raise
        except Exception as error:
            error.add_note(f"the {name} of {what} at t = {t:.6g} s")
            raise
        value = given if type(given) is float else numbers(given)
        if np.shape(value) != () or not math.isfinite(value):
            raise ModelError(f"{what} must give finite numbers; its {name} at t = {t:.6g} s is {given}")
        return float(value)

    def check_known(self, t: float, what: str) -> None:
        """Raise a ModelError that names the motion as `what`, if it is not defined at time t (s)."""
        earliest, latest = self.known
        if not earliest <= t <= latest:
            first, last = self.span
            raise ModelError(
                f"{what} is given from {first:.6g} to {last:.6g} s and was asked for at t = {t:.6g} s. Remedy: a "
                "longer table (duration=... of Ship.at), or a shorter run"
            )

    def over(self, times: np.ndarray, what: str) -> np.ndarray:
        """Return position, velocity and acceleration at many times, (T, 3): see `at`."""
        functions = {name: getattr(self, name) for name in ("position", "velocity", "acceleration")}
        if self.pieces is None:  # functions of the user take a single time
            return np.array([[self.at(name, t, what) for name in functions] for t in times.tolist()]).reshape(-1, 3)
        for t in (times.min(initial=self.start), times.max(initial=self.start)):
            self.at("position", float(t), what)
        return np.column_stack([function(times) for function in functions.values()])

    @property
    def start(self) -> float:
        """Time zero, or the nearest time at which the motion is defined, s."""
        return min(max(0.0, self.span[0]), self.span[1])

    def check_over(self, times: np.ndarray, what: str, accelerations: Matrix | None = None) -> None:
        """Raise a ModelError that names the motion as `what`, if its rates contradict it anywhere in a run.

        `accelerations` (T, 1) are those at the times of the run, if they are known. Positions and speeds that jump are
        refused too: they would need an infinite speed or an impulse.
        """
        if self.pieces is None and self.velocity is not None and self.acceleration is not None:
            from kanefe.joints.rates_over_time import contradiction, refuse

            functions = (self.position, self.velocity, self.acceleration)
            refuse(contradiction(functions, times, accelerations), ("position", "velocity", "acceleration"), what)

    def check(self, where: str) -> None:
        """Raise a ModelError if a function does not return a finite number, or rates contradict the position."""
        start = self.start
        later = start + 1e-3 if start + 2e-3 < self.span[1] else 0.5 * (self.span[0] + self.span[1])
        for name in ("position", "velocity", "acceleration"):
            function = getattr(self, name)
            for t in (start, later):
                value = numbers(function(t))
                if value.shape != () or not np.isfinite(value):
                    raise ModelError(f"{where}: {name} at t = {t} s must be one finite number, not {function(t)!r}")
        for of, rate in (("position", "velocity"), ("velocity", "acceleration")):
            t, h = later, 1e-6
            function, given = getattr(self, of), float(getattr(self, rate)(t))
            found = (float(function(t + h)) - float(function(t - h))) / (2 * h)
            # 1 % accepts differences of any motion below some kHz, but neither a factor 2 pi nor a wrong sign
            if abs(found - given) > 0.01 * max(abs(found), abs(given)) + 1e-6 * (1 + abs(float(function(t)))):
                raise ModelError(
                    f"{where}: at t = {t} s the {rate} of a Motion is {given:.6g}, but its {of} changes at "
                    f"{found:.6g} a second. "
                    f"Remedy: give the time derivative of the {of}"
                )
