"""Distributed loads on a surface or line of a flexible body: traction, pressure, load per length."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.fe_model.load_pattern import told_vector
from kanefe.frames import Matrix, Vector
from kanefe.loads.functions import Constant, SceneView
from kanefe.loads.valued_load import ValuedLoad

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody
    from kanefe.fe_model.load_pattern import LoadPattern


@dataclass(frozen=True, eq=False)
class FieldLoad(ValuedLoad):
    """A uniform load on a surface or line of a flexible body, per undeformed area or length.

    Attributes
    ----------
    label : str
        Name in messages and results.
    function : callable
        t, or (t, state), -> (3,) Pa (N/m on a line); for a pressure -> Pa.
    pattern : LoadPattern
        The surface or line.
    is_pressure : bool
    follows : bool
        True: components of G (a following load); False: of N. A pressure always turns with G; True: it follows the
        deformed surface too.
    takes_state : bool
        Whether the function takes the state besides the time.
    again : callable or None
        ``again(body)``: all loads of one call that varies by place, on another body. None: a uniform load.
    """

    label: str
    function: Callable[..., Any]
    pattern: LoadPattern
    is_pressure: bool
    follows: bool
    takes_state: bool = False
    again: Callable[[FlexibleBody], list[FieldLoad]] | None = field(default=None, compare=False)

    @property
    def turns(self) -> bool:
        """Whether it is a pressure, or follows its body."""
        return self.is_pressure or self.follows

    @property
    def turns_with_frame(self) -> bool:
        """Whether it turns with G alone, and not as its surface deforms."""
        return self.is_pressure != self.follows

    def unit(self, of_joint: Sequence[str]) -> str:
        """Return N/m on a line, else Pa."""
        return "N/m" if self.pattern.kind == "line" else "Pa"

    @property
    def failed(self) -> str:
        """Tell where functions of places go."""
        return "; a function of places is over= of add_pressure, add_traction or add_line_load"

    @property
    def resultant(self) -> str:
        """Return force and moment on the undeformed body about the origin of its mesh frame, for texts."""
        pattern, function = self.pattern, self.function
        if not (pattern.measure or pattern.first.any()):
            return ", by place and time"
        value, per = (function.value, "") if isinstance(function, Constant) else (1.0, f" per {self.unit(())}")
        if self.is_pressure:
            force, moment = value * pattern.pressure_force, value * pattern.pressure_moment
        elif not per:
            force, moment = pattern.measure * value, np.cross(pattern.first, value)
        else:
            return f": over {pattern.measure:.6g} {'m' if pattern.kind == 'line' else 'm2'}"
        return f": {told_vector(force)} N{per}, moment {told_vector(moment)} N m{per}"

    @property
    def shape(self) -> tuple[int, ...]:
        """Three numbers for a traction or line load, one for a pressure."""
        return () if self.is_pressure else (3,)

    def forces(
        self, t: float, A_NG: Matrix, eta: Vector, state: SceneView | None = None
    ) -> tuple[Vector, Vector, Vector]:
        """Return the forces on translation and rotation of G (in its components) and on the coordinates `eta`."""
        value = self.value(t, state)
        if self.is_pressure:
            return self.pattern.of_pressure(float(value), eta, self.follows)
        return self.pattern.of_traction(value if self.follows else A_NG.T @ value, eta)
