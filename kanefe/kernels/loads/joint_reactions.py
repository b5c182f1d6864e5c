"""Reactions of joints, and loads of joints that follow them: friction from a joint's own load."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.force_elements.coordinate_friction import FrictionNumbers, put_load_rates
from kanefe.kernels.force_elements.places import WRENCH, Wrenches
from kanefe.kernels.loads.loads_between import put_coordinates
from kanefe.kernels.loads.loads_layout import FIRST_NUMBER, FIRST_STATE, STATE_COUNT, place_of_load
from kanefe.kernels.scene import Scene, State, Work
from kanefe.kernels.values.records import Record, Rows
from kanefe.kernels.values.tensors import Vector, cross

REACTION = WRENCH


class Bearing(Record):
    """A joint whose load is followed.

    Attributes
    ----------
    load : int
        Number of the load that follows it.
    row : int
        Of the joint's body.
    has_moment : bool
        Whether moments count.
    place, axis : Vector
        Origin of the body's frame, and the axis of the joint, in axes of the row.
    """

    load: int
    row: int
    has_moment: bool
    place: Vector
    axis: Vector


class Bearings(Rows[Bearing]):
    """All joints whose load is followed."""


@kernel
def add_reactions(scene: Scene, work: Work) -> None:
    """Add what joints exert on their bodies, about the origins of rows in N, after a sweep of accelerations.

    Accelerations are linear in forces, so that reactions of several sweeps add up. Moments that do not
    count are left out.
    """
    between, frames, found = scene.between, work.frames, Wrenches(work.reactions)
    bearings = Bearings(between.bearings, between.bearing_places)
    for b in range(len(bearings)):
        frame, on = frames[bearings[b].row], found[b]
        on.force += frame.f + frame.M @ frame.a + frame.H @ frame.alpha
        if bearings[b].has_moment:
            on.moment += frame.n + frame.H.T @ frame.a + frame.J @ frame.alpha


@kernel
def follow_reactions(scene: Scene, state: State, work: Work, rates: np.ndarray) -> None:
    """Write the rates of the loads that follow reactions of joints."""
    between, frames, found = scene.between, work.frames, Wrenches(work.reactions)
    bearings, workspace, states = Bearings(between.bearings, between.bearing_places), work.acting, state.z
    for b in range(len(bearings)):
        bearing, n = bearings[b], bearings[b].load
        axes, force, moment = frames[bearing.row].R, found[b].force, found[b].moment
        if bearing.has_moment:
            moment -= cross(axes @ bearing.place, force)
        put_coordinates(scene, state, work, n)
        first, numbers = between.loads[n, FIRST_STATE], between.numbers[between.loads[n, FIRST_NUMBER] :]
        own, ends = slice(first, first + between.loads[n, STATE_COUNT]), workspace[place_of_load(between) :]
        law = FrictionNumbers(numbers)
        put_load_rates(law, axes @ bearing.axis, (force, moment), ends, states[own], rates[own])
