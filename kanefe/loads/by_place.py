"""Loads on a surface that vary by place: a shape times a value, or a field of places and time."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.fe_model.place_field import Over, checked_field, takes_time
from kanefe.frames import Vector
from kanefe.loads.field_load import FieldLoad
from kanefe.loads.functions import Constant
from kanefe.loads.moving_field import MovingField, quadrature_of

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody
    from kanefe.fe_model.load_pattern import LoadPattern

HELD = 0.05
"""Deformation in the upper third of the modes, relative to all (root of the energy), from which it is told."""


@dataclass(frozen=True, eq=False)
class Along:
    """A function of one number, times a direction."""

    function: Callable[..., Any]
    direction: Vector

    def __call__(self, *arguments: Any) -> Any:
        """Return three components; what is not a number is returned unchanged, for the error of the load."""
        value = np.asarray(self.function(*arguments))
        return value * self.direction if value.shape == () else value


@dataclass(frozen=True, eq=False)
class ByPlace:
    """A surface of a body, and by what loads on it vary.

    Attributes
    ----------
    body : FlexibleBody
    name : str
        Of the body in its scene.
    pattern : LoadPattern
        Of uniform loads.
    over : callable or array_like
    label : str
        Of the load, for messages.
    """

    body: FlexibleBody
    name: str
    pattern: LoadPattern
    over: Over
    label: str

    @property
    def values(self) -> int:
        """How many numbers the field gives at a place."""
        return checked_field(self.over, self.body.nodes, self.label)[1]

    def pressure(self, function: Callable[..., Any], takes_state: bool, follows: bool) -> list[FieldLoad]:
        """Return the loads of a pressure, given the factor of the field."""
        again = partial(self._on, "pressure", function, takes_state, follows)
        return [replace(load, again=again) for load in self._pressure(function, takes_state, follows)]

    def traction(self, function: Callable[..., Any], takes_state: bool, follows: bool) -> list[FieldLoad]:
        """Return the loads of a traction, given the factor of the field: three numbers, or one of a field of vectors.

        On lines, of a load per length.
        """
        again = partial(self._on, "traction", function, takes_state, follows)
        return [replace(load, again=again) for load in self._traction(function, takes_state, follows)]

    def _on(self, kind: str, function: Any, takes_state: bool, follows: bool, body: FlexibleBody) -> list[FieldLoad]:
        """Return the loads of a pressure or traction on another body with this surface."""
        other = replace(self, body=body, pattern=body.load_pattern(self.pattern.name))
        made: list[FieldLoad] = getattr(other, kind)(function, takes_state, follows)
        return made

    def _pressure(self, function: Callable[..., Any], takes_state: bool, follows: bool) -> list[FieldLoad]:
        if self.values != 1:
            raise ModelError(f"over= of {self.label} gives three numbers a place. Remedy: one, or add_traction")
        if self._moves:
            if follows:
                raise ModelError(
                    f"{self.label}: over= is a function of places and time, which cannot follow the surface. Remedy: "
                    "several add_pressure, each with a function of time and one of places"
                )
            return self._moving(function, True, False)
        pattern = self._shaped(None)
        self._tell_of_statics(pattern.pressure_elastic[None])
        return [FieldLoad(self.label, function, pattern, True, follows, takes_state)]

    def _traction(self, function: Callable[..., Any], takes_state: bool, follows: bool) -> list[FieldLoad]:
        if self._moves:
            return self._moving(function, False, follows)
        if self.values == 1:
            pattern = self._shaped(None)
            self._tell_of_statics(pattern.shape_first)
            return [FieldLoad(self.label, function, pattern, False, follows, takes_state)]
        made, shares = [], np.zeros(self.body.count)
        for axis, unit in enumerate(np.eye(3)):
            along = Constant(function.value * unit) if isinstance(function, Constant) else Along(function, unit)
            pattern = self._shaped(axis)
            shares += pattern.shape_first[axis]
            if pattern.shape_first.any() or pattern.first.any():  # else there is no such component
                made.append(FieldLoad(self.label, along, pattern, False, follows, takes_state))
        self._tell_of_statics(shares[None])
        return made

    @property
    def _moves(self) -> bool:
        return callable(self.over) and takes_time(self.over, self.label)

    def _shaped(self, component: int | None) -> LoadPattern:
        return self.pattern.shaped(self.over, self.body.nodes, self.body.basis, self.label, component)

    def _moving(self, function: Callable[..., Any], is_pressure: bool, follows: bool) -> list[FieldLoad]:
        """Return a load for each generalised force of a field of places and time."""
        if not isinstance(function, Constant):
            raise ModelError(
                f"{self.label}: over= is a function of places and time, and the factor is one too. Remedy: a number, "
                "such as 1.0, and all of the function in over="
            )
        if not isinstance(self.body.stiffness, np.ndarray) or self.pattern.face is None:
            raise ModelError(
                f"{self.label}: over= is a function of places and time, and the body is unreduced or made from "
                "matrices. Remedy: a reduction, shell_body or solid_body; or products of a function of time and one of "
                "places"
            )
        basis = self.body.basis[:, : self.body.free_count]
        points = quadrature_of(self.pattern.face, basis)
        field = MovingField(
            self.over, self.label, self.name, np.asarray(function.value, dtype=float), is_pressure, follows, **points
        )
        return [FieldLoad(self.label, row, unit, True, False, not is_pressure) for unit, row in field.rows()]

    def _tell_of_statics(self, shares: np.ndarray) -> None:
        """Warn if the modes of a reduced body, chosen without it, seem not to hold the static shape of a load.

        `shares`: its forces on the coordinates, (m, K).
        """
        record = self.body.provenance.get("reduction")
        k = self.body.free_count
        if not isinstance(record, dict) or record.get("method") == "None" or not k:
            return
        energy = (shares[:, :k] ** 2).sum(axis=0) / np.diag(self.body.stiffness)[:k]
        upper = float(np.sqrt(energy[k - max(k // 3, 1) :].sum() / energy.sum())) if energy.any() else 0.0
        if upper > HELD:
            warnings.warn(
                f"{self.label} varies by place, and the modes of the body were chosen without it: the upper third of "
                f"them holds {100.0 * upper:.2g} % of its static deformation (root of the strain energy), so that more "
                f"may be missing. Remedy: surfaces={{'own': LoadShape({self.pattern.name!r}, over=...)}} when the body "
                "is made, with 'own' in loads= of its reduction",
                AccuracyWarning,
                stacklevel=outside(),
            )
