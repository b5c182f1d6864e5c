"""Quantity: a number or a history of an answer, and how accurate it has to be."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import numbers

Over = Literal["time", "rms", "final", "largest"]
"""Part of a history that has the accuracy."""

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
