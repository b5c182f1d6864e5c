"""Starts of random loops, given by as many joints as they leave free, against the same motion reached by a run."""

import pytest

from random_starts import KINDS, random_start


@pytest.mark.parametrize(
    ("kind", "seed"),
    [("rigid", 0), ("flexible", 1), ("exact", 2), ("tree", 2), ("tree", 3), ("flexible tree", 2), ("flexible tree", 3)],
)
def test_a_start_is_that_of_the_same_motion(kind: str, seed: int) -> None:
    found = random_start(seed, kind)
    assert found is not None
    assert found.is_right, found


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_two_hundred_of_each(kind: str) -> None:
    found = [one for one in (random_start(seed, kind) for seed in range(200)) if one is not None]
    assert len(found) >= 80  # of trees whose joints alone can follow
    assert [one for one in found if not one.is_right] == []
