"""Drawn scenes in parts: some in every run of the tests, all with those that are marked slow."""

import pytest


def in_parts(count: int, *, short: int) -> list:
    """Return the numbers of `count` parts as parameters, those from `short` on marked slow."""
    return [pytest.param(part, marks=[pytest.mark.slow] if part >= short else []) for part in range(count)]
