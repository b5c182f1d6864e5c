"""What a simulation requires of a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, Self

if TYPE_CHECKING:
    from kanefe.equations.given_state import Start
    from kanefe.equations.model import Model
    from kanefe.scene.held_inputs import HeldInput
    from kanefe.scene.scene import BodyEntry
    from kanefe.scene.targets import Named


class Steppable(Protocol):
    """See `kanefe.System`."""

    _entries: list[BodyEntry]

    def copy(self) -> Self: ...  # noqa: D102
    def freeze(self, t: float = 0.0, start: Start = None) -> Model: ...  # noqa: D102
    def _hold_inputs(self, named: Named | None, t: float, every: float) -> list[HeldInput]: ...
