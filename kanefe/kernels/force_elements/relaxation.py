"""Arms of viscoelastic bodies along their modal coordinates: see `kanefe.bodies.relaxation.Relaxation` (Eq. 11)."""

from typing import Annotated, Any, NamedTuple

from kanefe.kernels.force_elements.places import SIGNATURE, WATCH_SIGNATURE, Done, Ends, Wrenches, rates_of
from kanefe.kernels.language import Behind, Record, called_by_address, inlined, numbers_from


class RelaxationNumbers(Record):
    """Numbers of the arms of a body."""

    coordinates: float  # how many they are
    arms: float
    is_relaxed: float  # 1: all arms follow, and pull with nothing
    each: Annotated[Any, Behind()]  # of one arm after the other: `Arm`, and its column of L between these, sqrt(J)


class Arm(NamedTuple):
    """Where among the numbers of all arms the column of one is, and what it pulls on."""

    column: int
    first: int  # the coordinates on which it pulls
    last: int
    rate: Any  # 1 / tau, 1/s


@called_by_address(*SIGNATURE)
def relaxation(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write what the arms pull with along the coordinates, and the rates of their states."""
    own, done, at = RelaxationNumbers(numbers), Done(out), 0
    on, rates = Wrenches(done.wrenches), rates_of(done, int(own.coordinates))
    if own.is_relaxed > 0.0:
        return
    for j in range(int(own.arms)):
        arm = arm_at(own, at)
        stretch = stretch_of(own, arm, ends, states[j])
        rates[j] = arm.rate * stretch
        done.potential += 0.5 * stretch * stretch
        done.taken += arm.rate * stretch * stretch
        for i in range(arm.first, arm.last):
            force = numbers_from(on[i])
            force[0] -= own.each[arm.column + i - arm.first] * stretch
        at = arm.column + arm.last - arm.first


@called_by_address(*WATCH_SIGNATURE)
def relaxation_told(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the energy that the arms store, and the power that they dissipate."""
    own, at = RelaxationNumbers(numbers), 0
    out[0] = out[1] = 0.0
    if own.is_relaxed > 0.0:
        return
    for j in range(int(own.arms)):
        arm = arm_at(own, at)
        stretch = stretch_of(own, arm, ends, states[j])
        out[0] += 0.5 * stretch * stretch
        out[1] += arm.rate * stretch * stretch
        at = arm.column + arm.last - arm.first


@inlined
def arm_at(own: RelaxationNumbers, at: int) -> Arm:
    """Return the arm whose numbers begin there."""
    return Arm(at + 3, int(own.each[at]), int(own.each[at + 1]), own.each[at + 2])


@inlined
def stretch_of(own: RelaxationNumbers, arm: Arm, ends: Any, state: Any) -> Any:
    """Return the stretch of the spring of an arm, L^T eta - z."""
    moved, stretch = Ends(ends), -state
    for i in range(arm.first, arm.last):
        stretch += own.each[arm.column + i - arm.first] * moved[i].p.x
    return stretch
