"""Verification cases of the package, with references from closed forms and independent codes.

`case.py` defines a case, `registry.py` lists them, `runner.py` runs them.
"""

from kanefe.checks.verification.case import Case, Check, Reference

__all__ = ["Case", "Check", "Reference"]
