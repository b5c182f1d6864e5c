"""Stress tests of the engine: what is tried, how often, the worst figure and its limit. ``kanefe stress`` runs a few.

`case.py` says what a case is, `cases.py` which the package brings, `runner.py` runs them. The many long ones stand
beside the tests: ``tests/robustness/``.
"""

from kanefe.checks.robustness.case import Finding, StressCase

__all__ = ["Finding", "StressCase"]
