"""What events of rigid contacts are asked for in compiled code, and what they tell: the numbers of a call."""

from __future__ import annotations

START, TOUCH, LIFT, SLIP, STICK, BLURS, MARGINS = range(7)
"""Wanted of a call: what follows an event, how far each margin may be below zero by round-off, or the margins."""

WHAT, WHEN, RUN_SPAN, RUN_END, RUN_RTOL, LENGTH, TELLS_GAINS = range(7)
REPORT_COUNT, IS_DECIDED, WHY_NOT, GAINED, BLUR = range(7, 12)
"""Numbers of a call: what it is asked for; time, span and end of the run (s); its rtol; length of the scene (m);
whether who asks tells impacts that make energy, which are undecided else; how many reports there are. On return:
whether it is decided, and why not; the energy that impacts have made, J; from there on the four blurs, from TOUCH to
STICK."""
ASKED = BLUR + 4

UNKNOWN, NO_IMPULSES, PARADOX, NO_FORCES = range(4)
"""Why nothing is decided: the scene does not say; impacts have no impulses; a point that slips has no force or several;
nor do several points together."""

TOUCHES, LIFTS, BEGINS_SLIP, BEGINS_STICK, RESTS, BY_POISSON, BY_ORDER = range(7)
"""Reports of a contact, in the order of `kanefe.contact.rigid.rigid_contact.REPORTED_EVENTS`; last that an impact was
Poisson's where Newton's was asked for, and that one of several contacts depends on their order."""
REPORTED = 7

POINT_CODES = 18
"""Number of the changes of a point: its status before and after, and whether it was struck."""


def report_count(points: int) -> int:
    """Return how many reports there are at most of a moment: of each kind of event, of each point and its contact."""
    return 4 * (REPORTED + 2) * points
