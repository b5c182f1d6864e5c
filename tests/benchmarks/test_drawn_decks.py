"""Decks drawn at random: CalculiX, where it is installed, has the nodes, sets and masses of what is read.

Bulk data with GRDSET, and with its systems at each point, have the same points.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from benchmarks.decks import difference
from benchmarks.drawn_bulk_data import GRIDS, bulk_of
from kanefe.imports.bulk_data import bulk_cards
from kanefe.imports.grid_points import grid_points


@pytest.mark.skipif(shutil.which("ccx") is None, reason="there is no CalculiX")
@pytest.mark.parametrize("seed", [1, 7, 9])
def test_calculix_has_the_same_nodes_sets_and_masses(seed: int) -> None:
    """Decks with other files, elements of second order, and sets of sets."""
    assert difference(seed) == ""


@pytest.mark.parametrize("seed", [0, 3])
def test_what_grdset_says_may_stand_at_each_point(seed: int, tmp_path: Path) -> None:
    """In fields of all forms, and in free ones alone."""
    found = []
    for explicit in (False, True):
        (tmp_path / "a.bdf").write_text(bulk_of(seed, explicit))
        found.append(grid_points(bulk_cards(tmp_path / "a.bdf")))
    for ours, theirs in zip(*found, strict=True):
        np.testing.assert_array_equal(ours, theirs)
    assert np.count_nonzero(found[0].labels <= GRIDS) == GRIDS
