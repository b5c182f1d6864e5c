"""Ropes: one tension along a path over points, never compression (Eq. 11)."""

from typing import Annotated, Any

import numpy as np

from kanefe.kernels.force_elements.places import SIGNATURE, WATCH_SIGNATURE, Done, Wrenches
from kanefe.kernels.force_elements.spring import line_between
from kanefe.kernels.language import Behind, Record, called_by_address, inlined
from kanefe.kernels.links.polynomials import POWERS, piece_at, polynomial


class Cable(Record):
    """What the events of a line look at.

    How many ends it has; the load at which it breaks, N, 0: it does not; whether it can be wound up, and whether it is
    asked for when it becomes slack or taut.
    """

    ends: float
    breaking_load: float
    winds: float
    looks_for_slack: float


class RopeNumbers(Record):
    """Numbers of a rope: EA in N and C in N s.

    Its unstretched length (m) and the rate of that come as inputs, or in pieces: `table` has their starts, then the
    powers 0 to 5 of the time since (s). It has none before `first` and after `last`. The lengths of the parts of its
    way at the start (m) follow.
    """

    cable: Cable
    stiffness: float
    damping: float
    inputs: float
    first: float
    last: float
    pieces: float
    table: Annotated[Any, Behind()]


WOUND_UP = 1e-3
"""Length of a part of a way, relative to its length at the start, at which a rope or cable counts as wound up to its
sheave: a part that goes on to nothing has no direction there, and turns ever faster."""


@called_by_address(*SIGNATURE)
def rope(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the pull on all points; see `RopeNumbers`."""
    own, done = RopeNumbers(numbers), Done(out)
    count = int(own.cable.ends)
    length, rate = put_gradient(count, ends, done)
    l0, payout = unstretched(t, own, inputs)
    elastic, tension = tensions(own, (l0, payout), length, rate, states)
    strain_energy = 0.5 * elastic * elastic / own.stiffness  # of a metre without tension
    done.potential = strain_energy * l0
    done.taken = (tension - elastic) * (rate - length / l0 * payout)
    # what the drum does on the rope that comes to it, less the strain energy that stays on it
    done.given = (strain_energy - tension * length / l0) * payout
    pull(count, tension, done)


@called_by_address(*WATCH_SIGNATURE)
def rope_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write how far it is from wound up, twice how much longer its way is than it, how far it is from its break."""
    own = RopeNumbers(numbers)
    length, rate = way_over(int(own.cable.ends), ends)
    paid = unstretched(t, own, inputs)
    breaking = own.cable.breaking_load
    stretch = -paid[0] if breaking > 0.0 and states[0] <= 0.0 else length - paid[0]
    margin = breaking - tensions(own, paid, length, rate, states)[1]
    parts = (1 + POWERS) * int(own.pieces)
    put_margins(own.cable, own.table, parts, ends, (stretch, margin), out)


@inlined
def put_margins(cable: Cable, table: Any, parts: int, ends: Any, margins: tuple[float, float], out: Any) -> None:
    """Write the values of the events of a line: of its being wound up, of slack and taut, and of its breaking.

    `margins` are how much longer its way is than it and how far it is from its break; `parts` is where the lengths of
    the parts of its way at the start are in a table. What is slack does no harm at a sheave.
    """
    stretch, at = margins[0], 0
    if cable.winds > 0.0:
        out[0], at = 1.0, 1
        if stretch > 0.0:
            for i in range(int(cable.ends) - 1):
                out[0] = min(out[0], line_between(ends, i)[0] - WOUND_UP * table[parts + i])
    if cable.looks_for_slack > 0.0:
        out[at] = out[at + 1] = stretch
        at += 2
    if cable.breaking_load > 0.0:
        out[at] = margins[1]


@called_by_address(*WATCH_SIGNATURE)
def rope_change(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write that it is gone, and its strain energy with it."""
    own = RopeNumbers(numbers)
    l0, _ = unstretched(t, own, inputs)
    stretch = max(way_over(int(own.cable.ends), ends)[0] - l0, 0.0)
    out[0], out[1] = -0.5 * own.stiffness / l0 * stretch * stretch, 0.0


@inlined
def unstretched(t: float, own: RopeNumbers, inputs: Any) -> tuple[float, float]:
    """Return the length without tension and how fast it is paid out; no numbers where it is unknown or not above 0."""
    if own.inputs > 0.0:
        l0, payout = inputs[0], inputs[1]
    else:
        count, table = int(own.pieces), own.table
        piece = piece_at(table, 0, count, t)
        l0, payout, _, _ = polynomial(table, count + POWERS * piece, t - table[piece])
    if not (l0 > 0.0 and own.first <= t <= own.last):
        l0 = payout = np.nan
    return l0, payout


@inlined
def tensions(own: RopeNumbers, paid: tuple[float, float], length: Any, rate: Any, states: Any) -> tuple[Any, Any]:
    """Return what the stretch pulls with, and with damping; nothing where the rope is slack or broken.

    `paid` is its length without tension and the rate of that.
    """
    l0, payout = paid
    strain = (length - l0) / l0
    elastic = own.stiffness * strain
    if strain.real <= 0.0 or (own.cable.breaking_load > 0.0 and states[0].real <= 0.0):
        return 0.0 * elastic, 0.0 * elastic
    tension = elastic + own.damping * (rate - length / l0 * payout) / l0
    return elastic, tension if tension.real >= 0.0 else 0.0 * tension


@inlined
def way_over(count: int, ends: Any) -> tuple[Any, Any]:
    """Return the length of a way over points, and its rate."""
    way = rate = 0.0 * ends[0]
    for i in range(count - 1):
        length, growth, _ = line_between(ends, i)
        way += length
        rate += growth
    return way, rate


@inlined
def put_gradient(count: int, ends: Any, done: Done) -> tuple[Any, Any]:
    """Write the gradient of a way over points where the forces will stand; return its length and rate."""
    way = rate = 0.0 * ends[0]
    on = Wrenches(done.wrenches)
    for i in range(count - 1):
        length, growth, e = line_between(ends, i)
        way += length
        rate += growth
        on[i].force -= e
        on[i + 1].force += e
    return way, rate


@inlined
def pull(count: int, tension: Any, done: Done) -> None:
    """Make forces of the gradient."""
    for i in range(count):
        on = Wrenches(done.wrenches)[i]
        on.force = -tension * on.force
