"""Reactions of joints, and loads of joints that follow them: friction from a joint's own load."""

import numpy as np

from kanefe.kernels.force_elements.coordinate_friction import FrictionNumbers, put_load_rates
from kanefe.kernels.force_elements.places import Wrenches
from kanefe.kernels.language import Record, Rows, Vector, cross, inlined, kernel
from kanefe.kernels.loads.acting import acting_in, loads_of
from kanefe.kernels.loads.loads_between import put_ends
from kanefe.kernels.scene import Scene, State, Work


class Bearing(Record):
    """A joint whose load is followed."""

    load: int  # number of the load that follows it
    row: int  # of the joint's body
    has_moment: bool  # whether moments count
    place: Vector  # origin of the body's frame, and the axis of the joint, in axes of the row
    axis: Vector


class Bearings(Rows[Bearing]):
    """All joints whose load is followed."""


@kernel
def add_reactions(scene: Scene, work: Work) -> None:
    """Add what joints exert on their bodies, about the origins of rows in N, after a sweep of accelerations.

    Accelerations are linear in forces, so that reactions of several sweeps add up. Moments that do not count are left
    out.
    """
    bearings, found = bearings_of(scene), Wrenches(work.reactions)
    for b in range(len(bearings)):
        frame, on = work.frames[bearings[b].row], found[b]
        on.force += frame.f + frame.M @ frame.a + frame.H @ frame.alpha
        if bearings[b].has_moment:
            on.moment += frame.n + frame.H.T @ frame.a + frame.J @ frame.alpha


@kernel
def follow_reactions(scene: Scene, state: State, work: Work, dz: np.ndarray) -> None:
    """Write the rates of the loads that follow reactions of joints."""
    bearings, loads, found = bearings_of(scene), loads_of(scene), Wrenches(work.reactions)
    for b in range(len(bearings)):
        bearing, load = bearings[b], loads[bearings[b].load]
        axes, force, moment = work.frames[bearing.row].R, found[b].force, found[b].moment
        if bearing.has_moment:
            moment -= cross(axes @ bearing.place, force)
        put_ends(scene, state, work, load)
        law, ends = FrictionNumbers(scene.between.numbers, load.first_number), acting_in(scene, work).ends
        own = slice(load.first_state, load.first_state + load.state_count)
        put_load_rates(law, axes @ bearing.axis, (force, moment), ends, state.z[own], dz[own])


@inlined
def bearings_of(scene: Scene) -> Bearings:
    """Return all joints whose load is followed."""
    return Bearings(scene.between.bearings, scene.between.bearing_places)
