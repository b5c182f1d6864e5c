"""Distributed loads on a surface or line of a flexible body: traction, pressure, load per length."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.fe_model.load_pattern import LoadPattern
from kanefe.frames import Matrix, Vector
from kanefe.loads.functions import Constant, SceneView


@dataclass(frozen=True, eq=False)
class FieldLoad:
    """A uniform load on a surface or line of a flexible body, per undeformed area or length.

    Attributes
    ----------
    label : str
        For messages and results.
    function : callable
        t, or (t, state), -> (3,) Pa (N/m on a line); of a pressure -> Pa.
    pattern : LoadPattern
        The surface or line.
    is_pressure : bool
    follows : bool
        True: components of G (a following load); False: of N. A pressure always follows.
    takes_state : bool
        Whether the function takes the state besides the time.
    """

    label: str
    function: Callable[..., Any]
    pattern: LoadPattern
    is_pressure: bool
    follows: bool
    takes_state: bool = False

    @property
    def is_constant(self) -> bool:
        """Whether the value is the same at all times."""
        return isinstance(self.function, Constant)

    def value(self, t: float, state: SceneView | None = None) -> Vector:
        """Return the traction (3,), or the pressure (), at time t."""
        value = np.asarray(self.function(t, state) if self.takes_state else self.function(t), dtype=float)
        shape = () if self.is_pressure else (3,)
        if value.shape != shape or not np.all(np.isfinite(value)):
            wanted = "one finite number" if self.is_pressure else "three finite numbers"
            raise ModelError(f"{self.label} must give {wanted}; at t = {t:.6g} s it gave {value!r}")
        return value

    def forces(
        self, t: float, A_NG: Matrix, eta: Vector, state: SceneView | None = None
    ) -> tuple[Vector, Vector, Vector]:
        """Return the forces on translation and rotation of G (in its components) and on the coordinates `eta`."""
        value = self.value(t, state)
        if self.is_pressure:
            return self.pattern.of_pressure(float(value), len(eta))
        return self.pattern.of_traction(value if self.follows else A_NG.T @ value, eta)
