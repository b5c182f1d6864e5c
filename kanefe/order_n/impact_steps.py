"""Steps over the impacts of rigid contacts in compiled code: the calls of the kernel that takes them."""

from __future__ import annotations

from typing import cast

import numpy as np

from kanefe.frames import Vector
from kanefe.kernels.compiler.arrays import NOT_CALLED
from kanefe.kernels.compiler.entries import LATER
from kanefe.kernels.constraints.closing import closing_memory_size
from kanefe.kernels.events.closing_call import ClosingCall
from kanefe.kernels.impacts.decision import decision_of
from kanefe.kernels.impacts.march import ImpactScene, March, Progress
from kanefe.kernels.impacts.moments import ContactScene, look_at_points
from kanefe.kernels.impacts.step_impulses import Tried, closed_points, step_of
from kanefe.kernels.impacts.time_stepping import march_over_impacts
from kanefe.kernels.sweeps.drives import Drives
from kanefe.kernels.values.filled import allocate
from kanefe.order_n.contact_watching import ContactLook
from kanefe.order_n.evaluated import Evaluated
from kanefe.tree.contact_changes import asking_of
from kanefe.tree.contact_steps import Stepped
from kanefe.tree.rigid_points import points_of_contacts


class ImpactSteps:
    """Steps of a scene over its impacts: of one thread at a time.

    Parameters
    ----------
    route : Evaluated
        Of an autonomous scene.
    told : ndarray, shape (5,)
        What steps have told so far, which they change.
    too_deep : float
        Depth that is round-off, m.
    bends : tuple of ndarray
        Integers and reals of bodies whose bending is watched: see `kanefe.kernels.evaluation.bending`.
    """

    def __init__(self, route: Evaluated, told: Vector, too_deep: float, bends: tuple[np.ndarray, np.ndarray]) -> None:
        self._route, model, look = route, route.model, ContactLook(route)
        size, driven, tables = look.vectors.shape[1], len(model.drives), (route.tables, route.flexible, route.loops)
        self._held, motions = route.inputs.constants.copy(), cast(Drives, route.motion_tables)
        points, at = route.loops.points, np.zeros(size)
        decision = decision_of(len(points.places), model.free_count, size)
        scene = ContactScene(look.looked, route.loops, route.tables, route.flexible, motions, route.fill, self._held)
        looking = look_at_points.bound(scene, decision, at).prepared()
        asking = asking_of(points, looking, decision, look.looked.first_state)
        drives, closed, call = np.empty((driven, 3)), np.empty(size), NOT_CALLED
        if model.constraints:
            call = route.closing.prepared(0.0, drives, closed, np.empty(closing_memory_size(route.scene))).for_kernels()
        closing = ClosingCall(bool(model.constraints), call, motions, drives, closed)
        integers, reals = allocate(Progress)
        self._step = step_of(points, decision.problem, asking.solving, decision.now.G)
        (self._old, self._new, self._tried), self._progress = np.zeros((3, size)), Progress(integers, reals)
        self._progress.too_deep = too_deep
        march = March(integers, reals, told, self._old, self._new, self._tried, self._step, at, *bends)
        impacts = ImpactScene(asking, look.looked, closing, *tables)
        self._marching = march_over_impacts.bound(impacts, decision, march, LATER, LATER)

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
        at = self._progress
        at.most, at.steps, at.passed = min(most, 2**40), 0, 0
        at.time, at.time_old, at.length, at.stop = t, t, length, stop
        self._new[:] = self._old[:] = y
        self._held[:] = self._route.inputs.begun(self._route.parts(y)[2])
        return self._marching(times, states), at.steps, at.passed

    @property
    def last(self) -> tuple[float, Vector, float, Vector]:
        """Times (s) and states between which the last step went."""
        at = self._progress
        return float(at.time_old), self._old.copy(), float(at.time), self._new.copy()

    @property
    def tried(self) -> Stepped:
        """What the step that was not taken was to lead to."""
        closed, keys = closed_points(self._step), points_of_contacts(self._route.model)
        pushes = np.array([one.impulse.numbers for one in closed]).ravel()
        told = Tried(self._step.tried, self._step.told)
        depth, left, approach, bend = (float(one) for one in (told.depth, told.residual, told.approach, told.bend))
        pressed, y = [keys[one.point] for one in closed], self._tried.copy()
        return Stepped(y, pushes, pressed, depth, left, approach, bend, int(told.lowered))
