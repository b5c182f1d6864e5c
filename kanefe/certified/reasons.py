"""Why an accuracy is not met."""

from __future__ import annotations

from collections.abc import Sequence

from kanefe.certified.pairs import Left, Pair


def why_not(name: str, left: Left | None, pairs: Sequence[Pair], end: str) -> str:
    """Return why the accuracy is not met, of the source with most of the error and what ended its levels."""
    if left is not None and left.is_erratic.any():
        others = "" if all(pair.is_alike for pair in pairs) else ", and events come in another order"
        return (
            f"pairs of {name} contradict each other: their differences do not fall{others}. Such a motion is "
            "chaotic, or an event of it grazes, and has no bound. Remedy: a shorter span, a quantity before the "
            "event, or statistics over many runs (kanefe.Study)"
        )
    return f"most of the error is of {name}, which cannot be made finer: {end}"
