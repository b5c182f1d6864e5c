"""What a verification case is: a reference, a function that computes the same quantities, and their comparison."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Reference:
    """Definition of a case and the values it must give, as in ``references.json``.

    Attributes
    ----------
    id, title : str
    definition : str
        The scene, in SI units unless it says otherwise.
    quantity : str
        What is compared.
    values : Any
        Numbers, in lists and dicts.
    tolerance : str
        Largest error allowed, in words.
    source : str
        Where the values come from.
    """

    id: str
    title: str
    definition: str
    quantity: str
    values: Any
    tolerance: str
    source: str

    def allows(self, tolerance: float) -> bool:
        """Return whether a tolerance is one of those that the reference states, or tighter than all of them."""
        numbers = re.findall(r"(\d+(?:\.\d+)?(?:e-?\d+)?)(%?)", self.tolerance)
        stated = [float(number) * (0.01 if percent else 1.0) for number, percent in numbers]
        # what is not small is a count of elements, a modulus, a time
        stated = [number for number in stated if number < 0.1]
        return bool(stated) and (tolerance <= min(stated) or any(math.isclose(tolerance, s) for s in stated))


@dataclass(frozen=True)
class Check:
    """One compared quantity.

    Attributes
    ----------
    quantity : str
        With its unit, and whether the error is absolute ("abs") or relative ("rel").
    value, reference : float
        Computed and expected; of a set of numbers the pair that agrees least.
    error : float
        In the unit of the quantity if absolute.
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
        """Whether the error is within the tolerance; an error that is not a number is not."""
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
        # one that is not a number is the worst of all
        worst = int(np.argmax(np.where(np.isfinite(error), error, np.inf)))
        label = f"{quantity} ({kind})" if value.size == 1 else f"{quantity} ({kind}, worst of {value.size})"
        return cls(label, float(value.flat[worst]), float(reference.flat[worst]), float(error.flat[worst]), tolerance)


@dataclass(frozen=True)
class Case:
    """A verification case, or the part of one that needs a certain kind of body.

    Attributes
    ----------
    id : str
        Of its reference. Several parts may share it; all of them belong to the case.
    run : callable
        Reference -> checks, yielded one by one as they are computed.
    """

    id: str
    run: Callable[[Reference], Iterable[Check]]
