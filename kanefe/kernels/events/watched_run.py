"""What kernels are given that go over the events of a run: the events, and calls that look at their values."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler.arrays import NOT_CALLED, Filler
from kanefe.kernels.events.closing_call import ClosingCall
from kanefe.kernels.impacts.contact_questions import Inquiry, inquiry_of
from kanefe.kernels.language import IntegerRows, Integers, Prepared, RealBlocks, RealRows, Reals
from kanefe.kernels.loads.telling import States
from kanefe.kernels.steppers.step_commands import Run
from kanefe.kernels.sweeps.drives import Drives

SHARES = np.arange(1, 5) / 4.0
"""Positions in a step at which functions are evaluated, relative to its length; the last one is its end."""

FIRST_SHARES = np.append(10.0 ** np.arange(-9, -1), SHARES)
"""Positions in a step after an event, relative to its length, for a function that starts at zero: they show its sign
however near its next zero is."""

IS_CUT = 1
"""Place in `WatchedRun.counts`, see there."""


class Does(IntEnum):
    """What an event does."""

    REPORTS = 0  # it is only reported
    ENDS_STEP = 1  # it also ends the step without a change
    CHANGES = 2  # it also changes states of its load
    ACTS = 3  # Python has to act
    BOUND = 4  # Python has to act as soon as the function is below zero, by whatever way
    BOUND_CHANGES = 5  # rigid contacts change as soon as it is


STORM, STORM_SHARE = 32, 1e-6
"""Number of actions within this fraction of the span from which they count as an infinite sequence."""


class Going(NamedTuple):
    """A call of `kanefe.kernels.steppers.integration.integrate`.

    Attributes
    ----------
    call : Prepared
    most_at, command_at : int
        Where in its places the count of steps is at which it returns, and in its numbers the command.
    """

    call: Prepared
    most_at: int
    command_at: int


class WatchedRun(NamedTuple):
    """The events of a run, and what is known of them at the last place looked at.

    Attributes
    ----------
    columns, directions, kinds : ndarray of int, shape (events,)
        Of each its column among the values looked at, the way through zero that counts (1, -1, or 0 for both), and
        what it `Does`.
    loads : ndarray of int, shape (events,)
        Of each the number of its load in the tables, or the number of loads where it is of none.
    known : ndarray, shape (events,)
        Above zero where the value is that of the function, and no estimate of a load that is nowhere near.
    values, noise, last : ndarray, shape (events,)
        Value, up to which size it has no sign, and time of the last event, s; minus infinity before the first.
    records : ndarray, shape (R, 2)
        Time and event of what happened.
    counts : ndarray of int, shape (2,)
        How many records there are; and IS_CUT: whether the events of the last step are still to be dealt with, because
        there was no room for all its outputs.
    before : ndarray, shape (R, state)
        The state before each event of the records; (0, state) where nobody wants it.
    times, samples : ndarray, shape (T,)
        Of one function in a step, from its start on.
    brackets : ndarray, shape (2 T, 2)
    found : ndarray, shape (F, 2)
        Roots of a step, in order of time: time and event.
    changes : ndarray of int, shape (events, 4)
        Of those that change states what `Lookout.change` is given; of rigid contacts first what they are asked for, see
        `kanefe.kernels.impacts.contact_changes`.
    actions : ndarray, shape (STORM,)
        Times of the last actions, s; minus infinity where there were fewer.
    regime : ndarray, shape (3,)
        What the run went on from at its last restart: the event, below zero for another reason; the time, s; and how
        many steps had been taken.
    usual : ndarray, shape (events,)
        Mean step from each event to the next restart, when it last happened, s; zero before.
    first_quadrature : int
        Where in a state the energy taken and, after it, that given are (J).
    after : ndarray, shape (state,)
        After changes.
    span : float
        Of the run, s.
    stop, rtol, length : float
        Its end (s) and tolerance, and a length of the scene (m).
    """

    columns: Integers
    directions: Integers
    kinds: Integers
    loads: Integers
    known: Reals
    values: Reals
    noise: Reals
    last: Reals
    records: RealRows
    counts: Integers
    before: RealRows
    times: Reals
    samples: Reals
    brackets: RealRows
    found: RealRows
    changes: IntegerRows
    actions: Reals
    regime: Reals
    usual: Reals
    first_quadrature: int
    after: Reals
    span: float
    stop: float
    rtol: float
    length: float


class ContactCalls(NamedTuple):
    """What changes rigid contacts at events.

    Attributes
    ----------
    changing : Prepared
        Call of `kanefe.kernels.impacts.contact_changes.change_contacts` with the inquiry and the first state of the
        lookout; address 0: there are none.
    inquiry : Inquiry
    balancing : Prepared
        Call of `kanefe.kernels.evaluation.momenta.balances_of_states` with what follows, of two states.
    states : States
    balances : ndarray
        `kanefe.kernels.evaluation.momenta.Balances`.
    """

    changing: Prepared
    inquiry: Inquiry
    balancing: Prepared
    states: States
    balances: RealRows


NO_CONTACTS = ContactCalls(
    changing=NOT_CALLED,
    inquiry=inquiry_of(0),
    balancing=NOT_CALLED,
    states=States(np.zeros(0), np.zeros((0, 0, 3)), np.zeros((0, 0)), np.zeros((0, 0))),
    balances=np.zeros((0, 0)),
)
"""Calls of a scene without rigid contacts: none."""


class Lookout(NamedTuple):
    """What a run needs that looks out for events.

    Attributes
    ----------
    looking : Prepared
        Call of `kanefe.kernels.loads.watching.watch_states` with the arrays below.
    shares : ndarray, shape (T,)
        Places in a step at which values are looked at, the last one its end, 1.
    motions : Drives
    fill : function (t, y, inputs)
    held : ndarray, shape (inputs,)
        Values of loads, those written that do not change in the run.
    times : ndarray, shape (T,)
    drives : ndarray, shape (T, driven, 3)
    inputs : ndarray, shape (T, inputs)
    states : ndarray, shape (T, state)
    found : ndarray, shape (T, values)
    change : ndarray of int, shape (4,)
        Of a load whose states the call changes instead of looking: its number in the tables, that of its event, and
        first and number of its states; below zero: it looks.
    only : ndarray of int, shape (1,)
        What the call looks at.
    near : ndarray, shape (loads,)
        Above zero for loads whose values are no estimates.
    contacts : ContactCalls
    """

    looking: Prepared
    shares: Reals
    motions: Drives
    fill: Filler
    held: Reals
    times: Reals
    drives: RealBlocks
    inputs: RealRows
    states: RealRows
    found: RealRows
    change: Integers
    only: Integers
    near: Reals
    contacts: ContactCalls


class Lookouts(NamedTuple):
    """The lookouts of a run.

    Attributes
    ----------
    quiet, fresh, single : Lookout
        With SHARES, FIRST_SHARES, and one place.
    closing : ClosingCall
        What closes the loops of states at which values are looked for one by one.
    """

    quiet: Lookout
    fresh: Lookout
    single: Lookout
    closing: ClosingCall


class Passage(NamedTuple):
    """A run that passes over events.

    Attributes
    ----------
    lookouts : Lookouts
    watched : WatchedRun
    run : Run
    restart_share : float
        Of the step before, with which the method begins after an event that has not happened before; with 0 it finds a
        first step itself, whenever states may have changed.
    """

    lookouts: Lookouts
    watched: WatchedRun
    run: Run
    restart_share: float


class Question(NamedTuple):
    """What `kanefe.kernels.events.event_search` asks for the value of: an event, above a level."""

    passage: Passage
    event: int
    above: float
