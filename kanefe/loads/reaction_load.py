"""The interface of loads that follow the reaction of a joint."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol, Self

from kanefe.frames import Vector

if TYPE_CHECKING:
    from kanefe.bodies.marker import CoordinateMarker
    from kanefe.joints.joint_friction import RubbingSurfaces
    from kanefe.loads.action import End


def reaction_load(load: Any) -> ReactionLoad | None:
    """Return what follows the reaction of a joint in a load, its `reaction_load` if it has such; otherwise None."""
    found: ReactionLoad | None = getattr(load, "reaction_load", None)
    return found


class ReactionLoad(Protocol):
    """A load along coordinates of a joint, whose last two states follow the load from the joint's reaction."""

    @property
    def name(self) -> str:
        """Unique among the loads between frames of a scene."""
        ...

    @property
    def ends(self) -> tuple[CoordinateMarker, ...]:
        """Coordinates of the joint."""
        ...

    @property
    def surfaces(self) -> RubbingSurfaces:
        """Relation of the load to the reaction."""
        ...

    @property
    def load_state(self) -> int:
        """Index of the load of friction among its states; its rate is the next."""
        ...

    def load(self, wrench: Vector, ends: Sequence[End], states: Vector) -> float:
        """Return the load from a reaction (6,) in the axes of the body's frame, N."""
        ...

    def load_rates(self, wrench: Vector, ends: Sequence[End], states: Vector) -> Vector:
        """Return the rates of the load of friction and of its own rate, for a reaction (6,)."""
        ...

    def with_first_load(self, load: float) -> Self:
        """Return this load with its initial value, N."""
        ...
