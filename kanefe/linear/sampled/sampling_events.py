"""Events within a common period of sampled controllers, as matrices over the states of the loop."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import gcd, lcm
from typing import NamedTuple

import numpy as np
import scipy.linalg

from kanefe.errors import ModelError
from kanefe.frames import Matrix
from kanefe.linear.sampled.sampled_laws import LinearLaw

COMMON = 1e-9
"""Relative tolerance within which the ratio of two sampling intervals is rational."""

MOST_SAMPLES = 10_000
"""Largest number of samples in one common period."""

LARGEST = 1000
"""Largest integer of such a ratio."""


class Places(NamedTuple):
    """Places of the states of a controller among those of the loop.

    Attributes
    ----------
    memory, acting : slice
        Its memory, and its drives as they act.
    late : tuple of slice
        Its drives that do not act yet, by the number of the sample modulo their count.
    """

    memory: slice
    acting: slice
    late: tuple[slice, ...]


class SamplingTime(NamedTuple):
    """A time (s) at which controllers sample or drives begin to act, by number of the controller and of the sample."""

    time: float
    samples: tuple[tuple[int, int], ...]
    acts: tuple[tuple[int, int], ...]


def common_period(laws: Sequence[LinearLaw]) -> tuple[float, list[int]]:
    """Return the common period (s) of all controllers, and the number of samples of each in it.

    Raises
    ------
    ModelError
        If there is no such period with at most 10,000 samples.
    """
    first = laws[0].controller
    ratios = []
    for law in laws:
        ratio = law.controller.every / first.every
        exact = Fraction(ratio).limit_denominator(LARGEST)
        if exact == 0 or abs(float(exact) - ratio) > COMMON * ratio:
            raise ModelError(
                f"the samples of controllers {first.name!r} (every {first.every:g} s) and {law.controller.name!r} "
                f"(every {law.controller.every:g} s) have no common multiple, and their loop no "
                f"poles. Remedy: times whose ratio is that of whole numbers up to {LARGEST}"
            )
        ratios.append(exact)
    # the least multiple of fractions in lowest terms
    common = Fraction(lcm(*(ratio.numerator for ratio in ratios)), gcd(*(ratio.denominator for ratio in ratios)))
    counts = [int(common / ratio) for ratio in ratios]
    if sum(counts) > MOST_SAMPLES:
        slowest = max(laws, key=lambda law: law.controller.every).controller
        raise ModelError(
            f"the samples of the controllers come together only after {sum(counts)} of them, {MOST_SAMPLES} at most. "
            f"Remedy: a time of {slowest.name!r} (every {slowest.every:g} s) that is a multiple of the others"
        )
    return float(common) * first.every, counts


def late_samples(law: LinearLaw) -> int:
    """Return the number of samples whose drives do not act yet at the next sample."""
    return int(np.ceil(law.controller.delay / law.controller.every - COMMON))


def places_of(laws: Sequence[LinearLaw], start: int) -> tuple[list[Places], int]:
    """Return the places of the states of each controller, from `start` on, and the total number of states."""
    found, at = [], start

    def taken(count: int) -> slice:
        nonlocal at
        at += count
        return slice(at - count, at)

    for law in laws:
        late = late_samples(law)
        count = law.controller.drive_count
        found.append(Places(taken(len(law.names)), taken(count), tuple(taken(count) for _ in range(late))))
    return found, at


def instants_of(laws: Sequence[LinearLaw], period: float, counts: Sequence[int]) -> list[SamplingTime]:
    """Return the sampling times of one period, in order."""
    events: list[tuple[float, bool, int, int]] = []
    for i, (law, count) in enumerate(zip(laws, counts, strict=True)):
        every, delay = law.controller.every, law.controller.delay
        events += [(k * every, True, i, k) for k in range(count)]
        if delay > 0.0:
            late = ((k * every + delay, k) for k in range(-late_samples(law), count))
            events += [(max(t, 0.0), False, i, k) for t, k in late if -COMMON * every < t < period - COMMON * every]
    events.sort(key=lambda event: event[0])
    smallest = min(law.controller.every for law in laws)
    found: list[list[tuple[float, bool, int, int]]] = []
    for event in events:
        if found and event[0] - found[-1][0][0] <= COMMON * smallest:
            found[-1].append(event)
        else:
            found.append([event])
    return [
        SamplingTime(
            together[0][0],
            tuple((i, k) for _, is_sample, i, k in together if is_sample),
            tuple((i, k) for _, is_sample, i, k in together if not is_sample),
        )
        for together in found
    ]


def change_at(
    instant: SamplingTime, laws: Sequence[LinearLaw], places: Sequence[Places], reads: Sequence[Matrix], size: int
) -> Matrix:
    """Return the change of the states of the loop at an instant, (states, states and inputs).

    Samples read the states before the instant, including the previous drives; `reads` are the derivatives of the
    readings of each controller by all states and inputs.
    """
    change = np.eye(size, reads[0].shape[1])
    for i, k in instant.acts:
        at = places[i]
        change[at.acting] = 0.0
        change[at.acting, at.late[k % len(at.late)]] = np.eye(laws[i].controller.drive_count)
    for i, k in instant.samples:
        law, at = laws[i], places[i]
        given = law.K @ reads[i]
        given[:, at.memory] += law.L
        goal = at.late[k % len(at.late)] if at.late else at.acting
        change[at.memory] = law.N @ reads[i]
        change[at.memory, at.memory] += law.P
        change[goal] = given
    return change


def turned(laws: Sequence[LinearLaw], places: Sequence[Places], counts: Sequence[int], size: int) -> Matrix:
    """Return the renumbering after a period: drives that do not act yet belong to samples of the next period."""
    change = np.eye(size)
    for at, count in zip(places, counts, strict=True):
        for k in range(len(at.late)):
            change[at.late[(k - count) % len(at.late)]] = 0.0
        for k in range(len(at.late)):
            change[at.late[(k - count) % len(at.late)], at.late[k]] = np.eye(at.late[k].stop - at.late[k].start)
    return change


def flows(generator: Matrix, digits: float) -> Callable[[float], Matrix]:
    """Return ``expm(generator t)`` as a function of the time t (s), cached for times that agree within `digits` (s)."""
    known: dict[int, Matrix] = {}

    def flow(t: float) -> Matrix:
        key = round(t / digits)
        if key not in known:
            known[key] = scipy.linalg.expm(generator * t)
        return known[key]

    return flow
