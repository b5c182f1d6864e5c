"""Trial: an answer at some levels of all sources, with its quantities and what it cost."""

from __future__ import annotations

import os
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from kanefe.certified.choice import Levels
from kanefe.certified.values import Values


@dataclass(frozen=True, eq=False)
class Trial:
    """An answer at some levels.

    Attributes
    ----------
    levels : tuple of int
    answer : object
    values : list of Values
    sampled : ndarray, shape (quantities,)
        How far the quantities change at most if only every fourth output is looked at.
    events : tuple of str
        Names in the order of time.
    seconds : float
        CPU time, s.
    texts : list
        Warnings.
    is_whole : bool
        Whether it was finished.
    method : str
        Of integration.
    """

    levels: Levels
    answer: Any
    values: list[Values]
    sampled: np.ndarray
    events: tuple[str, ...] = ()
    seconds: float = 0.0
    texts: Sequence[warnings.WarningMessage] = field(default_factory=list)
    is_whole: bool = True
    method: str = ""
    steps: int = 0

    def apart(self, other: Trial) -> np.ndarray:
        """Return how far the quantities of two trials are apart."""
        return np.array([mine.apart(theirs) for mine, theirs in zip(self.values, other.values, strict=True)])


def timed(work: Callable[[], Any]) -> tuple[Any, float, list[warnings.WarningMessage]]:
    """Return what some work gives, its CPU time with that of its processes in s, and its warnings, not shown."""
    before = _cpu_seconds()
    with warnings.catch_warnings(record=True) as texts:
        warnings.simplefilter("always")
        found = work()
    return found, _cpu_seconds() - before, texts


def _cpu_seconds() -> float:
    """Return the CPU time of this process, and of processes that it has waited for, s."""
    of_children = os.times()
    return time.process_time() + of_children.children_user + of_children.children_system
