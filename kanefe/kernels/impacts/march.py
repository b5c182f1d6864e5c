"""Memory of steps over the impacts of rigid contacts: what they are asked for, and what they have told."""

from enum import IntEnum
from typing import NamedTuple

from kanefe.kernels.constraints.contact_margins import Looked
from kanefe.kernels.events.closing_call import ClosingCall
from kanefe.kernels.impacts.decision import Asking
from kanefe.kernels.impacts.step_impulses import Step
from kanefe.kernels.language import Integers, Reals, Record, in_place
from kanefe.kernels.tables import FlexibleTables, Loops, Tables


class Marching(NamedTuple):
    """From where on numbers count in steps over impacts."""

    beyond: float = 1e-6
    """Violation relative to the friction limit, to the largest normal force and to the scene's length above which the
    run is in error."""
    doubly: float = 2.0
    """Penetration, in multiples of the first-order error of steps over impacts, above which it is an error."""
    round_off: float = 1e-9
    """Tolerance, relative to a step, by which the last step may be longer."""


MARCHING = Marching()


class Ending(IntEnum):
    """How steps end.

    At the last output or the most steps; before one that is left to the literal equations; before one that breaks a law
    of a contact.
    """

    DONE = 0
    LEFT = 1
    BROKEN = 2


class Told(Record):
    """What is told of all steps so far.

    Attributes
    ----------
    deepest, residual : float
        The largest depth (m) and residual.
    approach, bend : float
        By how much a step may enter a surface that it has not met before, the largest, and one along which it goes, of
        all steps together, m.
    lowered : float
        Of how many groups of contacts the restitution was lowered, in all.
    """

    deepest: float
    residual: float
    approach: float
    bend: float
    lowered: float


class Progress(Record):
    """How far steps have come.

    Attributes
    ----------
    most, steps, passed : int
        Steps that may be taken, steps in total, outputs passed.
    time, time_old, stop, length : float
        Time reached, start of the last step, end and length of steps, s.
    too_deep : float
        A depth that is round-off, m.
    """

    most: int
    steps: int
    passed: int
    time: float
    time_old: float
    stop: float
    length: float
    too_deep: float


class ImpactScene(NamedTuple):
    """A scene that is stepped over its impacts.

    Attributes
    ----------
    asking : Asking
        Its calls look at the state `at` of a march.
    looked : Looked
    closing : ClosingCall
    tables, flexible, loops : named tuples
    """

    asking: Asking
    looked: Looked
    closing: ClosingCall
    tables: Tables
    flexible: FlexibleTables
    loops: Loops


@in_place
class March(NamedTuple):
    """Steps through a run.

    Attributes
    ----------
    integers, reals : ndarray
        `Progress`.
    told : ndarray
        `Told`.
    old, new, tried : ndarray, shape (state,)
        States with quadratures at both ends of the last step, and at that of the one that is tried.
    step : Step
    at : ndarray, shape (state,)
        The state that the scene is asked about.
    bends, bent : ndarray
        Of bodies whose bending is watched: see `kanefe.kernels.evaluation.bending`.
    """

    integers: Integers
    reals: Reals
    told: Reals
    old: Reals
    new: Reals
    tried: Reals
    step: Step
    at: Reals
    bends: Integers
    bent: Reals
