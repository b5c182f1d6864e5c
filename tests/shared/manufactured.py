"""Manufactured answers: an exact value, and an error of each source that falls by a ratio of its own at each level."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.certified.choice import Choice, Levels, Source
from kanefe.certified.limits import Limits
from kanefe.certified.quantity import Quantity, quantities_of
from kanefe.certified.search import Search
from kanefe.certified.trial import Trial
from kanefe.certified.values import values_of

EXACT = 2.0


@dataclass
class Manufactured:
    """Answers at levels of sources.

    Attributes
    ----------
    errors : ndarray, shape (sources, numbers)
        At level 0.
    ratios : ndarray, shape (sources,)
        Of errors, from level to level.
    noise : float
        What of the largest error stays, with another sign at each setting.
    is_exact : bool
        Whether the last source has two levels, of which the second has no error.
    """

    errors: np.ndarray
    ratios: np.ndarray
    levels: int = 9
    noise: float = 0.0
    is_exact: bool = False

    def values(self, levels: Levels) -> np.ndarray:
        fall = self.ratios ** np.array(levels, float)
        if self.is_exact and levels[-1] == 1:
            fall[-1] = 0.0
        chance = np.random.default_rng(levels).uniform(-1, 1, self.errors.shape[1])
        return EXACT + fall @ self.errors + self.noise * np.abs(self.errors).max() * chance

    def search(self, accuracy: float, limits: Limits | None = None, kind: str = "history") -> Search:
        """Return the finished search for an accuracy."""
        whole: Quantity
        (whole,) = quantities_of({"values": lambda answer: answer}, accuracy)
        sources = []
        for i in range(len(self.ratios)):
            is_last = self.is_exact and i == len(self.ratios) - 1
            choices = tuple(Choice(f"level {n}", f"source_{i}={n}") for n in range(2 if is_last else self.levels))
            sources.append(Source(f"source {i}", choices, is_exact=is_last))

        def evaluate(levels: Levels) -> Trial:
            answer = self.values(levels)
            work = float(np.prod(1.5 ** np.array(levels)))
            return Trial(levels, answer, values_of(whole, answer), np.zeros(1), (), work)

        search = Search(evaluate, tuple(sources), (whole,), limits or Limits(), lambda count, bound: None, [])
        search.run()
        return search


def manufactured(seed: int) -> tuple[Manufactured, float]:
    """Return answers of a seed, and an accuracy."""
    rng = np.random.default_rng((7, seed))
    sources, numbers = int(rng.integers(1, 6)), int(rng.choice((1, 3, 100)))
    errors = rng.standard_normal((sources, numbers)) * 10 ** rng.uniform(-4, -1, (sources, 1))
    made = Manufactured(errors, 10 ** rng.uniform(-1.5, -0.35, sources), is_exact=bool(rng.integers(2)) and sources > 1)
    return made, 10 ** rng.uniform(-5, -2)
