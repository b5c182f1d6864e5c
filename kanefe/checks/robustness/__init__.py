"""Stress tests of the engine: what is tried, how often, the worst figure and its limit. ``kanefe stress`` runs them.

`case.py` says what a case is, `registry.py` which there are, `runner.py` runs them.
"""

from kanefe.checks.robustness.case import Finding, StressCase

__all__ = ["Finding", "StressCase"]
