"""When a loop holds and counts as closed, how far one iteration may go: the same for the literal and compiled route.

They are here since compiled code holds them as numbers: only a change in this folder makes it anew.
"""

from typing import NamedTuple


class Closing(NamedTuple):
    """How far loops are closed, and by which steps."""

    tolerance: float = 1e-12
    """Largest gap of a loop that counts as closed, relative to the scene's length or in rad: about a hundred times
    round-off."""
    largest_opening: float = 1e-7
    """Gap during a run, relative to the same scale, above which a loop cannot be closed. At a singular position
    round-off leaves its root, about 1e-8; a drive beyond the reach of a mechanism leaves more after its first step."""
    largest_iterations: int = 80
    most_halvings: int = 12
    """Largest number of times that a step is halved until the gaps of the loops decrease."""
    largest_step: float = 0.4
    """Largest step of one iteration, rad or scene lengths: the loops are approximately linear over it."""
    unknown: float = 100.0
    largest_unknown: float = 1e-6
    """Pivot below which a row may in fact depend on others, in multiples of the square of the largest gap, and its
    largest value: rows that depend on each other in closed loops seem not to, by the square of how far these are
    open."""


CLOSING = Closing()

NEAR_SINGULAR = 1e-2
"""Weakest constraint, see `ConstrainedSolver.weakest`, below which the rates are those of the nearest closed state. The
stages of an explicit method leave some gap in the loops. Towards a singular position its effect is divided by powers of
the distance, and error control would approach the position and never pass it."""

HALF_ON = 0.5
"""Value above which a switched constraint holds: 0 is off and 1 is on, which methods keep to round-off."""

HELD_BEYOND = 10.0
"""Friction that holds within the step in which a slip with another coefficient begins, in multiples of the holding
limit. An event ends that step where the slip begins. If the equations changed there, the anchor force would be
perturbed within the step by the anchor's damping times the error of the speed, and the error of the time would be
hundredths of a period."""
