"""The figures of a deck's motion: what a call takes in compiled code, and how near it is to the sum of its waves."""

from __future__ import annotations

import ctypes

import numpy as np

from benchmarks.clocks import repeated
from benchmarks.goals import Figure, Goal, median
from benchmarks.work_precision.machine import Machine
from kanefe.environment import Sea, Ship, example_rao
from kanefe.kernels.compiler._numba import IS_COMPILED
from kanefe.kernels.compiler._numba_functions import compiled_of_time
from kanefe.kernels.compiler.addresses import addresses
from kanefe.kernels.links.deck_motion import deck_motion
from kanefe.kernels.links.places import SIGNATURE

CALL_GOAL = Goal("deck of a ship in 344 waves: one call, with rates and accelerations [us]", 0.3)
EXACT_GOAL = Goal("deck of a ship in 344 waves: largest distance from the sum of cosines [m, m/s, m/s2, rad]", 1e-12)

SPAN, RAMP = 1200.0, 30.0
CALLS, ROUNDS, COMPARED = 100_000, 5, 200


def deck_calls(machine: Machine) -> list[Figure]:
    """Time calls at increasing times, as a run makes them, and compare some with the sums."""
    if not IS_COMPILED:
        return [goal.skipped("nothing is compiled (KANEFE_JIT=0)") for goal in (CALL_GOAL, EXACT_GOAL)]
    sea = Sea.state(5, seed=1, spreading=2, duration=SPAN, frequency_range=(0.2, 2.0))
    deck = Ship(example_rao(), sea, 0.0, 60.0).at((-45.0, 0.0, 6.0), ramp=RAMP)
    numbers = deck.kernel().numbers
    place = np.uintp(numbers.ctypes.data)
    pointers = (ctypes.c_void_p,) * 3
    call = ctypes.CFUNCTYPE(None, *pointers)(addresses(deck_motion, deck_motion, SIGNATURE)[0])

    def march(step: float) -> float:
        q, out = np.zeros(1), np.zeros(24)
        for i in range(CALLS):
            q[0] = i * step
            call(place, q.ctypes.data, out.ctypes.data)
        return out[0]

    fast = compiled_of_time(march, "the loop over calls")
    step = SPAN / CALLS
    fast(step)
    times = [repeated(lambda: fast(step), 1) / CALLS for _ in range(ROUNDS)]
    worst, out = 0.0, np.zeros(24)
    for t in np.random.default_rng(0).uniform(0.0, SPAN, COMPARED):
        out[:] = 0.0
        q = np.array([t])
        call(numbers.ctypes.data, q.ctypes.data, out.ctypes.data)
        p, v, a, axes, w, dw = deck.at(float(t))
        wanted = np.concatenate((p, axes.ravel(), v, axes @ w, a, axes @ dw))
        worst = max(worst, float(abs(out - wanted).max()))
    told = f"{len(deck.pieces)} pieces of {deck.edges[1] - deck.edges[0]:g} s, {numbers.nbytes / 1e6:.1f} MB"
    return [CALL_GOAL.figure(1e6 * median(times), told), EXACT_GOAL.figure(worst, f"{COMPARED} times")]
