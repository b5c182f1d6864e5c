"""Values of events at times of the last step, or just behind it."""

from __future__ import annotations

from typing import Any

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import exact, inlined, kernel
from kanefe.kernels.compiler.arrays import RealRows, Reals
from kanefe.kernels.compiler.calls import call_address
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.events.closing_call import ClosingCall, close_at
from kanefe.kernels.events.watched_run import Lookout
from kanefe.kernels.loads.watching import NEAR
from kanefe.kernels.steppers.step_commands import SHARE_STIFFNESS, STAGE, STATE, TIME, TIME_OLD, Run
from kanefe.kernels.sweeps.drives import put_drives

Single = tuple[Lookout, ClosingCall]
"""A lookout with one place, and what closes the loops of the state there."""

AT_TIME = 0
"""Index of the time in a prepared call of `look_at`."""


@exact
def look_through(lookout: Lookout, run: Run, vectors: RealRows) -> None:
    """Write the values at the places of the lookout in the last step."""
    start, h = run.reals[TIME_OLD], run.reals[TIME] - run.reals[TIME_OLD]
    for i in range(len(lookout.shares)):
        lookout.times[i] = start + h * lookout.shares[i]
    lookout.times[-1] = run.reals[TIME]
    look(lookout, run, vectors)


@inlined
def look_ahead(lookout: Lookout, run: Run, vectors: RealRows, end: float) -> None:
    """Write the values between the end of the last step and a time."""
    start = run.reals[TIME]
    for i in range(len(lookout.times)):
        lookout.times[i] = start + (end - start) * lookout.shares[i]
    look(lookout, run, vectors)


@kernel
def value_at(data: Any, t: float) -> float:
    """Return the value of an event at a time of the last step, above a level: nothing is looked at but its load."""
    single, watched, run, vectors, event, above = data
    lookout, _ = single
    lookout.times[0] = t
    put_closed(single, run, vectors, t)
    lookout.only[0] = watched.loads[event]
    look_at_states(lookout)
    lookout.only[0] = NEAR
    return lookout.found[0, watched.columns[event]] + above


@kernel
def put_closed(single: Single, run: Run, vectors: RealRows, t: float) -> bool:
    """Write the state at a time of the last step, its loops closed; return whether they are."""
    lookout, closing = single
    put_state(run, vectors, t, lookout.states[0])
    return not closing.has_loops or close_at(closing, t, run.reals[SHARE_STIFFNESS], lookout.states[0])


@entry()
def look_at(lookout: Lookout, run: Run, vectors: RealRows, t: float) -> None:
    """Write the values at a time of the last step; the lookout has one place."""
    lookout.times[0] = t
    look(lookout, run, vectors)


@kernel
def look(lookout: Lookout, run: Run, vectors: RealRows) -> None:
    """Write the values at the times of the lookout."""
    for i in range(len(lookout.times)):
        put_state(run, vectors, lookout.times[i], lookout.states[i])
    look_at_states(lookout)


@kernel
def look_at_states(lookout: Lookout) -> None:
    """Write the values at the states and times of the lookout."""
    for i in range(len(lookout.times)):
        t, y = lookout.times[i], lookout.states[i]
        put_drives(lookout.motions, t, lookout.drives[i])
        copy(lookout.held, lookout.inputs[i])
        lookout.fill(t, y, lookout.inputs[i])
    call_address(lookout.looking.address, (lookout.looking.places, lookout.looking.numbers))


@inlined
def put_state(run: Run, vectors: RealRows, t: float, y: Reals) -> None:
    """Write the state at a time of the last step, or just behind it."""
    if run.integers[STAGE] != 0 and t != run.reals[TIME]:
        run.interpolate(run.integers, run.reals, vectors, run.table, t, y)
    else:
        copy(vectors[STATE], y)
