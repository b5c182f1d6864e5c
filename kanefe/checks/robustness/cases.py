"""The stress cases of the package; their short form checks an installation within a minute."""

from __future__ import annotations

from kanefe.checks.robustness import contact_changes, drift, loops, spin
from kanefe.checks.robustness.case import StressCase

CASES: tuple[StressCase, ...] = (*drift.CASES, *loops.CASES, *spin.CASES, *contact_changes.CASES)
"""In the order in which they run."""
