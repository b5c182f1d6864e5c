"""Decks drawn at random: CalculiX, where it is installed, has the nodes, sets and masses of what is read."""

from __future__ import annotations

import shutil

import pytest

from benchmarks.decks import difference


@pytest.mark.skipif(shutil.which("ccx") is None, reason="there is no CalculiX")
@pytest.mark.parametrize("seed", [1, 7, 9])
def test_calculix_has_the_same_nodes_sets_and_masses(seed: int) -> None:
    """Decks with other files, elements of second order, and sets of sets."""
    assert difference(seed) == ""
