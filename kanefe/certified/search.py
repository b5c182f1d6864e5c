"""The search for levels of all sources at which the bound meets the accuracy.

Each evaluation raises one source from where the best one was, so that their difference is a pair. It is the best one
from then on, unless the pair shows that the coarser level would do: then the rest is done with that. Steps in time come
first, since their error is in all other pairs; then every source is raised once; then, until the bound is met, the one
that has the most of the error for the work that raising it took. One pair more, of a source at random, lowers it at the
end: it says whether pairs that were measured at coarser levels of the others still hold.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from math import ceil, log

import numpy as np

from kanefe.certified.choice import Kept, Levels, Source
from kanefe.certified.limits import Limits
from kanefe.certified.pairs import ASSUMED, LEAST, MISSED, SAFETY, Left, Pair, left_of
from kanefe.certified.quantity import Quantity
from kanefe.certified.reasons import why_not
from kanefe.certified.trial import Trial
from kanefe.certified.values import Values, allowed_error, refuse_constant
from kanefe.errors import KanefeError, ModelError

SMALL = 0.1
"""Error relative to what is allowed below which a source stays at its coarser level."""

QUIET = 0.2
"""Error relative to what is allowed above which steps in time are raised before other sources."""

MORE_STEPS = 1.1
"""Ratio of the numbers of steps of two tolerances below which they are one: nearly the same steps have nearly the same
error, which their difference does not show. Then a tolerance more is tried, as if it were the next level."""

TRIES = 3
"""Number of times that raising a source may fail before it is left, also on finer meshes."""

FURTHER = 3
"""Number of levels up to which tolerances are tried then."""

NOISE = 0
"""Number of the source that is in all pairs, if there is one."""

FINEST = 0.01
"""Smallest bound that is stated, relative to what is allowed: differences far below that measure chance."""

CHECK = 0.25
"""Work of the pair that checks the statement, relative to that of all others, above which it is not evaluated."""

FARTHEST = 2
"""Largest number of levels by which a source is raised at once."""

SEED = 63
"""Number from which the choice of the source that is checked follows: a constant seed."""

STUCK = 3
"""Number of pairs in a row whose differences do not fall after which a source is given up."""


@dataclass(eq=False)
class Search:
    """A search for levels; `run` does it.

    Attributes
    ----------
    evaluate : callable
        ``evaluate(levels) -> Trial``; a ModelError says that there is no such level.
    sources : tuple of Source
    quantities : tuple of Quantity
    limits : Limits
    tell : callable
        Takes the number of evaluations and the largest bound relative to what is allowed.
    kept : list of Kept
        Sources that cannot be varied.
    best : Trial
        The answer so far.
    """

    evaluate: Callable[[Levels], Trial]
    sources: tuple[Source, ...]
    quantities: tuple[Quantity, ...]
    limits: Limits
    tell: Callable[[int, float], None]
    kept: list[Kept]
    best: Trial = field(init=False)
    pairs: dict[int, list[Pair]] = field(default_factory=dict)
    evaluations: int = 0
    exhausted: dict[int, str] = field(default_factory=dict)
    failures: Counter[int] = field(default_factory=Counter)
    growth: dict[int, float] = field(default_factory=dict)
    declined: set[int] = field(default_factory=set)
    reason: str = ""
    effectivity: float = np.nan
    checked: str = ""
    spent: float = 0.0

    def run(self) -> None:
        """Search; afterwards `best`, `lefts`, `reason` and the rest say what was found."""
        self._began, self._last = time.monotonic(), -1
        try:
            self._start()
            self._climb()
        except KeyboardInterrupt:
            if not self.evaluations:
                raise
            self.reason = "interrupted by Ctrl-C"
        if not self.reason and not self._is_met():
            self.reason = self._why_not()

    def _why_not(self) -> str:
        """Return why the accuracy is not met."""
        parts = {n: float(np.max(left.errors / self.allowed)) for n, left in enumerate(self.lefts) if left is not None}
        worst = max(parts, key=lambda number: parts[number])
        end = self.exhausted.get(worst, "there are no finer levels")
        return why_not(self.sources[worst].name, self.left(worst), self.pairs.get(worst, []), end)

    def _climb(self) -> None:
        """Raise sources until the bound is met or nothing is left to be raised."""
        while self.reason == "":
            source = self._next()
            if source is None and self._is_met() and self._is_stale():
                source = NOISE
            if source is None:
                if self._is_met() and self._check():
                    continue
                break
            if not self._may_go_on(source):
                break
            self._raise(source)

    def _start(self) -> None:
        """Evaluate at the first levels, or at those given where the first ones make no answer."""
        first = tuple(source.first for source in self.sources)
        given = tuple(max(source.first, source.given) for source in self.sources)
        try:
            trial = self._evaluated(first)
            if not trial.is_whole and first != given:
                trial = self._evaluated(given)
        except KanefeError:
            if first == given:
                raise
            trial = self._evaluated(given)
        for quantity, values in self._owned(trial):
            refuse_constant(quantity, values)
        self.best, self.evaluations = trial, 1
        if not trial.is_whole:
            self.reason = f"the first run did not finish: {trial.answer.status}"

    def _owned(self, trial: Trial) -> list[tuple[Quantity, Values]]:
        owners = {quantity.title: quantity for quantity in self.quantities}
        return [(owners[values.title.partition(" [")[0]], values) for values in trial.values]

    def _evaluated(self, levels: Levels) -> Trial:
        trial = self.evaluate(levels)
        self.spent += trial.seconds
        return trial

    @property
    def allowed(self) -> np.ndarray:
        """Largest error of each quantity, in its unit."""
        return np.array([allowed_error(quantity, values.size) for quantity, values in self._owned(self.best)])

    def left(self, number: int) -> Left | None:
        """Return what is left of a source; None before it was raised."""
        source, level = self.sources[number], self.best.levels[number]
        count = len(self.best.values)
        if source.is_inner:
            errors = SAFETY * MISSED * self.best.sampled
            return Left(errors, np.full(count, np.nan), np.zeros(count, bool))
        if source.is_exact and level == len(source.choices) - 1:
            return Left.none(count)
        pairs = self.pairs.get(number)
        if pairs and pairs[-1].level > level:  # the finer level is not needed
            return Left(SAFETY * pairs[-1].apart, np.full(count, np.nan), np.zeros(count, bool))
        return left_of(pairs) if pairs else None

    @property
    def lefts(self) -> list[Left | None]:
        """What is left of each source."""
        return [self.left(number) for number in range(len(self.sources))]

    @property
    def bounds(self) -> np.ndarray:
        """Bound of the error of each quantity, of the sources that were raised, in its unit."""
        known = [left.errors for left in self.lefts if left is not None]
        return np.maximum(np.sum(known, axis=0), FINEST * self.allowed) if known else FINEST * self.allowed

    def _is_met(self) -> bool:
        return bool(np.all(self.bounds <= self.allowed))

    def _can_rise(self, number: int) -> bool:
        return number not in self.exhausted and self.best.levels[number] + 1 < len(self.sources[number].choices)

    def _next(self) -> int | None:
        """Return the source to be raised; None if there is none, or no need."""
        lefts, allowed = self.lefts, self.allowed
        if self._is_noisy(lefts):
            return NOISE
        for number, left in enumerate(lefts):
            if left is None and self._can_rise(number):
                return number
        if self._is_met() or self._is_hopeless():
            return None
        weights = {
            number: float(np.max(left.errors / allowed)) / self.growth.get(number, 1.5)
            for number, left in enumerate(lefts)
            if left is not None and self._can_rise(number) and not self._is_stuck(number)
        }
        worst = max(weights, key=lambda number: weights[number], default=None)
        return worst if worst is not None and weights[worst] > 0.0 else None

    def _is_noisy(self, lefts: list[Left | None]) -> bool:
        """Return whether steps in time are to be raised first, whose errors are in all other pairs.

        Of stiff scenes they are larger with more modes and finer meshes, so that differences of these do not fall.
        """
        if not self.sources[NOISE].is_noise or not self._can_rise(NOISE) or self._is_stuck(NOISE):
            return False
        own = lefts[NOISE]
        erratic = any(
            left is not None and bool(np.any(left.is_erratic & (left.errors > self.allowed))) for left in lefts
        )
        return own is None or bool(np.any(own.errors > QUIET * self.allowed)) or (erratic and self._last != NOISE)

    def _is_stale(self) -> bool:
        """Return whether steps in time were looked at with another method of integration than that of the answer."""
        pairs = self.pairs.get(NOISE)
        is_other = pairs is not None and pairs[-1].method != self.best.method
        return is_other and self.sources[NOISE].is_noise and self._can_rise(NOISE)

    def _is_hopeless(self) -> bool:
        """Return whether a source that cannot be raised has more than is allowed alone."""
        finer = any(source.memory > 1.0 and self._can_rise(number) for number, source in enumerate(self.sources))
        ends = [
            left
            for number, left in enumerate(self.lefts)
            if left is not None and not self._can_rise(number) and not (finer and 0 < self.failures[number] < TRIES)
        ]
        return any(bool(np.any(left.errors > self.allowed)) for left in ends)

    def _is_stuck(self, number: int) -> bool:
        """Return whether the differences of a source did not fall for some pairs in a row."""
        pairs = self.pairs.get(number, [])
        if len(pairs) <= STUCK:
            return False
        worst = [float(np.max(pair.apart / self.allowed)) for pair in pairs[-STUCK - 1 :]]
        return min(worst[1:]) > 0.5 * worst[0] and min(worst) > 1.0

    def _jump(self, number: int) -> int:
        """Return by how many levels a source is raised: as its ratio lets expect that its error then is small."""
        left, pairs = self.left(number), self.pairs.get(number)
        room = len(self.sources[number].choices) - 1 - self.best.levels[number]
        if left is None or not pairs or self.sources[number].is_exact:
            return 1
        seen = left.ratios[np.isfinite(left.ratios)]
        ratio = min(max(float(seen.max(initial=LEAST)), LEAST), 0.5) if len(seen) else ASSUMED
        too_large = float(np.max(left.errors / self.allowed)) * len(self.sources)
        wanted = ceil(log(max(too_large, 1.0)) / log(1.0 / ratio))
        return int(np.clip(wanted, 1, min(FARTHEST, room)))

    def _raise(self, number: int) -> None:
        before, self._last = self.best, number
        jump = self._jump(number)
        trial = self._raised(number, jump)
        if trial is None and jump > 1:
            trial, jump = self._raised(number, 1), 1
        if trial is None:
            return
        jump = 1 if trial.levels[number] > before.levels[number] + jump else jump
        pairs = self.pairs.setdefault(number, [])
        if pairs and (pairs[-1].level > before.levels[number] or (number == NOISE and self._is_stale())):
            pairs.clear()
        apart = trial.apart(before)
        if pairs or number in self.declined or np.any(SAFETY * apart > SMALL * self.allowed):
            self.best = trial
        else:
            self.declined.add(number)
        pairs.append(
            Pair(
                trial.levels[number],
                jump,
                apart,
                trial.events == before.events,
                before.levels[number],
                self.best.method,
            )
        )
        self.growth[number] = max(trial.seconds / max(before.seconds, 1e-9), 1.05) ** (1.0 / jump)
        self.evaluations += 1
        self.tell(self.evaluations, float(np.max(self.bounds / self.allowed)))

    def _raised(self, number: int, jump: int) -> Trial | None:
        """Return the evaluation with a source raised; None, with the reason kept, where there is none."""
        levels, source = self.best.levels, self.sources[number]
        level, last = levels[number] + jump, len(source.choices) - 1
        try:
            trial = self._evaluated((*levels[:number], level, *levels[number + 1 :]))
            while source.is_noise and self._is_the_same(trial) and level < min(levels[number] + FURTHER, last):
                level += 1
                trial = self._evaluated((*levels[:number], level, *levels[number + 1 :]))
        except ModelError as error:
            self._give_up(number, str(error))
            return None
        if not trial.is_whole:
            self._give_up(number, str(trial.answer.status))
            return None
        if source.memory > 1.0:  # a finer mesh has more modes
            self.exhausted = {one: why for one, why in self.exhausted.items() if self.failures[one] >= TRIES}
        return trial

    def _give_up(self, number: int, why: str) -> None:
        """Leave a source at its level, with the reason."""
        self.exhausted[number] = why
        self.failures[number] += 1

    def _is_the_same(self, trial: Trial) -> bool:
        """Return whether a run with a smaller tolerance took the same steps, so that it agrees whatever its error."""
        if not trial.is_whole or trial.steps > MORE_STEPS * self.best.steps:
            return False
        return bool(np.all(SAFETY * trial.apart(self.best) <= SMALL * self.allowed))

    def _may_go_on(self, number: int) -> bool:
        """Return whether limits of time and memory leave room for raising a source; say if not."""
        needed = self.best.seconds * self.growth.get(number, 1.5)
        gone = time.monotonic() - self._began
        if self.limits.seconds is not None and gone + needed > self.limits.seconds:
            self.reason = (
                f"most_seconds={self.limits.seconds:g} were not enough: {gone:.3g} s were spent, and the next "
                f"evaluation ({self.sources[number].name}) would take about {needed:.2g} s"
            )
        else:
            self.reason = self.limits.too_little_memory(self.sources[number].name, self.sources[number].memory)
        return not self.reason

    def _check(self) -> bool:
        """Check one pair again at the final levels of the others; return whether the bound is not met any more."""
        possible = [
            number
            for number, pairs in self.pairs.items()
            if len(self.pairs) > 1 and pairs[-1].level == self.best.levels[number]
        ]
        if self.checked or not possible:
            self.checked = self.checked or "no other source was raised, so that there is nothing to check"
            return False
        number = int(np.random.default_rng(SEED).choice(possible))
        last = self.pairs[number][-1]
        expected = self.best.seconds / self.growth[number] ** last.jump
        if expected > CHECK * self.spent:
            share = expected / self.spent
            self.checked = (
                f"not checked: one more pair would add {100 * share:.0f} % to the work, more than {100 * CHECK:g} %"
            )
            return False
        levels = list(self.best.levels)
        levels[number] = last.coarse
        lowered = self._evaluated(tuple(levels))
        apart = self.best.apart(lowered)
        counts = np.maximum(apart, last.apart) > 1e-3 * self.allowed
        self.effectivity = float(np.max(np.where(counts, apart / np.maximum(last.apart, 1e-300), 0.0), initial=0.0))
        self.checked = (
            f"{self.sources[number].name}: the pair at the final setting is {self.effectivity:.2g} of the stated"
        )
        self.pairs[number][-1] = last._replace(apart=np.maximum(apart, last.apart))
        return not self._is_met()
