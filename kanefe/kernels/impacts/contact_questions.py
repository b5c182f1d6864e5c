"""What events of rigid contacts are asked for in compiled code, and what they tell."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from kanefe.kernels.contact.output_places import Margins
from kanefe.kernels.language import Integers, RealRows, Reals, Record, Rows, in_place, inlined
from kanefe.kernels.values.filled import allocate


class Asks(IntEnum):
    """What is wanted: what follows an event, how far margins may be below zero by round-off, or the margins."""

    START = 0
    TOUCH = 1
    LIFT = 2
    SLIP = 3
    STICK = 4
    BLURS = 5
    MARGINS = 6


class WhyNot(IntEnum):
    """Why nothing is decided.

    The scene does not say; impacts have no impulses; a point that slips has no force or several; nor do several points
    together.
    """

    FOUND = -1  # it is
    UNKNOWN = 0
    NO_IMPULSES = 1
    PARADOX = 2
    NO_FORCES = 3


class Reported(IntEnum):
    """Reports of a contact, in the order of `kanefe.contact.rigid.rigid_contact.REPORTED_EVENTS`.

    Last that an impact was Poisson's where Newton's was asked for, and that one of several contacts depends on their
    order.
    """

    TOUCHES = 0
    LIFTS = 1
    BEGINS_SLIP = 2
    BEGINS_STICK = 3
    RESTS = 4
    BY_POISSON = 5
    BY_ORDER = 6


class ContactQuestion(Record):
    """What is asked, and what is told.

    Attributes
    ----------
    what : int
        `Asks`.
    tells_gains : bool
        Whether who asks tells impacts that make energy, which are undecided else.
    reports : int
        How many there are.
    why_not : int
        On return, `WhyNot`.
    when, span, stop : float
        Time, span and end of the run, s.
    rtol : float
        Of the run.
    length : float
        Of the scene, m.
    gained : float
        On return: the energy that impacts have made, J.
    blurs : Margins
        On return: how far each may be below zero.
    """

    what: int
    tells_gains: bool
    reports: int
    why_not: int
    when: float
    span: float
    stop: float
    rtol: float
    length: float
    gained: float
    blurs: Margins


class Report(Record):
    """A time (s), and the code of what is told."""

    t: float
    code: float


Reports = Rows[Report]


@in_place
class Inquiry(NamedTuple):
    """A question, and the reports that answer it.

    Attributes
    ----------
    asked, numbers : ndarray
        `ContactQuestion`.
    reports : ndarray
        `Reports`. Their codes are ``REPORTED contact + what``, and behind those of all contacts
        ``POINT_CODES point + 6 before + 2 after + is struck``.
    """

    asked: Integers
    numbers: Reals
    reports: RealRows


@inlined
def question_of(inquiry: Inquiry) -> ContactQuestion:
    """Return what is asked, and what is told."""
    return ContactQuestion(inquiry.asked, inquiry.numbers)


@inlined
def margin_of(margins: Margins, what: int) -> float:
    """Return how far a kind of event is: see `Asks`."""
    found = margins.gap
    if what == Asks.LIFT:
        found = margins.normal
    elif what == Asks.SLIP:
        found = margins.slip_margin
    elif what == Asks.STICK:
        found = margins.left_of_slip
    return found


@inlined
def no_blurs(blurs: Margins) -> None:
    """Write that no margin may be below zero."""
    blurs.gap = blurs.normal = blurs.slip_margin = blurs.left_of_slip = 0.0


REPORTED, POINT_CODES = len(Reported), 18
"""Number of the reports of a contact, and of the changes of a point: its status before and after, and whether it was
struck."""


def report_count(points: int) -> int:
    """Return how many reports there are at most of a moment: of each kind of event, of each point and its contact."""
    return 4 * (REPORTED + 2) * points


def inquiry_of(points: int) -> Inquiry:
    """Return the memory of questions about so many points."""
    reports = np.zeros((report_count(points), Report.number_count))
    return Inquiry._make((*allocate(ContactQuestion), reports))
