"""Memory of steps over the impacts of rigid contacts: what they are asked for, and what they have told."""

from __future__ import annotations

from typing import NamedTuple

from kanefe.kernels.compiler.arrays import Integers, RealRows, Reals
from kanefe.kernels.constraints.contact_margins import Looked
from kanefe.kernels.events.closing_call import ClosingCall
from kanefe.kernels.impacts.decision import Asking
from kanefe.kernels.tables import FlexibleTables, Loops, Tables

BEYOND = 1e-6
"""Violation relative to the friction limit, to the largest normal force and to the scene's length above which the run
is in error."""

DOUBLY = 2.0
"""Penetration, in multiples of the first-order error of steps over impacts, above which it is an error."""

ROUND_OFF = 1e-9
"""Tolerance, relative to a step, by which the last step may be longer."""

DONE, LEFT, BROKEN = range(3)
"""How steps end: at the last output or the most steps; before one that is left to the literal equations; before one
that breaks a law of a contact."""

MOST, STEPS, PASSED, CLOSED = range(4)
"""Integers: steps that may be taken, steps in total, outputs passed, contact points that were closed in the last step.
"""
INTEGERS = 4

TIME, TIME_OLD, STOP, LENGTH, TOO_DEEP, OWN_DEPTH, OWN_RESIDUAL, OWN_APPROACH, OWN_BEND, OWN_LOWERED = range(10)
"""Reals: time reached, start of the last step, end and length of steps (s); a depth that is round-off (m); and of the
step that was tried last what is told of steps."""
REALS = 10

DEEPEST, RESIDUAL, APPROACH, BEND, LOWERED = range(5)
"""Told of all steps so far: the largest depth (m) and residual; by how much a step may enter a surface that it has
not met before, the largest, and one along which it goes, of all steps together (m); and in all together, of how many
groups of contacts the restitution was lowered."""
TOLD = 5

OLD, NEW, NEXT = range(3)
"""Rows of the ends of steps: of the last one, and of the one that is tried."""

BEFORE_STEP, REMAINDER, FREELY, AFTER_STEP, IMPULSE = range(5)
"""Rows of the vectors of closed points: rates at the middle of a step with its first speeds, m/s, and what is left of
their rates without accelerations, m/s2; what they become without impulses, and with them, m/s; impulses, N s."""
VECTORS = 5


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


class March(NamedTuple):
    """Steps through a run.

    Attributes
    ----------
    integers, reals, told : ndarray, shapes (INTEGERS,), (REALS,), (TOLD,)
    ends : ndarray, shape (3, state)
        States with quadratures.
    vectors : ndarray, shape (VECTORS, 3 points)
    at : ndarray, shape (state,)
        The state that the scene is asked about.
    bends, bent : ndarray
        Of bodies whose bending is watched: see `kanefe.kernels.evaluation.bending`.
    """

    integers: Integers
    reals: Reals
    told: Reals
    ends: RealRows
    vectors: RealRows
    at: Reals
    bends: Integers
    bent: Reals
