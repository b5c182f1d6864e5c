"""Steps over the impacts of rigid contacts in compiled code: the calls of the kernel that takes them."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np

from kanefe.frames import Vector
from kanefe.kernels.compiler.arrays import NOT_CALLED
from kanefe.kernels.compiler.entries import LATER
from kanefe.kernels.constraints.closing import closing_memory_size
from kanefe.kernels.contact.rigid_points import CONTACT
from kanefe.kernels.events.closing_call import ClosingCall
from kanefe.kernels.impacts.cones import solve_one
from kanefe.kernels.impacts.decision import TAKES, Asking, decision_of
from kanefe.kernels.impacts.march import (
    CLOSED,
    IMPULSE,
    INTEGERS,
    LENGTH,
    MOST,
    NEW,
    NEXT,
    OLD,
    OWN_DEPTH,
    OWN_LOWERED,
    PASSED,
    REALS,
    STEPS,
    STOP,
    TIME,
    TIME_OLD,
    TOO_DEEP,
    VECTORS,
    ImpactScene,
    March,
)
from kanefe.kernels.impacts.moments import look_at_points
from kanefe.kernels.impacts.time_stepping import march_over_impacts
from kanefe.kernels.sweeps.drives import Drives
from kanefe.order_n.contact_watching import ContactLook
from kanefe.order_n.evaluated import Evaluated

if TYPE_CHECKING:
    from kanefe.kane.rigid_contacts.time_stepping import Stepped


class ImpactSteps:
    """Steps of a scene over its impacts: of one thread at a time.

    Parameters
    ----------
    route : Evaluated
        Of an autonomous scene.
    told : ndarray, shape (TOLD,)
        What steps have told so far, which they change.
    too_deep : float
        Depth that is round-off, m.
    bends : tuple of ndarray
        Integers and reals of bodies whose bending is watched: see `kanefe.kernels.evaluation.bending`.
    """

    def __init__(self, route: Evaluated, told: Vector, too_deep: float, bends: tuple[np.ndarray, np.ndarray]) -> None:
        self._route, model, look = route, route.model, ContactLook(route)
        size, points, driven = look.vectors.shape[1], len(route.loops.points.places), len(model.drives)
        self._held, at = route.inputs.constants.copy(), np.zeros(size)
        motions, tables = cast(Drives, route.motion_tables), (route.tables, route.flexible, route.loops)
        self._decision = decision = decision_of(points, model.free_count, size)
        scene = look.looked, route.loops, route.tables, route.flexible, motions, route.fill, self._held
        looking, wanted = look_at_points.bound(*scene, decision, at).prepared(), np.zeros(5)
        solving = solve_one.bound(decision.problem, decision.ahead, decision.vectors, wanted).prepared()
        calls = looking.for_kernels(), solving.for_kernels()
        asking = Asking(route.loops.points, *calls, wanted, look.looked.first_state)
        drives, closed, call = np.empty((driven, 3)), np.empty(size), NOT_CALLED
        if model.constraints:
            call = route.closing.prepared(0.0, drives, closed, np.empty(closing_memory_size(route.scene))).for_kernels()
        closing = ClosingCall(bool(model.constraints), call, motions, drives, closed)
        memory = np.zeros(INTEGERS, dtype=np.int64), np.zeros(REALS), told
        self._march = March(*memory, np.zeros((3, size)), np.zeros((VECTORS, 3 * points)), at, *bends)
        self._march.reals[TOO_DEEP] = too_deep
        impacts = ImpactScene(asking, look.looked, closing, *tables)
        self._marching = march_over_impacts.bound(impacts, decision, self._march, LATER, LATER)

    def go_on(
        self, t: float, y: Vector, length: float, stop: float, most: int, times: np.ndarray, states: np.ndarray
    ) -> tuple[int, int, int]:
        """Take steps; return how they end, how many were taken, and how many times were passed.

        Parameters
        ----------
        t : float
            Where they begin, s.
        y : ndarray, shape (state,)
        length, stop : float
            Of each, and where the last one ends at the latest, s.
        most : int
        times, states : ndarray
            Of outputs: see `Stepper.integrate_through`.
        """
        integers, reals, ends = self._march.integers, self._march.reals, self._march.ends
        integers[:] = 0
        integers[MOST], reals[TIME], reals[TIME_OLD] = min(most, 2**40), t, t
        reals[LENGTH], reals[STOP], ends[NEW], ends[OLD] = length, stop, y, y
        self._held[:] = self._route.inputs.begun(self._route.parts(y)[2])
        ended = self._marching(times, states)
        return ended, int(integers[STEPS]), int(integers[PASSED])

    @property
    def last(self) -> tuple[float, Vector, float, Vector]:
        """Times (s) and states between which the last step went."""
        reals, ends = self._march.reals, self._march.ends
        return float(reals[TIME_OLD]), ends[OLD].copy(), float(reals[TIME]), ends[NEW].copy()

    @property
    def tried(self) -> Stepped:
        """What the step that was not taken was to lead to."""
        from kanefe.kane.rigid_contacts.time_stepping import Stepped

        count, places, reals = int(self._march.integers[CLOSED]), self._route.loops.points.places, self._march.reals
        points, pushes = self._decision.flags[TAKES, :count].tolist(), self._march.vectors[IMPULSE, : 3 * count].copy()
        closed = [(int(places[p, CONTACT]), int(np.sum(places[:p, CONTACT] == places[p, CONTACT]))) for p in points]
        depth, left, approach, bend, lowered = reals[OWN_DEPTH : OWN_LOWERED + 1].tolist()
        y = self._march.ends[NEXT].copy()
        return Stepped(y, pushes, depth, left, closed, approach, bend, int(lowered))
