"""Figures of motion-induced stiffening: the spin-up of a flexible arm, and the frequencies of a rotating cantilever.

They are those of the verification cases D01 and D03a, as errors against geometrically exact and Ritz references.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from benchmarks.goals import Figure, Goal
from kanefe.checks.verification import Check, Reference
from kanefe.checks.verification.references import load_references

Run = Callable[[Reference], Iterable[Check]]

PEAK, TIME = "D01 spin-up, {}: error of the peak", "D01 spin-up, {}: error of its time [s]"
FIRST, OTHERS = "D03a rotating cantilever, {}: error of the first mode", "D03a, {}: error of the first three modes"

SPIN_UP = {kind: (Goal(PEAK.format(kind), 2e-3), Goal(TIME.format(kind), 1e-2)) for kind in ("beams", "solids")}
ROTATING = {kind: (Goal(FIRST.format(kind), 1e-4), Goal(OTHERS.format(kind), 1e-3)) for kind in ("beams", "solids")}


def spin_up_of_beams(_: Any) -> list[Figure]:
    """Measure D01 with a body of beams."""
    from kanefe_fem.verification.stiffened_beams import arm_of_beams

    return _errors("D01", arm_of_beams, SPIN_UP["beams"])


def spin_up_of_solids(_: Any) -> list[Figure]:
    """Measure D01 with a solid mesh."""
    from kanefe_fem.verification.stiffened_solids import arm_of_solids

    return _errors("D01", arm_of_solids, SPIN_UP["solids"])


def rotating_cantilever_of_beams(_: Any) -> list[Figure]:
    """Measure D03a with a body of beams."""
    from kanefe_fem.verification.stiffened_beams import rotating_cantilever

    return _errors("D03a", rotating_cantilever, ROTATING["beams"])


def rotating_cantilever_of_solids(_: Any) -> list[Figure]:
    """Measure D03a with a solid mesh."""
    from kanefe_fem.verification.stiffened_solids import rotating_blade

    return _errors("D03a", rotating_blade, ROTATING["solids"])


def _errors(case: str, run: Run, goals: Iterable[Goal]) -> list[Figure]:
    """Return the errors of the first checks of a case: those that the goals are about, in their order."""
    checks = zip(goals, run(load_references()[case]), strict=False)
    return [goal.figure(check.error, check.quantity) for goal, check in checks]


GROUPS: dict[Callable[[Any], list[Figure]], list[Goal]] = {
    spin_up_of_beams: list(SPIN_UP["beams"]),
    spin_up_of_solids: list(SPIN_UP["solids"]),
    rotating_cantilever_of_beams: list(ROTATING["beams"]),
    rotating_cantilever_of_solids: list(ROTATING["solids"]),
}
