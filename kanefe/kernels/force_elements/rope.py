"""Ropes: one tension along a path over points, never compression (Eq. 11)."""

from __future__ import annotations

from collections import namedtuple
from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import dot, minus, three, times
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.force_elements.blocks import places
from kanefe.kernels.force_elements.places import (
    END_NUMBERS,
    GIVEN,
    POTENTIAL,
    SIGNATURE,
    TAKEN,
    WATCH_SIGNATURE,
    WRENCH,
    WRENCHES,
    P,
    V,
)
from kanefe.kernels.links.polynomials import POWERS, piece_at, polynomial

RopeNumbers = namedtuple(
    "RopeNumbers", "ends stiffness damping breaking_load winds looks_for_slack inputs first last pieces table parts"
)
"""Numbers of a rope: of its ends, EA in N and C in N s, and N, 0 of one that does not break; and whether it looks for
events at which it becomes slack or taut, which come before that at which it breaks. Its unstretched length (m) and the
rate of that come as inputs, or in pieces: `table` has their starts, then the powers 0 to 5 of the time since (s). It
has none before `first` and after `last`. The lengths of the parts of its way at the start (m) follow."""

AT = places(RopeNumbers)

WOUND_UP = 1e-3
"""Length of a part of a way, relative to its length at the start, at which a rope or cable counts as wound up to its
sheave: a part that goes on to nothing has no direction there, and turns ever faster."""


@called_by_address(*SIGNATURE)
def rope(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write the pull on all points; see `RopeNumbers`."""
    count = int(numbers[AT.ends])
    length, rate = put_gradient(count, ends, out)
    l0, payout = unstretched(t, numbers, inputs)
    elastic, tension = tensions(numbers, l0, payout, length, rate, states)
    strain_energy = 0.5 * elastic * elastic / numbers[AT.stiffness]  # of a metre without tension
    out[POTENTIAL] = strain_energy * l0
    out[TAKEN] = (tension - elastic) * (rate - length / l0 * payout)
    # what the drum does on the rope that comes to it, less the strain energy that stays on it
    out[GIVEN] = (strain_energy - tension * length / l0) * payout
    pull(count, tension, out)


@called_by_address(*WATCH_SIGNATURE)
def rope_watch(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write how far it is from wound up, twice how much longer its way is than it, how far it is from its break."""
    length, rate = way_over(int(numbers[AT.ends]), ends)
    l0, payout = unstretched(t, numbers, inputs)
    breaking = numbers[AT.breaking_load]
    is_broken = breaking > 0.0 and states[0] <= 0.0
    stretch = -l0 if is_broken else length - l0
    margin = breaking - tensions(numbers, l0, payout, length, rate, states)[1]
    parts = AT.table + (1 + POWERS) * int(numbers[AT.pieces])
    count, looks = int(numbers[AT.ends]), (numbers[AT.winds], numbers[AT.looks_for_slack])
    put_margins(numbers, parts, count, ends, looks, stretch, breaking, margin, out)


@inlined
def put_margins(
    numbers: Any,
    parts: int,
    count: int,
    ends: Any,
    looks: tuple[float, float],
    stretch: float,
    breaking_load: float,
    margin: float,
    out: Any,
) -> None:
    """Write the values of the events of a line: of its being wound up, of slack and taut, and of its breaking.

    `looks` tells whether it can be wound up, and whether slack is looked for; `parts` is where the lengths of the parts
    of its way at the start are. What is slack does no harm at a sheave.
    """
    winds, looks_for_slack = looks
    at = 0
    if winds > 0.0:
        out[0], at = 1.0, 1
        if stretch > 0.0:
            for i in range(count - 1):
                out[0] = min(out[0], leg(i, ends)[0] - WOUND_UP * numbers[parts + i])
    if looks_for_slack > 0.0:
        out[at] = out[at + 1] = stretch
        at += 2
    if breaking_load > 0.0:
        out[at] = margin


@called_by_address(*WATCH_SIGNATURE)
def rope_change(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write that it is gone, and its strain energy with it."""
    l0, _ = unstretched(t, numbers, inputs)
    stretch = max(way_over(int(numbers[AT.ends]), ends)[0] - l0, 0.0)
    out[0], out[1] = -0.5 * numbers[AT.stiffness] / l0 * stretch * stretch, 0.0


@inlined
def unstretched(t: float, numbers: Any, inputs: Any) -> tuple[float, float]:
    """Return the length without tension and how fast it is paid out; no numbers where it is unknown or not above 0."""
    if numbers[AT.inputs] > 0.0:
        l0, payout = inputs[0], inputs[1]
    else:
        count = int(numbers[AT.pieces])
        piece = piece_at(numbers, AT.table, count, t)
        at, since = AT.table + count + POWERS * piece, t - numbers[AT.table + piece]
        l0, payout, _, _ = polynomial(numbers, at, since)
    if not (l0 > 0.0 and numbers[AT.first] <= t <= numbers[AT.last]):
        l0 = payout = np.nan
    return l0, payout


@inlined
def tensions(numbers: Any, l0: float, payout: float, length: Any, rate: Any, states: Any) -> tuple[Any, Any]:
    """Return what the stretch pulls with, and with damping; nothing where the rope is slack or broken."""
    strain = (length - l0) / l0
    elastic = numbers[AT.stiffness] * strain
    if strain.real <= 0.0 or (numbers[AT.breaking_load] > 0.0 and states[0].real <= 0.0):
        elastic = 0.0 * elastic
        return elastic, elastic
    tension = elastic + numbers[AT.damping] * (rate - length / l0 * payout) / l0
    if tension.real < 0.0:
        tension = 0.0 * tension
    return elastic, tension


@inlined
def way_over(count: int, ends: Any) -> tuple[Any, Any]:
    """Return the length of a way over points, and its rate."""
    way = rate = 0.0 * ends[0]
    for i in range(count - 1):
        length, _, growth = leg(i, ends)
        way += length
        rate += growth
    return way, rate


@inlined
def leg(i: int, ends: Any) -> Any:
    """Return the length of a part of a way from point to point, its direction, and how fast it grows."""
    a, b = END_NUMBERS * i, END_NUMBERS * (i + 1)
    line = minus(three(ends, b + P), three(ends, a + P))
    length = np.sqrt(dot(line, line))
    e = times(1.0 / length, line)
    return length, e, dot(e, minus(three(ends, b + V), three(ends, a + V)))


@inlined
def put_gradient(count: int, ends: Any, out: Any) -> tuple[Any, Any]:
    """Write the gradient of a way over points where the forces will stand; return its length and rate."""
    way = rate = 0.0 * ends[0]
    for i in range(count - 1):
        length, e, growth = leg(i, ends)
        way += length
        rate += growth
        for c in range(3):
            out[WRENCHES + WRENCH * i + c] -= e[c]
            out[WRENCHES + WRENCH * (i + 1) + c] += e[c]
    return way, rate


@inlined
def pull(count: int, tension: Any, out: Any) -> None:
    """Make forces of the gradient."""
    for i in range(count):
        for c in range(3):
            out[WRENCHES + WRENCH * i + c] *= -tension
