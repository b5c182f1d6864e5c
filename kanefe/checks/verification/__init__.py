"""Verification cases that ship with the package, with references from closed forms and independent codes.

`case.py` says what a case is, `registry.py` which there are, `runner.py` runs them.
"""

from kanefe.checks.verification.case import Case, Check, Reference

__all__ = ["Case", "Check", "Reference"]
