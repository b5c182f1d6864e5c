"""The coarsest settings that are good enough, and the fastest of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress

import numpy as np

from benchmarks.peer_process import NoPeers
from benchmarks.work_precision.runs import TookTooLong
from benchmarks.work_precision.scene import Setting
from kanefe.errors import SimulationError


def fastest(
    curves: Iterable[Iterable[Setting]], excess: Callable[[Setting], float], clock: Callable[[Setting], float]
) -> Setting:
    """Return the fastest of the settings that are each the coarsest of their curve that is good enough.

    Raises
    ------
    NoPeers
        If none is.
    """
    found = []
    for settings in curves:
        with suppress(NoPeers):
            found.append(coarsest(settings, excess, 1.0)[0])
    if not found:
        raise NoPeers("no setting of any method is good enough")
    return min(found, key=clock)


def coarsest(settings: Iterable[Setting], error: Callable[[Setting], float], allowed: float) -> tuple[Setting, float]:
    """Return the coarsest setting that is good enough, and its error; the next finer one must be so as well.

    Raises
    ------
    NoPeers
        If none is before two runs have taken too long.
    """
    before: tuple[Setting, float] | None = None
    slow = 0
    for setting in settings:
        try:
            found = error(setting)
        except TookTooLong:
            slow += 1
            if slow > 1:
                break
            continue
        except (NoPeers, SimulationError):
            found = np.inf
        if not found <= allowed:
            before = None
        elif before is not None:
            return before
        else:
            before = setting, found
    if before is None:
        raise NoPeers("no setting is good enough")
    return before
