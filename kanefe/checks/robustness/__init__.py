"""Stress tests of the engine: many extreme inputs each, with the worst error and its limit.

``kanefe stress`` runs the few cases of the package. `case.py` defines a case, `cases.py` lists those of the package,
`runner.py` runs them. The many long cases are with the tests, in ``tests/robustness/``.
"""

from kanefe.checks.robustness.case import Finding, StressCase

__all__ = ["Finding", "StressCase"]
