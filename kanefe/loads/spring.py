"""Springs and dampers along the line between two markers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.errors import ModelError
from kanefe.frames import Vector, numbers
from kanefe.kernels.force_elements.spring import SpringNumbers, spring, tensions
from kanefe.kernels.values.filled import filled_from
from kanefe.loads.action import End, LoadKernel
from kanefe.loads.along_line import AlongLine


@dataclass(frozen=True, eq=False)
class SpringDamper(AlongLine):
    """A tension along the line between two markers, which pulls them together.

    ``k (length - rest_length) + c rate``, or a table or a function of the user instead of the first term.

    Attributes
    ----------
    name : str
    ends : (Marker, Marker)
    stiffness, damping : float
        N/m and N s/m.
    rest_length : float
        m; NaN: the length at the start.
    lengths, forces : ndarray, shape (n,)
        Table of the tension, m and N, linear between its points and beyond its ends; empty: none.
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
        """Whether it dissipates or supplies energy."""
        return bool(self.damping or len(self.lengths) or self.function is not None)

    def given(self, t: float, length: float, rate: float) -> Vector:
        """Return the tension by the user's function, N: (1,), or (0,) without one."""
        if self.function is None:
            return np.zeros(0)
        try:
            value = numbers(self.function(length, rate))
        except Exception as error:
            error.add_note(f"the force of spring {self.name!r} at t = {t:.6g} s")
            raise
        if value.shape != () or not np.isfinite(value):
            raise ModelError(
                f"the force of spring {self.name!r} must be one finite number; at t = {t:.6g} s, length "
                f"{length:.6g} m and rate {rate:.6g} m/s it was {value!r}"
            )
        return value[None]

    def pull(self, t: float, length: Any, rate: Any, states: Vector) -> Any:
        """Return the tension, N; a function of the user is called with real numbers."""
        return sum(tensions(SpringNumbers(self.kernel.numbers), self.given(t, length.real, rate.real), length, rate))

    def started(self, t: float, ends: Sequence[End]) -> SpringDamper:
        """Return the spring; its rest length is the length at the start if none is given."""
        length = float(np.linalg.norm(ends[1].p - ends[0].p))
        if length <= 1e-12 * max(1.0, float(abs(ends[0].p).max())):
            raise ModelError(
                f"spring {self.name!r} has no length at the start: {self.ends[0].label} and {self.ends[1].label} are "
                "at one place, and it has no direction. Remedy: move an end, or use a bushing"
            )
        return replace(self, rest_length=length) if np.isnan(self.rest_length) else self

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return length (m), rate (m/s) and tension (N)."""
        length, rate, _ = self.path(t, ends)
        return np.array((length, rate, self.pull(t, length, rate, states)))

    @cached_property
    def kernel(self) -> LoadKernel:
        """Its compiled function and numbers."""
        table = np.concatenate((self.lengths, self.forces))
        given = filled_from(self, SpringNumbers, inputs=self.input_count, table_size=len(self.lengths), table=table)
        return LoadKernel(spring, given, spring)

    @property
    def input_count(self) -> int:
        """One with a function of the user, else none."""
        return 0 if self.function is None else 1

    def inputs(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return the tension by the user's function, N."""
        path = self.path(t, ends)
        return self.given(t, path.length, path.rate)

    def input_wrenches(self, t: float, ends: Sequence[End]) -> np.ndarray:
        """Return the wrenches of a tension of one newton."""
        return np.hstack((-self.path(t, ends).gradient, np.zeros((2, 3))))[None]
