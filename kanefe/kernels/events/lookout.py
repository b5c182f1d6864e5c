"""Values of events at times of the last step, or just behind it."""

from kanefe.kernels.events.closing_call import close_at
from kanefe.kernels.events.watched_run import Lookout, Passage, Question
from kanefe.kernels.language import RealRows, Reals, call_address, copy, entry, exact, inlined, kernel
from kanefe.kernels.loads.watching import NEAR
from kanefe.kernels.steppers.step_commands import Run, step_of
from kanefe.kernels.sweeps.drives import put_drives

AT_TIME = 0
"""Index of the time in a prepared call of `look_at`."""


@exact
def look_through(lookout: Lookout, run: Run, start: float, end: float) -> None:
    """Write the values at the places of the lookout between two times."""
    for i in range(len(lookout.times)):
        lookout.times[i] = start + (end - start) * lookout.shares[i]
    lookout.times[-1] = end
    _look(lookout, run)


@kernel
def value_at(of: Question, t: float) -> float:
    """Return the value of an event at a time of the last step, above a level: nothing is looked at but its load."""
    single, watched = of.passage.lookouts.single, of.passage.watched
    put_closed(of.passage, t)
    single.only[0] = watched.loads[of.event]
    look_at_states(single)
    single.only[0] = NEAR
    return single.found[0, watched.columns[of.event]] + of.above


@kernel
def put_closed(passage: Passage, t: float) -> bool:
    """Write the time and the state there in the lookout for one, its loops closed; return whether they are."""
    single, closing = passage.lookouts.single, passage.lookouts.closing
    single.times[0] = t
    put_state(passage.run, t, single.states[0])
    share = step_of(passage.run).share_stiffness
    return not closing.has_loops or close_at(closing, t, share, single.states[0])


@entry()
def look_at(lookout: Lookout, run: Run, t: float) -> None:
    """Write the values at a time of the last step; the lookout has one place."""
    lookout.times[0] = t
    _look(lookout, run)


@kernel
def _look(lookout: Lookout, run: Run) -> None:
    """Write the values at the times of the lookout."""
    for i in range(len(lookout.times)):
        put_state(run, lookout.times[i], lookout.states[i])
    look_at_states(lookout)


@kernel
def look_at_states(lookout: Lookout) -> None:
    """Write the values at the states and times of the lookout."""
    for i in range(len(lookout.times)):
        put_given(lookout, lookout.times[i], lookout.drives[i], lookout.states[i], lookout.inputs[i])
    call_address(lookout.looking.address, (lookout.looking.places, lookout.looking.numbers))


@kernel
def put_given(lookout: Lookout, t: float, drives: RealRows, y: Reals, inputs: Reals) -> None:
    """Write drives and values of loads at a time and a state."""
    put_drives(lookout.motions, t, drives)
    copy(lookout.held, inputs)
    lookout.fill(t, y, inputs)


@inlined
def put_state(run: Run, t: float, y: Reals) -> None:
    """Write the state at a time of the last step, or just behind it."""
    step = step_of(run)
    if step.stage != 0 and t != step.time:
        run.interpolate(run.integers, run.reals, run.vectors, run.table, t, y)
    else:
        copy(step.state, y)
