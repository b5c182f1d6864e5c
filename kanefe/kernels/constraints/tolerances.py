"""When a loop holds and counts as closed, how far one iteration may go: the same for the literal and compiled route.

They are here since compiled code holds them as numbers: only a change in this folder makes it anew.
"""

TOLERANCE = 1e-12
"""Largest opening of a loop that counts as closed: of the scene's length, or in rad. Some hundred times round-off."""

LARGEST_OPENING = 1e-7
"""Opening during a run, on the same scale, that means a loop cannot be closed. At a singular position round-off leaves
its root, some 1e-8; a drive beyond the reach of a mechanism leaves more after its first step."""

LARGEST_ITERATIONS = 80

MOST_HALVINGS = 12
"""Tries of a step, each half as long as the one before, until the loops open less."""

LARGEST_STEP = 0.4
"""Of one iteration, in rad or scene lengths: the loops are linear over less than that."""

NEAR_SINGULAR = 1e-2
"""Weakest constraint, see `ConstrainedSolver.weakest`, below which the rates are those of the nearest closed state.

The stages of an explicit method leave the loops open by some error. Towards a singular position it is divided by powers
of the distance from it, and error control would creep up to the position and never pass it.
"""

HALF_ON = 0.5
"""A constraint that is switched holds with its switch above it: 0 is off and 1 on, which methods keep to round-off."""

HELD_BEYOND = 10.0
"""Times what friction holds: so far it holds on within the step in which it begins to slip by another coefficient.

An event ends that step where the slip begins. Equations that changed there would bend the pull in the step, by the
anchor's damping times what a run does not resolve of a speed, and the moment would be wrong by hundredths of a period.
"""
