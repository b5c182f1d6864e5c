"""Loads whose value is a constant or a function of the user: forces, torques, motors, tractions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite
from time import perf_counter
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.loads.functions import SPENT, Constant, SceneView

WORDS = {(): "one finite number", (3,): "three finite numbers"}
REAL = "fiub"
"""Kinds of numpy numbers that are real."""


class CircularLoad(ModelError):
    """A load uses a quantity that depends on the load itself."""


class UnfitValue(ModelError):
    """A function of a load gave no number, or several."""


class ValuedLoad:
    """A load whose value is a constant or a function of the user.

    Attributes
    ----------
    label : str
        Name in messages and results.
    function : callable
        t, or (t, state), -> the value.
    takes_state : bool
        Whether the function takes the state besides the time.
    """

    label: str
    function: Callable[..., Any]
    takes_state: bool

    @property
    def turns_with_frame(self) -> bool:
        """Whether it acts on a surface or line, and turns with the mesh frame alone, not as its body deforms."""
        return False

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the value: () or (3,)."""
        return (3,)

    @property
    def is_constant(self) -> bool:
        """Whether the value is the same at all times."""
        return isinstance(self.function, Constant)

    @property
    def turns(self) -> bool:
        """Whether its direction rotates with the body, or it is a torque, so that it contributes to the stiffness."""
        return False

    def unit(self, of_joint: Sequence[str]) -> str:
        """Return the unit of its value; the joint of its body has coordinates with these units, m or rad."""
        return "N"

    def value(self, t: float, state: SceneView | None = None) -> Vector:
        """Return the value at time t (s); a ModelError names the load if it has another shape or is not finite."""
        began = perf_counter()
        try:
            given = self.function(t, state) if self.takes_state else self.function(t)
        except CircularLoad as error:
            raise ModelError(f"{self.label} asks for {error}") from None
        except Exception as error:
            error.add_note(f"the function of {self.label} at t = {t:.6g} s{self.failed}")
            raise
        SPENT.seconds += perf_counter() - began
        # the usual cases, ten times faster; the square of what is finite may be too large, and is looked at below
        if isinstance(given, float) and isfinite(given) and self.shape == ():
            return np.array(given)
        value = np.asarray(given)
        if value.shape == (3,) == self.shape and value.dtype == float and isfinite(value.dot(value)):
            return value
        if value.shape != self.shape or value.dtype.kind not in REAL or not np.all(np.isfinite(value)):
            raise UnfitValue(
                f"{self.label} must give {WORDS[self.shape]}; at t = {t:.6g} s it gave {given!r}{self.advice(value)}"
            )
        return np.asarray(value, dtype=float)

    @property
    def failed(self) -> str:
        """What to think of if the function raises; empty: nothing."""
        return ""

    def advice(self, value: np.ndarray) -> str:
        """Return a remedy for a refused value; empty: none."""
        return ""
