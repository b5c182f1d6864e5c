"""Quantity: a number or a history of an answer, and how accurate it has to be."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, get_args

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.results.tables import channel_of

Over = Literal["time", "rms", "final", "largest"]
"""What of a history has the accuracy."""

LEAST = 1e-12
"""Smallest relative accuracy: results of some thousand operations have a round-off near it."""


@dataclass(frozen=True)
class Quantity:
    """What of an answer is asked for, and how accurate it has to be.

    Parameters
    ----------
    what : str or callable
        A channel, as for `kanefe.Record`: ``"position arm/tip y"``; or a function of the answer (of a run the `Result`)
        that returns numbers, always in the same shape.
    relative : float, optional
        Largest error, relative to the largest value (with over="rms" to the root mean square). Default: that of the
        call, unless `absolute` is given.
    absolute : float, optional
        Largest error in the unit of the quantity. With both, the larger of the two is allowed.
    over : "time", "rms", "final" or "largest"
        What has the accuracy: every value over the first axis, which is the time of a channel; their error's root mean
        square; the last one; or the largest magnitude.
    name : str
        For tables; default: the channel, or the name of the function.

    Raises
    ------
    ModelError
        If an argument is not valid.

    Examples
    --------
    >>> import kanefe as kf
    >>> kf.Quantity("position arm/tip y", relative=1e-4, over="largest").title
    'position arm/tip y, largest'
    """

    what: str | Callable[[Any], Any]
    relative: float | None = None
    absolute: float | None = None
    over: Over = "time"
    name: str = ""

    def __post_init__(self) -> None:
        if not callable(self.what) and not (isinstance(self.what, str) and self.what.strip()):
            raise ModelError(
                "what of a Quantity must be a channel, such as 'position arm x', or a function of the answer, not "
                f"{self.what!r}"
            )
        check_accuracy(self.relative, "relative")
        if self.absolute is not None and not (_is_number(self.absolute) and self.absolute > 0.0):
            raise ModelError(f"absolute of a Quantity must be a finite error above zero, not {self.absolute!r}")
        if not isinstance(self.over, str) or self.over not in get_args(Over):
            raise ModelError(f"over of a Quantity must be one of {', '.join(get_args(Over))}, not {self.over!r}")
        if not isinstance(self.name, str):
            raise ModelError(f"name of a Quantity must be a text, not {self.name!r}")

    @property
    def title(self) -> str:
        """Name, and what of the history is meant if not all of it."""
        own = self.what if isinstance(self.what, str) else getattr(self.what, "__name__", "function")
        return (self.name or own.strip()) + ("" if self.over == "time" else f", {self.over}")

    def read(self, answer: Any, every: int = 1) -> list[Values]:
        """Return the values of an answer, those of each unit by themselves; of histories each so many-th one.

        Raises
        ------
        ModelError
            If there is no such channel, or the function gives no finite numbers that may change continuously.
        """
        if isinstance(self.what, str):
            channel = channel_of(answer, self.name, self.what, "quantity")
            units = dict.fromkeys(channel.units)
            found = []
            for unit in units:
                own = [i for i, other in enumerate(channel.units) if other == unit]
                title = self.title if len(units) == 1 else f"{self.title} [{unit}]"
                found.append(self._condensed(title, unit, channel.values[:, own], every))
            return found
        try:
            given = self.what(answer)
        except ModelError:
            raise
        except Exception as error:
            raise ModelError(
                f"quantity {self.title!r}: its function raised {type(error).__name__}: {error}. Remedy: a function "
                "that every answer has a value of, also that of a coarser setting"
            ) from error
        values = self._array(given)
        thinned = every if len(values) == len(getattr(answer, "times", ())) else 1
        return [self._condensed(self.title, "", values, thinned)]

    def _array(self, given: Any) -> np.ndarray:
        values = np.asarray(given)
        if values.dtype.kind in "biu":
            raise ModelError(
                f"quantity {self.title!r} is a count or a choice ({told_type(values)}), which jumps: no bound of its error "
                "is of use. Remedy: what changes continuously, such as a time, a distance or a force"
            )
        if values.dtype.kind not in "fc" or not values.size:
            raise ModelError(f"quantity {self.title!r} must give numbers, not {given!r}")
        if not np.all(np.isfinite(values)):
            raise ModelError(f"quantity {self.title!r} is not finite. Remedy: a function that gives numbers")
        return values if values.ndim else values[None]

    def _condensed(self, title: str, unit: str, values: np.ndarray, every: int) -> Values:
        """Return what of the values has the accuracy."""
        norm, values = 1.0, values[::every] if self.over == "time" else values
        largest = float(np.abs(values).max())
        if self.over == "rms":
            values = values[::every]
            values, norm = values / np.sqrt(len(values)), 2.0
            largest = float(np.linalg.norm(values.ravel()))
        elif self.over == "final":
            values = values[-1:]
        elif self.over == "largest":
            values = np.array([largest])
        return Values(title, unit, values, norm, largest)

    def allowed(self, size: float) -> float:
        """Return the largest error of a quantity of some size, in its unit."""
        return max(self.absolute or 0.0, (self.relative or 0.0) * size)


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


def check_accuracy(value: Any, name: str) -> None:
    """Refuse a relative accuracy that makes no sense."""
    if value is None:
        return
    if not (_is_number(value) and 0.0 < value < 1.0):
        raise ModelError(f"{name} accuracy must lie between 0 and 1, such as 1e-3, not {value!r}")
    if value < LEAST:
        raise ModelError(f"{name} accuracy of {value:g} is below round-off. Remedy: {LEAST:g} or more")


def _is_number(value: Any) -> bool:
    given = numbers(value)
    return given.shape == () and bool(np.isfinite(given)) and not isinstance(value, bool)


def told_type(values: np.ndarray) -> str:
    """Return the type of numbers in words."""
    return "true or false" if values.dtype.kind == "b" else "whole numbers"


Of = str | Quantity | Callable[[Any], Any]
"""How a quantity may be given."""


def quantities_of(of: Of | Sequence[Of] | Mapping[str, Of], accuracy: float | None) -> tuple[Quantity, ...]:
    """Return the quantities of an argument ``of=``, each with an accuracy.

    Raises
    ------
    ModelError
        If there is none, one is no quantity, or has no accuracy.
    """
    check_accuracy(accuracy, "the")
    if isinstance(of, Mapping):
        named = [(str(name), one) for name, one in of.items()]
    elif isinstance(of, (str, Quantity)) or callable(of):
        named = [("", of)]
    elif isinstance(of, (list, tuple)):
        named = [("", one) for one in of]
    else:
        raise ModelError(f"of must list channels, functions or kanefe.Quantity(...), not {of!r}")
    if not named:
        raise ModelError(
            "an accuracy was asked for, of nothing. Remedy: of=['position arm/tip'], channels or functions of the "
            "answer"
        )
    found = []
    for name, one in named:
        quantity = one if isinstance(one, Quantity) else Quantity(one)
        quantity = replace(quantity, name=name) if name else quantity
        if quantity.relative is None and quantity.absolute is None:
            if accuracy is None:
                raise ModelError(
                    f"quantity {quantity.title!r} has no accuracy. Remedy: accuracy=1e-3, or relative= or absolute= of "
                    "its kanefe.Quantity"
                )
            quantity = replace(quantity, relative=accuracy)
        found.append(quantity)
    titles = [quantity.title for quantity in found]
    twice = [title for title in titles if titles.count(title) > 1]
    if twice:
        raise ModelError(f"the quantity {twice[0]!r} is asked for twice. Remedy: once, or name= of one of them")
    return tuple(found)


def check_names(quantities: Sequence[Quantity], answer: Any) -> None:
    """Refuse channels that an answer would not have."""
    for quantity in quantities:
        if isinstance(quantity.what, str):
            quantity.read(answer)


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
