"""Scenes drawn by a seed: every kind occurs, and a seed gives the same scene again."""

from __future__ import annotations

import warnings
from collections import Counter

import numpy as np

from benchmarks.drawn_scenes import Drawn, drawn

SEEDS = 30
KINDS = {
    "chain",
    "tree",
    "loop",
    "flexible",
    "contact",
    "rigid contact",
    "controller",
    "sampled controller",
    "smooth drive",
    "drive with jumps",
    "stiff",
    "soft",
    "damped",
    "undamped",
}


def test_every_kind_is_drawn() -> None:
    found = Counter(word for seed in range(SEEDS) for word in drawn(seed).words)
    assert found.keys() == KINDS


def test_a_seed_gives_the_same_scene_again() -> None:
    for seed in range(6):
        one, other = drawn(seed), drawn(seed)
        assert (one.words, one.seconds, one.bodies) == (other.words, other.seconds, other.bodies)
        np.testing.assert_array_equal(_end(one), _end(other))


def _end(of: Drawn) -> np.ndarray:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = of.scene.simulate((0.0, 2e-3), rtol=1e-4, output_times=[2e-3])
    return np.hstack([result.position(name) for name in of.bodies])
