"""Torque of a motor about the axis of a joint (or force along it): acts on the child and, reversed, on the parent."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from kanefe.loads.valued_load import ValuedLoad


@dataclass(frozen=True, eq=False)
class JointLoad(ValuedLoad):
    """A generalised force on one speed of a joint.

    Attributes
    ----------
    label : str
        For messages and results.
    function : callable
        t, or (t, state), -> N m along an angle, N along a distance.
    coordinate : int
        Which coordinate of the joint it acts along.
    takes_state : bool
        Whether the function takes the state besides the time.
    """

    label: str
    function: Callable[..., Any]
    coordinate: int = 0
    takes_state: bool = False

    @property
    def shape(self) -> tuple[int, ...]:
        """One number."""
        return ()

    def unit(self, of_joint: Sequence[str]) -> str:
        """Return N m along an angle, N along a distance."""
        return "N m" if of_joint[self.coordinate] == "rad" else "N"
