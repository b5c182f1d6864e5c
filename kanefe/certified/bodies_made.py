"""Bodies that are made again, once for each setting."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from kanefe.certified.choice import Choice
from kanefe.certified.trial import timed

if TYPE_CHECKING:
    from kanefe.scene.segments import SegmentMethods


class BodiesMade:
    """Bodies of a scene, made again once for each setting."""

    def __init__(self, scene: SegmentMethods) -> None:
        self._own: dict[str, Any] = {entry.name: entry.flexible for entry in scene._entries} | scene._segmented
        self._made: dict[str, tuple[Any, float]] = {}

    def of(self, chosen: Choice) -> tuple[dict[str, Any], float]:
        """Return the bodies that a choice changes, by name, and the CPU time that making them took, s."""
        found, keys = {}, set()
        for name, changes in chosen.bodies.items():
            body = self._own[name]
            if not changes:
                continue
            key = f"{id(body)} {sorted(changes.items())!r}"
            if key not in self._made:
                made, seconds, _ = timed(partial(body.rebuilt, **changes))
                self._made[key] = made, seconds
            found[name] = self._made[key][0]
            keys.add(key)
        return found, sum(self._made[key][1] for key in keys)
