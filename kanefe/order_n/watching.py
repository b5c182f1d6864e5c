"""Events of loads that have kernels for their values: these values in some states from one call."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from kanefe.frames import Matrix
from kanefe.kernels.compiler.entries import LATER, Bound, Call
from kanefe.kernels.constraints.contact_margins import LeastMargins
from kanefe.kernels.constraints.loop_tables import no_loops
from kanefe.kernels.evaluation.evaluation import scene_of
from kanefe.kernels.loads.reach import ReachSizes
from kanefe.kernels.loads.telling import States
from kanefe.kernels.loads.watching import NEAR, Looks, WatchedLoads, WatchWork, watch_states
from kanefe.kernels.scene import memory_size
from kanefe.order_n.contact_watching import COLUMNS, watching_call, watching_contacts
from kanefe.order_n.evaluated import Evaluated
from kanefe.order_n.tables.load_tables import watched_loads
from kanefe.order_n.tables.reach_tables import far_values

NO_CHANGE = np.array((-1, 0, 0, 0))
"""Argument `changing` of `watch_states` for a call that looks at values."""

ALL_NEAR = np.array((NEAR,))
"""Argument `only` of `watch_states` for a call that looks at what comes near."""


class Watching:
    """Event values of loads; several threads may use it.

    Parameters
    ----------
    route : Evaluated

    Attributes
    ----------
    columns : dict of int to slice
        Of the values of each load that is watched so, by its number in the model.
    rows : dict of int to int
        Number in the tables of the kernel of each load that is watched so.
    contact_columns : dict of str to int
        Of the margins of rigid contacts, behind them.
    """

    def __init__(self, route: Evaluated) -> None:
        self._route = route
        between, numbers = watched_loads(route.places)
        paths = {"watched_count": len(between.loads), "swept_ball_count": ReachSizes(between.reach.sizes).swept_balls}
        self._scene = scene_of(route.tables, route.flexible, between, no_loops(), WatchWork, **paths)
        counts = [len(route.model.loads[i].events) for i in numbers]
        ends = np.cumsum(counts, dtype=np.int64)
        self._counts = np.array(counts, dtype=np.int64)
        self._far = np.concatenate((*(far_values(route.places, i) for i in numbers), np.zeros((0, 2))))
        width = int(self._counts.sum())
        self.contact_columns = {kind: width + at for kind, at in COLUMNS.items()} if route.model.rigid_contacts else {}
        self._width = width + (LeastMargins.number_count if self.contact_columns else 0)
        self.rows = {number: row for row, number in enumerate(numbers)}
        has_inputs = any(number in self.rows for _, number in route.inputs.between)
        self._needs_inputs = has_inputs or bool(route.model.rigid_contacts)  # forces of these depend on all loads
        self.columns = {i: slice(int(end) - n, int(end)) for i, end, n in zip(numbers, ends, counts, strict=True)}

    def values(self, times: np.ndarray, states: Matrix, only: int = NEAR) -> Matrix:
        """Return the values at times (T,) and states (T, n) that begin with q, u and z, (T, values).

        Of several states those of loads that come nowhere near are estimates, if not all loads are looked at.
        """
        route = self._route
        drives = route.drives_over(times)
        if self._needs_inputs:
            inputs = route.values_over(times, states)
        else:  # what else is given by functions of the user pushes, and is not looked at
            inputs = np.repeat(route.inputs.constants[None], len(times), axis=0)
        given = np.ascontiguousarray(times), drives, inputs, np.ascontiguousarray(states)
        call, found, _ = self.prepared(*given, only=np.array((only,)))
        call()
        return found

    def prepared(
        self,
        times: np.ndarray,
        drives: np.ndarray,
        inputs: np.ndarray,
        states: Matrix,
        change: np.ndarray = NO_CHANGE,
        only: np.ndarray = ALL_NEAR,
    ) -> tuple[Call, Matrix, np.ndarray]:
        """Return the call of the kernel with arrays that stay where they are, and where it writes values and `near`."""
        route = self._route
        found, near = np.empty((len(times), self._width)), np.zeros(len(self.rows))
        given = States(times, drives, inputs, states)
        if self.contact_columns and not self.columns:
            return watching_call(route, self._of_contacts, None, given, found), found, near
        memory, looks = np.empty(memory_size(self._scene)), Looks(change, only, found, near)
        of_loads = self._bound.prepared(given, looks, memory)
        if not self.contact_columns:
            return of_loads, found, near
        return watching_call(route, self._of_contacts, of_loads, given, found), found, near

    @cached_property
    def _of_contacts(self) -> Bound:
        return watching_contacts(self._route)

    @cached_property
    def _bound(self) -> Bound:
        return watch_states.bound(self._scene, WatchedLoads(self._counts, self._far), *(LATER,) * 3)
