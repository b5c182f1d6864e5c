"""Motor torques about the axis of a joint (or forces along it), on the child and, reversed, on the parent."""

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
        Name in messages and results.
    function : callable
        t, or (t, state), -> N m along an angle, N along a distance.
    coordinate : int
        Number of the coordinate of the joint.
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
