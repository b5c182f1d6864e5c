"""Loops closed at a time of a run, by a prepared call."""

from typing import NamedTuple

from kanefe.kernels.constraints.closing import ENDED, ENDED_AS, SHARE_IN_METRIC
from kanefe.kernels.language import Prepared, RealRows, Reals, call_address, copy, kernel
from kanefe.kernels.sweeps.drives import Drives, put_drives


class ClosingCall(NamedTuple):
    """What closes the loops of a state.

    Attributes
    ----------
    has_loops : bool
    call : Prepared
        Of `kanefe.kernels.constraints.closing.close_state`, with the arrays below, where there are loops.
    motions : Drives
    drives : ndarray, shape (driven, 3)
        Written by `motions` at each time.
    closed : ndarray, shape (state,)
        The state that is closed.
    """

    has_loops: bool
    call: Prepared
    motions: Drives
    drives: RealRows
    closed: Reals


@kernel
def close_at(closing: ClosingCall, t: float, share_stiffness: float, y: Reals) -> bool:
    """Close the loops of a state at a time; return whether that was possible."""
    put_drives(closing.motions, t, closing.drives)
    copy(y, closing.closed)
    closing.call.numbers[SHARE_IN_METRIC] = share_stiffness
    call_address(closing.call.address, (closing.call.places, closing.call.numbers))
    if closing.call.numbers[ENDED_AS] != ENDED.closed:
        return False
    copy(closing.closed, y)
    return True
