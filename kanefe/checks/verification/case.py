"""Definition of a verification case: a reference, a function that computes the same quantities, the comparison."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Reference:
    """Definition of a case and its expected values, as in ``references.json``.

    Attributes
    ----------
    id, title : str
    definition : str
        Description of the scene, in SI units unless stated otherwise.
    quantity : str
        Compared quantities.
    values : Any
        Numbers, in lists and dicts.
    tolerance : str
        Largest error allowed, in words.
    source : str
        Source of the values.
    """

    id: str
    title: str
    definition: str
    quantity: str
    values: Any
    tolerance: str
    source: str

    def allows(self, tolerance: float) -> bool:
        """Return whether a tolerance is one of those stated in the reference, or tighter than all of them."""
        numbers = re.findall(r"(\d+(?:\.\d+)?(?:e-?\d+)?)(%?)", self.tolerance)
        values = [(float(number) * (0.01 if percent else 1.0), percent) for number, percent in numbers]
        # larger numbers than this, not in percent, are counts, moduli or times
        stated = [value for value, percent in values if percent or value < 0.1]
        return bool(stated) and (tolerance <= min(stated) or any(math.isclose(tolerance, s) for s in stated))


@dataclass(frozen=True)
class Check:
    """One compared quantity.

    Attributes
    ----------
    quantity : str
        With its unit, and whether the error is absolute ("abs") or relative ("rel").
    value, reference : float
        Computed and expected value; of arrays, the pair with the largest error.
    error : float
        In the unit of the quantity if absolute, 1 if relative.
    tolerance : float
        Largest error that passes.
    """

    quantity: str
    value: float
    reference: float
    error: float
    tolerance: float

    @property
    def passed(self) -> bool:
        """Whether the error is within the tolerance; nan is not."""
        return bool(self.error <= self.tolerance)

    @classmethod
    def absolute(cls, quantity: str, values: Any, references: Any, tolerance: float) -> Check:
        """Compare numbers, or arrays of one shape, by ``|value - reference|``."""
        return cls._of(quantity, values, references, tolerance, "abs")

    @classmethod
    def relative(cls, quantity: str, values: Any, references: Any, tolerance: float) -> Check:
        """Compare numbers, or arrays of one shape, by ``|value - reference| / |reference|``.

        Examples
        --------
        >>> Check.relative("first two frequencies [Hz]", [10.0, 20.02], [10.0, 20.0], 1e-2).quantity
        'first two frequencies [Hz] (rel, worst of 2)'
        """
        return cls._of(quantity, values, references, tolerance, "rel")

    @classmethod
    def _of(cls, quantity: str, values: Any, references: Any, tolerance: float, kind: str) -> Check:
        value, reference = np.asarray(values, dtype=float), np.asarray(references, dtype=float)
        if value.shape != reference.shape or not value.size:
            raise ValueError(f"{quantity}: computed values of shape {value.shape} against {reference.shape}")
        error = np.abs(value - reference)
        if kind == "rel":
            error = error / np.abs(reference)
        # an error that is not finite counts as the largest
        worst = int(np.argmax(np.where(np.isfinite(error), error, np.inf)))
        label = f"{quantity} ({kind})" if value.size == 1 else f"{quantity} ({kind}, worst of {value.size})"
        return cls(label, float(value.flat[worst]), float(reference.flat[worst]), float(error.flat[worst]), tolerance)


@dataclass(frozen=True)
class Case:
    """A verification case, or a part of one.

    Attributes
    ----------
    id : str
        Id of its reference. The parts of a case have the same id.
    run : callable
        Reference -> checks, yielded one by one.
    """

    id: str
    run: Callable[[Reference], Iterable[Check]]
