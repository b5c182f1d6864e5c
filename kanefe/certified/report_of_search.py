"""What a search found, as an `Accuracy`."""

from __future__ import annotations

import numpy as np

from kanefe.certified.choice import Levels, settings
from kanefe.certified.pairs import SAFETY
from kanefe.certified.search import Search
from kanefe.results.accuracy import Accuracy, SourceOfError


def accuracy_of(search: Search) -> Accuracy:
    """Return the accuracy of the best answer of a search."""
    best, allowed, bounds = search.best, search.allowed, search.bounds.copy()
    found = [_source(search, number) for number in range(len(search.sources))]
    found.sort(key=lambda source: -float(np.max(np.nan_to_num(source.errors / allowed))))
    unknown = np.full(len(best.values), np.nan)
    for left in search.lefts:
        if left is not None:
            bounds[left.is_erratic & (left.errors > allowed)] = np.inf
    if not search.pairs and any(left is None for left in search.lefts):
        bounds = np.full(len(bounds), np.inf)
    is_met = not search.reason and bool(np.all(bounds <= allowed))
    enough = settings(search.sources, cheapest(search)).code if is_met else ""
    setting = settings(search.sources, best.levels).code
    return Accuracy(
        quantities=tuple(values.title for values in best.values),
        units=tuple(values.unit for values in best.values),
        sizes=np.array([values.size for values in best.values]),
        allowed=allowed,
        bounds=bounds,
        is_met=is_met,
        reason=search.reason,
        sources=(*found, *(SourceOfError(one.name, "as given", unknown, note=one.reason) for one in search.kept)),
        effectivity=search.effectivity,
        checked=search.checked,
        evaluations=search.evaluations,
        seconds=search.spent,
        last_seconds=best.seconds,
        setting=setting,
        cheapest="" if enough == setting else enough,
    )


def _source(search: Search, number: int) -> SourceOfError:
    source, level = search.sources[number], search.best.levels[number]
    left, pairs = search.left(number), search.pairs.get(number, [])
    if left is None:
        errors, ratio = np.full(len(search.best.values), np.nan), np.nan
    else:
        errors, worst = left.errors, int(np.argmax(left.errors / search.allowed))
        ratio = float(left.ratios[worst])
    levels = tuple(dict.fromkeys(source.choices[at].text for pair in pairs for at in (pair.coarse, pair.level)))
    notes = []
    if left is not None and left.is_erratic.any():
        notes.append("differences do not fall")
    if pairs and not pairs[-1].is_alike:
        notes.append("events come in another order")
    if source.is_exact and left is not None and level == len(source.choices) - 1:
        notes.append(f"none beyond; without it {_share(search, pairs)} of what is allowed" if pairs else "none beyond")
    elif left is None:
        notes.append(f"not raised: {search.exhausted[number]}" if number in search.exhausted else "not raised")
    elif pairs and pairs[-1].level > level:
        notes.append(f"finer not needed: {source.choices[pairs[-1].level].text}")
    elif not np.isfinite(ratio) and not source.is_inner:
        notes.append("fall assumed: 1/3 a level")
    apart = np.array([pair.apart for pair in pairs]).reshape(len(pairs), len(errors))
    return SourceOfError(source.name, source.choices[level].text, errors, ratio, levels, apart, "; ".join(notes))


def _share(search: Search, pairs: list) -> str:  # type: ignore[type-arg]
    return f"{float(np.max(sum(pair.apart for pair in pairs) / search.allowed)):.2g}"


def cheapest(search: Search) -> Levels:
    """Return the coarsest levels at which what is known still meets the accuracy."""
    levels, bounds, allowed = list(search.best.levels), search.bounds.copy(), search.allowed
    for number in sorted(search.pairs, key=lambda n: -search.growth.get(n, 1.0)):
        for pair in reversed(search.pairs[number]):
            if pair.level != levels[number]:
                break
            more = bounds + SAFETY * pair.apart
            if np.any(more > allowed):
                break
            bounds, levels[number] = more, pair.coarse
    return tuple(levels)
