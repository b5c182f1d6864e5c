"""Why an accuracy is not met."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from kanefe.certified.search import Search


def why_not(search: Search) -> str:
    """Return why the accuracy is not met, of the source with most of the error."""
    parts = {n: float(np.max(left.errors / search.allowed)) for n, left in enumerate(search.lefts) if left is not None}
    worst = max(parts, key=lambda number: parts[number])
    name, pairs = search.sources[worst].name, search.pairs.get(worst, [])
    left = search.left(worst)
    if left is not None and left.is_erratic.any():
        others = "" if all(pair.is_alike for pair in pairs) else ", and events come in another order"
        return (
            f"pairs of {name} contradict each other: their differences do not fall{others}. Such a motion is "
            "chaotic, or an event of it grazes, and has no bound. Remedy: a shorter span, a quantity before the "
            "event, or statistics over many runs (kanefe.Study)"
        )
    end = search.exhausted.get(worst, "there are no finer levels")
    return f"most of the error is of {name}, which cannot be made finer: {end}"
