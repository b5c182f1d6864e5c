"""Reducers: numbers of a run, so that its histories need not be stored.

Each is a function of a `kanefe.Result` that returns a dict of numbers by name; `kanefe.Study` takes one or several.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.result import Result

Quantity = str | Callable[[Result], Any]

Kind = Literal["absolute", "highest", "lowest"]


@dataclass(frozen=True)
class History:
    """A quantity over the output times of a run after a time; see `peak`."""

    quantity: Quantity
    names: tuple[str, ...]
    component: str | None
    after: float
    name: str | None

    def columns(self, result: Result) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Return times (T,) and values (T,) by name.

        Raises
        ------
        ModelError
            If there is no such quantity or component, or no output time after that time.
        """
        shown = result.times >= self.after
        if not shown.any():
            raise ModelError(f"no output time is after {self.after:g} s; the run ends at {result.times[-1]:g} s")
        if callable(self.quantity):
            label = self.name or getattr(self.quantity, "__name__", "value")
            values, components = np.asarray(self.quantity(result), dtype=float), [""]
        else:
            label = self.name or " ".join((self.quantity, *self.names)).replace("_", " ")
            values = result.read(self.quantity, *self.names)
            parts = result.parts(self.quantity, self.names[0] if self.names else "")
            components = [f"{part} {c}" if len(parts) > 1 else c for part, _, names in parts for c in names or ("",)]
        if values.shape[:1] != result.times.shape:
            raise ModelError(f"{label} has the shape {values.shape}, not one row for each of {len(shown)} output times")
        columns = values.reshape(len(shown), -1)
        if columns.shape[1] != len(components):
            components = [str(number) for number in range(columns.shape[1])]
        if self.component is not None and self.component not in components:
            raise ModelError(f"{label} has no component {self.component!r}. Remedy: one of {', '.join(components)}")
        found = {
            f"{label} {component}".strip(): columns[shown, j]
            for j, component in enumerate(components)
            if self.component in (None, component)
        }
        return result.times[shown], {self.name: next(iter(found.values()))} if self.name and len(found) == 1 else found


@dataclass(frozen=True)
class Peak:
    """See `peak`."""

    history: History
    kind: Kind

    def __call__(self, result: Result) -> dict[str, float]:
        """Return the peaks of a run by name."""
        _, columns = self.history.columns(result)
        pick: Any = {"absolute": _magnitude, "highest": np.max, "lowest": np.min}[self.kind]
        prefix = "" if self.history.name else {"absolute": "peak", "highest": "highest", "lowest": "lowest"}[self.kind]
        return {f"{prefix} {name}".strip(): float(pick(values)) for name, values in columns.items()}


@dataclass(frozen=True)
class Exceedances:
    """See `exceedances`."""

    history: History
    level: float

    def __call__(self, result: Result) -> dict[str, float]:
        """Return rates and shares of a run by name."""
        times, columns = self.history.columns(result)
        found = {}
        for name, values in columns.items():
            above = values > self.level
            span = float(times[-1] - times[0])
            found[f"rate {name}"] = float(np.count_nonzero(above[1:] & ~above[:-1])) / span if span > 0.0 else 0.0
            found[f"share {name}"] = float(np.mean(above))
        return found


@dataclass(frozen=True)
class HistorySpectrum:
    """See `spectrum`."""

    history: History
    segment: float | None

    def __call__(self, result: Result) -> dict[str, Any]:
        """Return spectra of a run by name, and the step of their frequencies."""
        from scipy.signal import welch

        times, columns = self.history.columns(result)
        steps = np.diff(times)
        if len(steps) < 2 or np.ptp(steps) > 1e-6 * steps.mean():
            raise ModelError("a spectrum needs output times at equal steps. Remedy: simulate={'output_step': ...}")
        step = float(times[-1] - times[0]) / len(steps)
        length = len(times) // 8 if self.segment is None else round(self.segment / step)
        length = min(max(length, 2), len(times))
        found: dict[str, Any] = {}
        for name, values in columns.items():
            _, density = welch(values, fs=1.0 / step, nperseg=length)
            found[f"spectrum {name}"] = density
        return found | {"spectrum step": 1.0 / (length * step)}


@checked("component", "name")
def peak(
    quantity: Quantity,
    *names: str,
    component: str | None = None,
    kind: Kind = "absolute",
    after: float = 0.0,
    name: str | None = None,
) -> Peak:
    """Return a reducer to the largest value of a quantity at the output times.

    Parameters
    ----------
    quantity : str or function
        A quantity such as "position" or "coupling_force" (as ``result.read`` takes it), or ``f(result)``, an array
        with the output times first.
    *names : str
        Body and, if the quantity has one, interface.
    component : str, optional
        Such as "x", or "force x" of forces with moments. Default: all components are outputs.
    kind : "absolute", "highest" or "lowest"
        The largest magnitude, the largest value, or the smallest.
    after : float
        Time from which values count, s, such as after the ramp of a sea.
    name : str, optional
        Name of the output; default: from the arguments.

    Returns
    -------
    function of a Result
        It returns a dict of numbers.

    Raises
    ------
    ModelError
        If an argument is not valid; when called, if the run has no such quantity.

    Examples
    --------
    >>> from kanefe.studies import peak
    >>> tip = peak("position", "tip", component="z", kind="lowest", after=2.0)
    >>> study = kf.Study(build, [tip, peak("joint_reaction", "arm")], ...)     # doctest: +SKIP
    """
    if not isinstance(kind, str) or kind not in ("absolute", "highest", "lowest"):
        raise ModelError(f"kind must be 'absolute', 'highest' or 'lowest', not {kind!r}")
    return Peak(_history(quantity, names, component, after, name), kind)


@checked("component", "name")
def exceedances(
    quantity: Quantity,
    *names: str,
    level: float,
    component: str | None = None,
    after: float = 0.0,
    name: str | None = None,
) -> Exceedances:
    """Return a reducer to the rate (1/s) of upcrossings of a level by a quantity, and its share of time above it.

    Crossings between two output times are not detected. Other parameters and errors: `peak`.

    Parameters
    ----------
    level : float
        In the unit of the quantity.

    Examples
    --------
    ``kf.studies.exceedances("joint_coordinates", "mast", level=0.1, after=60.0)``
    """
    return Exceedances(_history(quantity, names, component, after, name), finite(level, "level"))


@checked("component", "segment", "name")
def spectrum(
    quantity: Quantity,
    *names: str,
    component: str | None = None,
    segment: float | None = None,
    after: float = 0.0,
    name: str | None = None,
) -> HistorySpectrum:
    """Return a reducer to the one-sided spectral density of a quantity, by Welch's method (``scipy.signal``).

    The output is an array of values (unit2/Hz) at multiples of "spectrum step" (Hz), from zero. Other parameters and
    errors: `peak`.

    Parameters
    ----------
    segment : float, optional
        Length of the averaged segments, s; default: an eighth of the record.

    Examples
    --------
    ``kf.studies.spectrum("velocity", "tip", component="z", segment=60.0)``
    """
    if segment is not None and finite(segment, "segment") <= 0.0:
        raise ModelError(f"segment must be above zero s, not {segment!r}")
    return HistorySpectrum(_history(quantity, names, component, after, name), segment)


def _history(
    quantity: Quantity, names: tuple[str, ...], component: str | None, after: float, name: str | None
) -> History:
    if not (callable(quantity) or isinstance(quantity, str)):
        raise ModelError(f"quantity must be a name or a function of a Result, not {quantity!r}")
    return History(quantity, names, component, finite(after, "after"), name)


def _magnitude(values: np.ndarray) -> Any:
    return np.abs(values).max()


def finite(value: Any, what: str) -> float:
    """Return a finite number; a ModelError names `what` otherwise."""
    if numbers(value).shape != () or not np.isfinite(numbers(value)):
        raise ModelError(f"{what} must be a finite number, not {value!r}")
    return float(value)
