"""Checks of numbers from the user."""

from __future__ import annotations

import math

from kanefe.errors import ModelError
from kanefe.frames import numbers


def checked_number(value: object, what: str, *, above: float | None = None, least: float | None = None) -> float:
    """Return a finite number.

    Raises
    ------
    ModelError
        If it is not finite or below its limit; the message names `what`.
    """
    given = numbers(value)
    number = float(given) if given.shape == () else math.nan
    if not math.isfinite(number) or (above is not None and number <= above) or (least is not None and number < least):
        limit = f" above {above:g}" if above is not None else "" if least is None else f", {least:g} or above"
        raise ModelError(f"{what} must be a finite number{limit}, not {value!r}")
    return number
