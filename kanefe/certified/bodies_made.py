"""Bodies that are made again, once for each setting."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kanefe.certified.choice import Choice
from kanefe.certified.trial import timed
from kanefe.scene.scene import Scene

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody


class BodiesMade:
    """Bodies of a scene, made again once for each setting."""

    def __init__(self, scene: Scene) -> None:
        self._own = {entry.name: entry.flexible for entry in scene._entries}
        self._made: dict[str, tuple[FlexibleBody, float]] = {}

    def of(self, chosen: Choice) -> tuple[dict[str, FlexibleBody], float]:
        """Return the bodies that a choice changes, by name, and the CPU time that making them took, s."""
        found, keys = {}, set()
        for name, changes in chosen.bodies.items():
            body = self._own[name]
            if not changes or body is None:
                continue
            key = f"{id(body)} {sorted(changes.items())!r}"
            if key not in self._made:
                self._made[key] = timed(lambda body=body, changes=changes: body.rebuilt(**changes))[:2]
            found[name] = self._made[key][0]
            keys.add(key)
        return found, sum(self._made[key][1] for key in keys)
