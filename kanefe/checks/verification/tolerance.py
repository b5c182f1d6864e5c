"""Factor on the tolerances of the runs of cases: ``kanefe verify --tol``."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from kanefe.errors import ModelError

LARGEST_RTOL = 0.1

_factor: ContextVar[float] = ContextVar("factor on the tolerances", default=1.0)


@contextmanager
def tolerances_times(factor: float) -> Iterator[None]:
    """Multiply the relative tolerance of every run of a case inside the ``with`` block.

    Raises
    ------
    ModelError
        If the factor is not a finite number above zero.

    Examples
    --------
    >>> with tolerances_times(100.0):
    ...     scaled(1e-8)
    1e-06
    """
    if not (math.isfinite(factor) and factor > 0.0):
        raise ModelError(f"the factor on the tolerances must be above zero, not {factor!r}")
    token = _factor.set(factor)
    try:
        yield
    finally:
        _factor.reset(token)


def scaled(rtol: float) -> float:
    """Return the relative tolerance of a run, from the nominal one of its case; at most `LARGEST_RTOL`."""
    return min(_factor.get() * rtol, LARGEST_RTOL)
