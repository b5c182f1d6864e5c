"""When a run tries other methods, which is next, and whether it goes on with one: by the work that is counted."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from kanefe.integrate.auto.trials import Trial

SHARE = 0.08
"""Largest work of trials relative to that of the whole run: a tenth, with what is left late."""

FORESEEN = 2.0
"""Largest work of the rest of a run, as foreseen, relative to that so far: where vibrations of the start fade, the rest
has less work than the part so far lets expect."""

FIRST_STRETCH = 16
"""Steps of the first stretch."""

FIRST_LOOK = 1e6
"""Work at which it is looked at first, in products: a third of a millisecond."""

LOOKS = 2
"""Looks at the work until the steps have doubled, about."""

WORTH = 3e6
"""Work of making another stepper, in products: a millisecond."""

SETTLED = 2.0
"""Fall of the work for a second of the run, between two looks, from which on a method still begins, relative to the
second look."""

DEARER = 4.0
"""Growth of the same, relative to the first look, from which on the regime has changed, and all methods are tried
again."""

LEAST_GAIN = 0.2
"""Share of the work that another method has to save: to about this accuracy work is counted."""

WINS, GAIN_OF_WINS = 2, 0.4
"""Stretches, one twice as long as the other, on which a method has to be better that follows every vibration, and the
share of the work that it has to save on both: where vibrations of the start fade, others will have longer steps."""

CHECKED = 2.0
"""Largest work of a trial that checks a method which steps over vibrations, relative to the work of that."""

FEWEST_STEPS = 3
"""Steps of another method in a stretch below which they are not typical of it, because the last one is cut."""


class TrialPlan:
    """The trials of a run, planned by their work.

    Parameters
    ----------
    count : int
        Of methods; number 0 is the one that was foreseen.
    start, stop : float
        Of the run, s.
    first_look : int
        Steps after which the work is looked at first.

    Attributes
    ----------
    next_look : int
        Steps of the run at which something is to be decided.
    rival : int
        The method that is tried, or was the last.
    work, tried_work : float
        Of the run so far and of its trials, in products.
    """

    def __init__(self, count: int, start: float, stop: float, first_look: int) -> None:
        self._count, self._stop = count, stop
        self.next_look, self.rival = first_look, 0
        self.work = self.tried_work = 0.0
        self._length, self._afforded, self._price = FIRST_STRETCH, 0.0, math.inf
        self._looked = start, 0.0, 0
        self._out: set[int] = set()
        self._made = {0}  # whose steppers this run has asked for: a run before may have made more
        self._wins: dict[int, int] = {}

    def begins_stretch(self, t: float, steps: int, now: int) -> bool:
        """Return whether the method `now` begins a stretch at a time t (s), which a rival will go over too.

        If none is afforded, `next_look` tells when to ask again.
        """
        since, work, before = self._looked
        self._looked = t, self.work, steps
        done = self.work - work
        price, a_step = done / max(t - since, 1e-300), done / max(steps - before, 1)
        begins = SETTLED * price < self._price  # the first steps of a method, or those after an event
        if price > DEARER * self._price:
            self._out.clear()
            self._length = FIRST_STRETCH
        self._price = price
        left = price * (self._stop - t)
        self._afforded = SHARE * (self.work + min(left, FORESEEN * self.work)) - self.tried_work
        rival = self._next_rival(now)
        cost = self._length * a_step + (0.0 if rival in self._made else WORTH)
        if rival is None or begins or cost > min(self._afforded, left):
            self.next_look = steps + max(FIRST_STRETCH, steps // LOOKS)
            return False
        self.rival, self.next_look = rival, steps + self._length
        return True

    def _next_rival(self, now: int) -> int | None:
        """Return the next method to be tried, in turn; None if all others are out."""
        for i in range(1, self._count + 1):
            number = (self.rival + i) % self._count
            if number != now and number not in self._out:
                return number
        return None

    def most_work(self, own: float, is_checked: bool) -> float:
        """Return at which work a trial is left, by the work of the run on the stretch."""
        return max(own, min(self._afforded, CHECKED * own)) if is_checked else own

    def takes(self, trial: Trial, now: int, is_checked: bool, steps_over: bool) -> bool:
        """Return whether the run goes on with the method of a trial.

        Parameters
        ----------
        trial : Trial
        now : int
            The method of the run.
        is_checked, steps_over : bool
            Whether that, and the one of the trial, steps over vibrations.
        """
        number, came_there = trial.method, math.isfinite(trial.off)
        self._length *= 2
        self._made.add(number)
        if came_there and trial.off > 1.0:
            self._out.add(now if is_checked else number)
            return is_checked
        is_sure = number == 0 or steps_over
        if came_there and trial.work < 1.0 - (LEAST_GAIN if is_sure else GAIN_OF_WINS):
            self._wins[number] = self._wins.get(number, 0) + 1
            if is_sure or self._wins[number] == WINS:
                return True
            self.rival = number - 1  # the same again
            return False
        self._wins[number] = 0
        if came_there and trial.steps < FEWEST_STEPS:
            self.rival = number - 1
        return False

    def went_on_with_another(self, t: float, steps: int) -> None:
        """Let the work be looked at once the method that has begun at a time t (s) has taken some steps."""
        self._wins, self._price, self._looked = {}, math.inf, (t, self.work, steps)
        self.next_look = steps + FIRST_STRETCH

    def leave_out(self, number: int) -> None:
        """Let a method not be tried, until the regime changes."""
        self._out.add(number)

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return all that was decided and booked."""
        reals = self._price, self._afforded, *self._looked[:2], self.work, self.tried_work
        return {
            "plan": np.array((self.rival, self._length, self.next_look, self._looked[2]), dtype=np.int64),
            "works": np.array(reals),
            "out": np.array(sorted(self._out), dtype=np.int64),
            "made": np.array(sorted(self._made), dtype=np.int64),
            "wins": np.array(list(self._wins.items()), dtype=np.int64).reshape(-1, 2),
        }

    def resume(self, snapshot: Mapping[str, np.ndarray]) -> None:
        """Continue from a snapshot."""
        self.rival, self._length, self.next_look, step = snapshot["plan"].tolist()
        self._price, self._afforded, t, work, self.work, self.tried_work = snapshot["works"].tolist()
        self._looked = t, work, step
        self._out, self._made = set(snapshot["out"].tolist()), set(snapshot["made"].tolist())
        self._wins = dict(snapshot["wins"].tolist())
