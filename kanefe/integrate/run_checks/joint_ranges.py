"""Ranges of joint coordinates: a run that comes to the end of one fails there and says so."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.integrate.events.event import Event
from kanefe.integrate.status import RunStatus
from kanefe.tree.body_terms import BodyTerms
from kanefe.tree.model_data import ModelData
from kanefe.tree.scene_state import SceneState

ROUND_OFF = 1e-9
"""Excess of a coordinate over its range, relative to the range, that is permitted: a motion may end at the end of its
range."""

REMEDY = "a joint of a larger range, a stop before its end (forces=CoordinateForce(limits=...)), or a shorter run"


@dataclass(frozen=True, eq=False)
class Range:
    """Between what values a coordinate of a joint may be.

    Attributes
    ----------
    body : BodyTerms
    number : int
        Of the coordinate in the joint.
    ends : (float, float)
        m or rad.
    """

    body: BodyTerms
    number: int
    ends: tuple[float, float]

    def coordinate(self, t: float, q: Vector) -> float:
        """Return the coordinate at time t (s) and coordinates q of the scene, m or rad."""
        return float(self.body.joint_coordinates(t, q)[self.number])

    def left(self, t: float, state: SceneState) -> float:
        """Return how far the coordinate is from the nearer end, m or rad; below zero beyond it."""
        low, high = self.ends
        x, size = self.coordinate(t, state.q), max(abs(end) for end in (high - low, low, high) if math.isfinite(end))
        return min(x - low, high - x) + ROUND_OFF * size

    def __str__(self) -> str:
        joint, (low, high) = self.body.joint, self.ends
        name, unit = joint.coordinate_names[self.number].partition(" [")[0], joint.units[self.number]
        return (
            f"the {name} of the {joint.kind} joint of body {self.body.name!r}, "
            f"which may be between {low:.6g} and {high:.6g} {unit},"
        )


@dataclass(frozen=True, eq=False)
class EndOfRange(Event):
    """The moment at which a coordinate leaves its range; the run fails there.

    Attributes
    ----------
    of : Range
    """

    of: Range = field(kw_only=True)

    def status(self, t: float) -> RunStatus:
        """Return that the run failed here."""
        return RunStatus("failed", t, f"{self.of} comes to its end", REMEDY)


def ends_of_ranges(model: ModelData, t: float) -> tuple[EndOfRange, ...]:
    """Return what a run that starts at time t (s) watches of joints whose coordinates have ranges.

    Raises
    ------
    ModelError
        If a coordinate is beyond its range at the start.
    """
    found = []
    start = SceneState(model, t, model.initial_coordinates, model.initial_speeds)
    for body in model.bodies:
        for number, ends in enumerate(body.joint.ranges):
            if ends is None:
                continue
            of = Range(body, number, ends)
            if of.left(t, start) < 0.0:
                raise ModelError(f"{of} starts at {of.coordinate(t, start.q):.6g}. Remedy: a start within its range")
            found.append(EndOfRange(f"{body.name}: end of coordinate {number}", of.left, -1, terminal=True, of=of))
    return tuple(found)
