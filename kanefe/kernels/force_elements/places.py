"""What a load between frames is told of its ends, and what it writes: records in the lists that it is called with."""

from typing import Annotated, Any

from kanefe.kernels.compiler.addresses import NUMBER, NUMBERS, VALUES
from kanefe.kernels.language import Behind, Matrix, Record, Rows, Vector, column, inlined, numbers_from

SIGNATURE = (NUMBER, NUMBERS, NUMBERS, VALUES, VALUES, VALUES)
"""Kinds of the arguments of the function: t, numbers, inputs, ends, states, out."""

WATCH_SIGNATURE = (NUMBER, *[NUMBERS] * 5)
"""Kinds of the arguments of a function that writes what events of a load look at, for real numbers alone."""


class End(Record):
    """The motion of an end, in components of N; of a joint coordinate x of `p` and `v` alone."""

    p: Vector  # origin, m
    A: Matrix  # axes
    v: Vector  # velocity of the origin and angular velocity
    w: Vector


class Ends(Rows[End]):
    """The ends of a load, in a list."""


class Wrench(Record):
    """What a load exerts on an end, in components of N; on a joint coordinate x of the force alone."""

    force: Vector  # at the end's origin
    moment: Vector


class Wrenches(Rows[Wrench]):
    """The wrenches of a load on its ends, in a list."""


class Done(Record):
    """What a load writes."""

    potential: float  # J
    taken: float  # power that it dissipates, and that it supplies other than from its potential, W
    given: float
    wrenches: Annotated[Any, Behind()]  # `Wrenches`, and then the rates of its states


END_NUMBERS, WRENCH, WRENCHES = End.number_count, Wrench.number_count, Done.number_count
"""How many numbers an end and a wrench have, and how many are written before the wrenches."""

P, A, V = (column(End, name) for name in "pAv")


@inlined
def rates_of(done: Done, count: int) -> Any:
    """Return the list in which the rates of states of a load with so many ends are written."""
    return numbers_from(Wrenches(done.wrenches)[count])


@inlined
def done_size(ends: int, states: int) -> int:
    """Return how many numbers a load with so many ends and internal states writes."""
    return WRENCHES + WRENCH * ends + states
