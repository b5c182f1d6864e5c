r"""What pairs of evaluations say of an error: the same question at two levels of one source.

With e the error of the coarser level, and ``r^n e`` that of the finer one, n levels on, the two are d apart,

    d = (1 - r^n) e,    r^n e = d r^n / (1 - r^n)

One pair does not show r; then it is taken as `ASSUMED`, of which the coarse level's error is at most ``1.5 d``: what
pairs were seen to miss. Two pairs in a row, three levels, show it. The bound is the sum over sources of what is left at
their levels, times `SAFETY`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

SAFETY = 1.5
"""Factor on what pairs say: on 16 numbers of cantilevers they stated 0.69 to 1.24 of the true error."""

ASSUMED = 1.0 / 3.0
"""Ratio of the errors of two levels, where two levels are all that is known."""

LEAST = 0.1
"""Smallest ratio of the errors of two levels that is believed: a difference may be small by chance."""

NOT_FALLING = 0.75
"""Ratio of the errors of two levels above which differences do not show that they fall."""


MISSED = 1.0
"""Part of what the largest value changes with every fourth output alone, of four such choices the one that changes it
most, that it is taken to miss between outputs. Of one peak ``c t^2`` below its top, d steps from the nearest output,
``c d^2`` is missed, an eighth of that change at most; several peaks of like height hide part of the change."""


class Pair(NamedTuple):
    """Two evaluations at two levels of a source.

    Attributes
    ----------
    level : int
        The finer one.
    jump : int
        How many levels it is above the coarser one, as far as these are apart: see `Search`.
    apart : ndarray, shape (quantities,)
        Differences of the quantities, each in its unit.
    is_alike : bool
        Whether both had the same events in the same order.
    coarse : int
        The coarser level.
    method : str
        Of integration of the answer from then on.
    """

    level: int
    jump: int
    apart: np.ndarray
    is_alike: bool = True
    coarse: int = 0
    method: str = ""


class Left(NamedTuple):
    """The error of a source that is left at its level, with the safety.

    Attributes
    ----------
    errors : ndarray, shape (quantities,)
        In the units of the quantities.
    ratios : ndarray, shape (quantities,)
        Of the errors of two levels, as far as three levels show it; nan where it is assumed.
    is_erratic : ndarray of bool, shape (quantities,)
        Whether differences do not fall.
    """

    errors: np.ndarray
    ratios: np.ndarray
    is_erratic: np.ndarray

    @classmethod
    def none(cls, count: int) -> Left:
        """Return that of a source without an error."""
        return cls(np.zeros(count), np.full(count, np.nan), np.zeros(count, bool))


def left_of(pairs: list[Pair], assumed: float = ASSUMED) -> Left:
    """Return what is left of a source at the finer level of the last pair."""
    last = pairs[-1]
    if len(pairs) == 1:
        share = assumed**last.jump
        errors = SAFETY * last.apart * share / (1.0 - share)
        return Left(errors, np.full(len(errors), np.nan), np.zeros(len(errors), bool))
    before = pairs[-2]
    found = [_left(coarse, before.jump, fine, last.jump) for coarse, fine in zip(before.apart, last.apart, strict=True)]
    errors, ratios, erratic = (np.array(column) for column in zip(*found, strict=True))
    return Left(errors, ratios, erratic.astype(bool))


def _left(coarse: float, jump: int, fine: float, last_jump: int) -> tuple[float, float, bool]:
    """Return error, ratio and whether differences do not fall, from two pairs in a row."""
    if coarse == fine == 0.0:
        return 0.0, np.nan, False
    ratio = ratio_of(coarse, jump, fine, last_jump)
    if ratio > NOT_FALLING:
        return SAFETY * max(coarse, fine) * NOT_FALLING / (1.0 - NOT_FALLING), ratio, True
    believed = max(ratio, LEAST) ** last_jump
    apart = max(fine, coarse * LEAST**jump * (1.0 - LEAST**last_jump) / (1.0 - LEAST**jump))
    return SAFETY * apart * believed / (1.0 - believed), ratio, False


def ratio_of(coarse: float, jump: int, fine: float, last_jump: int) -> float:
    """Return r of ``fine (1 - r^jump) = coarse r^jump (1 - r^last_jump)``, 1 if there is none below."""
    low, high = 0.0, 1.0
    if fine * jump >= coarse * last_jump:  # the limit of both sides at r = 1
        return 1.0
    for _ in range(50):
        middle = 0.5 * (low + high)
        if coarse * middle**jump * (1.0 - middle**last_jump) > fine * (1.0 - middle**jump):
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)
