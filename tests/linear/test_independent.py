"""Leading and following entries, chosen loop by loop, against all rows at once."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg

import kanefe as kf
from kanefe.linear import independent
from kanefe.linear.small_motions import SmallMotions
from loop_scenes import four_bars, spatial_loop

ROUND_OFF = 1e-11
"""Of N and of the inverse, over their largest entry: 1e-16 times the condition of the rows that follow."""

SCENES = {
    "apart": lambda: four_bars(4, "apart"),
    "apart, rods": lambda: four_bars(4, "apart", closed_by="rods"),
    "in a row": lambda: four_bars(4, "in a row"),
    "one on the other": lambda: four_bars(4, "one on the other"),
    "free base": lambda: four_bars(3, "apart", base="free"),
    "flexible, driven, gear": lambda: spatial_loop(1),
}


def small_of(scene: kf.System) -> SmallMotions:
    """Return the small motions about the start of a scene."""
    model = scene.freeze()
    return SmallMotions(model, 0.0, model.initial_coordinates, model.initial_speeds)


@pytest.mark.parametrize("name", SCENES)
def test_loop_by_loop_is_all_at_once(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    found = small_of(SCENES[name]()).positions
    monkeypatch.setattr(independent, "groups_of_rows", lambda J: [np.arange(len(J))])
    small = small_of(SCENES[name]())
    expected = small.positions
    np.testing.assert_array_equal(found.leading, expected.leading)
    np.testing.assert_array_equal(found.following, expected.following)
    for one, other in ((found.N, expected.N), (found.inverse, expected.inverse)):
        np.testing.assert_allclose(one, other, rtol=0, atol=ROUND_OFF * np.abs(other).max())
    left = small._divided.J @ found.N
    np.testing.assert_allclose(left, 0.0, atol=ROUND_OFF * np.abs(small._divided.J).max())


def test_factorisations_are_as_large_as_one_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = []
    for module, name in ((scipy.linalg, "qr"), (scipy.linalg, "orth"), (np.linalg, "pinv")):
        solved = getattr(module, name)

        def counted(A, *args, solved=solved, **options):
            sizes.append(A.shape)
            return solved(A, *args, **options)

        monkeypatch.setattr(module, name, counted)
    assert small_of(four_bars(12, "apart")).positions.N.shape == (36, 12)
    assert max(sizes) <= (5, 3)  # rows of a spatial pin, speeds of a four-bar
    assert len(sizes) <= 4 * 12
