"""What answers say of quantities: numbers whose errors are measured together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from kanefe.certified.quantity import Quantity
from kanefe.errors import ModelError
from kanefe.results.tables import channel_of


class Values(NamedTuple):
    """Values of one unit whose errors are measured together.

    Attributes
    ----------
    title, unit : str
    values : ndarray
    norm : float
        2: root of the sum of squares (they are divided by the root of their number); 1: the largest magnitude.
    size : float
        Of the whole history: its root mean square, else its largest magnitude.
    """

    title: str
    unit: str
    values: np.ndarray
    norm: float
    size: float

    def apart(self, other: Values) -> float:
        """Return how far they are from those of another answer, in the unit.

        Raises
        ------
        ModelError
            If those have another shape.
        """
        if self.unit and self.values.shape[1:] == other.values.shape[1:] and len(self.values) != len(other.values):
            common = (
                min(len(self.values), len(other.values)) - 1
            )  # runs that end at an event, each at a time of its own
            return self._measured(self.values[:common] - other.values[:common])
        if self.values.shape != other.values.shape:
            raise ModelError(
                f"quantity {self.title!r} has the shape {other.values.shape} at one setting and {self.values.shape} at "
                "another. Remedy: a function whose shape does not depend on the number of modes or nodes"
            )
        return self._measured(self.values - other.values)

    def _measured(self, values: np.ndarray) -> float:
        return float(np.linalg.norm(values.ravel()) if self.norm == 2.0 else np.abs(values).max(initial=0.0))


def values_of(quantity: Quantity, answer: Any, every: int = 1) -> list[Values]:
    """Return the values of an answer, those of each unit by themselves; of histories each so many-th one.

    Raises
    ------
    ModelError
        If there is no such channel, or the function gives no finite numbers that may change continuously.
    """
    if isinstance(quantity.what, str):
        channel = channel_of(answer, quantity.name, quantity.what, "quantity")
        units = dict.fromkeys(channel.units)
        found = []
        for unit in units:
            own = [i for i, other in enumerate(channel.units) if other == unit]
            title = quantity.title if len(units) == 1 else f"{quantity.title} [{unit}]"
            found.append(_condensed(quantity, title, unit, channel.values[:, own], every))
        return found
    try:
        given = quantity.what(answer)
    except ModelError:
        raise
    except Exception as error:
        raise ModelError(
            f"quantity {quantity.title!r}: its function raised {type(error).__name__}: {error}. Remedy: a function "
            "that every answer has a value of, also that of a coarser setting"
        ) from error
    values = _array(quantity, given)
    thinned = every if len(values) == len(getattr(answer, "times", ())) else 1
    return [_condensed(quantity, quantity.title, "", values, thinned)]


def _array(quantity: Quantity, given: Any) -> np.ndarray:
    values = np.asarray(given)
    if values.dtype.kind in "biu":
        raise ModelError(
            f"quantity {quantity.title!r} is a count or a choice ({told_type(values)}), which jumps: no bound of its "
            "error is of use. Remedy: what changes continuously, such as a time, a distance or a force"
        )
    if values.dtype.kind not in "fc" or not values.size:
        raise ModelError(f"quantity {quantity.title!r} must give numbers, not {given!r}")
    if not np.all(np.isfinite(values)):
        raise ModelError(f"quantity {quantity.title!r} is not finite. Remedy: a function that gives numbers")
    return values if values.ndim else values[None]


def _condensed(quantity: Quantity, title: str, unit: str, values: np.ndarray, every: int) -> Values:
    """Return what of the values has the accuracy."""
    norm, values = 1.0, values[::every] if quantity.over == "time" else values
    largest = float(np.abs(values).max())
    if quantity.over == "rms":
        values = values[::every]
        values, norm = values / np.sqrt(len(values)), 2.0
        largest = float(np.linalg.norm(values.ravel()))
    elif quantity.over == "final":
        values = values[-1:]
    elif quantity.over == "largest":
        values = np.array([largest])
    return Values(title, unit, values, norm, largest)


def told_type(values: np.ndarray) -> str:
    """Return the type of numbers in words."""
    return "true or false" if values.dtype.kind == "b" else "whole numbers"


def allowed_error(quantity: Quantity, size: float) -> float:
    """Return the largest error of a quantity of some size, in its unit."""
    return max(quantity.absolute or 0.0, (quantity.relative or 0.0) * size)


def check_names(quantities: Sequence[Quantity], answer: Any) -> None:
    """Refuse channels that an answer would not have."""
    for quantity in quantities:
        if isinstance(quantity.what, str):
            values_of(quantity, answer)


def refuse_constant(quantity: Quantity, values: Values) -> None:
    """Refuse a quantity of which there is nothing to bound."""
    flat = values.values.reshape(len(values.values), -1)
    if quantity.absolute is None and values.size == 0.0:
        raise ModelError(f"quantity {values.title!r} is zero: it has no relative accuracy. Remedy: absolute=")
    if (
        quantity.over in {"time", "rms"}
        and isinstance(quantity.what, str)
        and len(flat) > 1
        and not np.ptp(flat, 0).any()
    ):
        raise ModelError(
            f"quantity {values.title!r} is constant, {flat[0].tolist()}: there is nothing to bound. Remedy: another one"
        )
