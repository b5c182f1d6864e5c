"""Springs and dampers along the line between two markers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.errors import ModelError, SimulationError
from kanefe.frames import Vector
from kanefe.loads.base import Action, End, Load, LoadKernel, Tangent

NONE = np.zeros(3)


class Line(NamedTuple):
    """A line between two ends: length (m), rate (m/s), and direction from the first to the second in N."""

    length: float
    rate: float
    direction: Vector


@dataclass(frozen=True, eq=False)
class SpringDamper(Load):
    """A force along the line of two markers; its tension pulls them together.

    ``k (length - rest_length) + c rate``, or instead of the first term a table or a function of the user.

    Attributes
    ----------
    name : str
    ends : (Marker, Marker)
    stiffness, damping : float
        N/m and N s/m.
    rest_length : float
        m; NaN: as long as it is at the start.
    lengths, forces : ndarray, shape (n,)
        Table of the tension, m and N, straight between its points and beyond its ends; empty: none.
    function : callable or None
        (length, rate) -> tension, in m, m/s and N.
    """

    name: str
    ends: tuple[Marker, ...]
    stiffness: float
    damping: float
    rest_length: float
    lengths: np.ndarray
    forces: np.ndarray
    function: Callable[[float, float], Any] | None

    kind = "spring"
    columns = ("length [m]", "rate [m/s]", "tension [N]")

    @property
    def exchanges_energy(self) -> bool:
        """Whether it takes energy from the scene or gives it."""
        return bool(self.damping or len(self.lengths) or self.function is not None)

    def given(self, t: float, length: float, rate: float) -> float:
        """Return the part of the tension that the table or the user's function gives, N."""
        if self.function is not None:
            value = np.asarray(self.function(length, rate), dtype=float)
            if value.shape != () or not np.isfinite(value):
                raise ModelError(
                    f"the force of spring {self.name!r} must be one finite number; at t = {t:.6g} s, length "
                    f"{length:.6g} m and rate {rate:.6g} m/s it was {value!r}"
                )
            return float(value)
        if not len(self.lengths):
            return 0.0
        i = min(max(int(np.searchsorted(self.lengths, length)), 1), len(self.lengths) - 1)
        slope = (self.forces[i] - self.forces[i - 1]) / (self.lengths[i] - self.lengths[i - 1])
        return float(self.forces[i - 1] + slope * (length - self.lengths[i - 1]))

    def line(self, t: float, ends: Sequence[End]) -> Line:
        """Return length, rate and direction.

        Raises
        ------
        SimulationError
            If the ends are at one place.
        """
        r = ends[1].p - ends[0].p
        length = float(np.linalg.norm(r))
        if length == 0.0:
            raise SimulationError(
                f"spring {self.name!r} has no length at t = {t:.6g} s, and so no direction. Remedy: a bushing"
            )
        e = r / length
        return Line(length, float(e @ (ends[1].v - ends[0].v)), e)

    def action(self, t: float, ends: Sequence[End], states: Vector) -> Action:
        """Return its pull on both ends (Eq. 11); the work of a table or function counts as given."""
        length, rate, e = self.line(t, ends)
        given = self.given(t, length, rate)
        pull = (self.stiffness * (length - self.rest_length) + self.damping * rate + given) * e
        return Action(
            np.array((np.append(pull, NONE), np.append(-pull, NONE))),
            potential=0.5 * self.stiffness * (length - self.rest_length) ** 2,
            taken=self.damping * rate * rate,
            given=-given * rate,
        )

    def started(self, t: float, ends: Sequence[End]) -> SpringDamper:
        """Return the spring, slack at its length at the start where it has no rest length."""
        length = float(np.linalg.norm(ends[1].p - ends[0].p))
        if length <= 1e-12 * max(1.0, float(abs(ends[0].p).max())):
            raise ModelError(
                f"spring {self.name!r} has no length at the start: {self.ends[0].label} and {self.ends[1].label} are "
                "at one place, and it has no direction. Remedy: move an end, or use a bushing"
            )
        return replace(self, rest_length=length) if np.isnan(self.rest_length) else self

    def tangent(self, t: float, ends: Sequence[End], states: Vector) -> Tangent:
        """Return stiffness and damping along the line, without what turning it does under load."""
        length, _, e = self.line(t, ends)
        row = np.concatenate((-e, NONE, e, NONE))
        return Tangent(row[None], np.array((self._slope(length),)), np.array((self.damping,)))

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return length (m), rate (m/s) and tension (N)."""
        length, rate, _ = self.line(t, ends)
        tension = self.stiffness * (length - self.rest_length) + self.damping * rate + self.given(t, length, rate)
        return np.array((length, rate, tension))

    @property
    def kernel(self) -> LoadKernel:
        """Numbers: stiffness, damping, rest length, inputs (0 or 1), table's size, its lengths, its forces."""
        from kanefe.kernels.force_elements.spring import spring

        constants = (self.stiffness, self.damping, self.rest_length, float(self.input_count), float(len(self.lengths)))
        return LoadKernel(spring, np.concatenate((constants, self.lengths, self.forces)), spring)

    @property
    def input_count(self) -> int:
        """One for a law of the user's."""
        return 0 if self.function is None else 1

    def inputs(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return the tension that the user's function gives, N."""
        length, rate, _ = self.line(t, ends)
        return np.array((self.given(t, length, rate),))

    def input_wrenches(self, t: float, ends: Sequence[End]) -> np.ndarray:
        """Return the pull of one newton."""
        _, _, e = self.line(t, ends)
        return np.array(((np.append(e, NONE), np.append(-e, NONE)),))

    def _slope(self, length: float) -> float:
        """Return the stiffness at a length, N/m; none is known of a user's function."""
        if not len(self.lengths):
            return self.stiffness
        i = min(max(int(np.searchsorted(self.lengths, length)), 1), len(self.lengths) - 1)
        return float((self.forces[i] - self.forces[i - 1]) / (self.lengths[i] - self.lengths[i - 1]))
