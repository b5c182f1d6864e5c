"""A run in compiled code that looks out for events of loads: its calls, prepared once."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from kanefe.kernels.drives import Drives
from kanefe.kernels.entries import LATER, Bound, Call
from kanefe.kernels.quiet_steps import AT_TIME, SHARES, Going, Lookout, look_at, pass_quiet_steps
from kanefe.kernels.stepping import Run
from kanefe.order_n.evaluated import Evaluated

STEP_END = np.ones(1)


class Lookouts:
    """The lookouts of a run: of one thread at a time.

    Parameters
    ----------
    route : Evaluated
        Of an autonomous scene.
    motions : Drives
    vectors : ndarray
        Memory of the method.
    """

    def __init__(self, route: Evaluated, motions: Drives, vectors: np.ndarray) -> None:
        self._route, self._motions, self._vectors = route, motions, vectors
        self._kept: list[Call] = []  # of which kernels know the addresses
        self._looking: Call | None = None

    def pass_steps(self, going: Call, inputs: np.ndarray, run: Run, values: np.ndarray) -> tuple[int, bool]:
        """Go on: see `pass_quiet_steps`. `inputs` are those that controllers hold."""
        lookout, passing = self._passing
        lookout.inputs[:] = inputs
        signature = going.signature
        step = Going(going.for_kernels(), signature.place_of("run", "most_steps"), signature.number_count)
        command, is_quiet = passing(step, run, values)
        return int(command), bool(is_quiet)

    def values_at(self, run: Run, t: float) -> np.ndarray:
        """Return the values of all watched loads at a time of the last step."""
        lookout, looking = self._at_a_time
        if self._looking is None:
            empty = run._replace(times=np.zeros(0), states=np.zeros((0, self._vectors.shape[1])))
            self._looking = looking.prepared(empty, t)
        self._looking.numbers[AT_TIME] = t
        self._looking()
        return lookout.found[0]

    @cached_property
    def _passing(self) -> tuple[Lookout, Bound]:
        lookout = self._lookout(SHARES)
        return lookout, pass_quiet_steps.bound(LATER, lookout, LATER, self._vectors, LATER)

    @cached_property
    def _at_a_time(self) -> tuple[Lookout, Bound]:
        lookout = self._lookout(STEP_END)
        lookout.inputs[:] = self._passing[0].inputs[0]
        return lookout, look_at.bound(lookout, LATER, self._vectors, LATER)

    def _lookout(self, shares: np.ndarray) -> Lookout:
        route, count, size = self._route, len(shares), self._vectors.shape[1]
        times, drives = np.empty(count), np.empty((count, len(route.model.drives), 3))
        inputs, states = np.empty((count, len(route.inputs.constants))), np.empty((count, size))
        looking, found = route.watching.prepared(times, drives, inputs, states)
        self._kept.append(looking)
        return Lookout(looking.for_kernels(), shares, self._motions, route.fill, times, drives, inputs, states, found)
