"""The result of a reduction method: columns that span the motions kept, and the record of their choice."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, Protocol

import numpy as np

from kanefe.errors import ModelError
from kanefe.fe_model.statics import StaticProblem
from kanefe.frames import numbers
from kanefe.reduction.load_cases import Load, checked_loads


@dataclass(frozen=True, eq=False)
class Basis:
    """Columns that span the motions kept, and the record of their choice.

    Attributes
    ----------
    columns : ndarray, shape (tied, m)
        Motions of the tied coordinates with the fixed components at rest; of any scale, and not necessarily
        independent.
    record : mapping
        Record of the choice for reports (json-able).
    """

    columns: np.ndarray
    record: Mapping[str, Any] = field(default_factory=dict)


class Reduction(Protocol):
    """A method of reducing a body.

    Attributes
    ----------
    loads : tuple of str, LoadCase or PatchCase
        Load cases whose static shapes are kept.
    error_up_to : float or None
        Frequency in Hz up to which the error is estimated; None: it is not.
    """

    @property
    def loads(self) -> Sequence[Load]: ...  # noqa: D102

    @property
    def error_up_to(self) -> float | None: ...  # noqa: D102

    def basis(self, problem: StaticProblem) -> Basis:
        """Return columns that span the motions kept, with the fixed components at rest."""
        ...


class Options:
    """Base of the frozen dataclasses of options: its repr shows what differs from the defaults."""

    def __repr__(self) -> str:
        values = [(item, getattr(self, item.name)) for item in fields(self)]  # type: ignore[arg-type]
        shown = [f"{item.name}={v!r}" for item, v in values if v is not item.default and v != item.default]
        return f"{type(self).__name__}({', '.join(shown)})"

    def _check_shared(self, loads: Any, error_up_to: float | None) -> None:
        """Check `loads` and `error_up_to`, and keep the loads as a tuple."""
        object.__setattr__(self, "loads", checked_loads(loads))
        check_frequency("error_up_to", error_up_to)


def check_frequency(name: str, value: float | None) -> None:
    """Refuse a frequency that is not above zero."""
    if value is not None and not (is_number(value) and np.isfinite(numbers(value)) and value > 0):
        raise ModelError(f"{name} must be above zero Hz and finite, not {value!r}")


def check_count(method: str, modes: Any) -> None:
    """Refuse a number of modes that is not a whole number."""
    if modes is not None and not (is_number(modes) and 0 <= modes < 2**63 and modes == int(modes)):
        raise ModelError(f"the number of {method} modes must be a whole number >= 0, not {modes!r}")


def is_number(value: Any) -> bool:
    """Return whether a value is a real number in the range of floats."""
    given = numbers(value)
    return given.shape == () and not np.isnan(given)
