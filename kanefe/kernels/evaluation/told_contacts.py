"""Outputs of rigid contacts in a state, as a whole and point by point."""

from kanefe.kernels.constraints.loop_tables import RowWork, head_of
from kanefe.kernels.contact.output_places import ContactsOutputs, PointOutputs, PointsOutputs, Status
from kanefe.kernels.contact.rigid_points import RigidStates, given_points, is_closed, is_slipping, meet
from kanefe.kernels.language import ZERO, inlined, kernel, norm
from kanefe.kernels.scene import Scene, State, Work


@kernel
def tell_contacts(
    scene: Scene, state: State, work: Work, kept: RowWork, of_contacts: ContactsOutputs, of_points: PointsOutputs
) -> None:
    """Write the outputs of each contact, and of each of its points.

    Parameters
    ----------
    work : Work
        Its multipliers of contact points are the last ones.
    kept : RowWork
        Of what touches; how open points meet their surfaces is written here.
    of_contacts, of_points : Rows
    """
    points, p = given_points(scene.loops.points), 0
    while p < len(points):
        first, nearest, told = p, p, of_contacts[points[p].contact]
        told.force = friction = moved = ZERO
        told.pressed, told.status = 0.0, 0.0 + Status.OPEN.value
        while p < len(points) and points[p].contact == points[first].contact:
            own, met = of_points[p], kept.met[p]
            tell_point(scene, state, work, kept, p, own)
            if is_closed(points[p], state.z):
                rubbed = met.surface @ own.rubbed
                told.pressed += own.pressed
                told.status = max(told.status, own.status)
                told.force += own.pressed * met.normal + rubbed
                friction, moved = friction + rubbed, moved + own.pressed * met.point
            if met.gap < kept.met[nearest].gap:
                nearest = p
            p += 1
        states = RigidStates(state.z, points[first].first_state)
        told.rubbed, told.depth, told.slip, told.work = norm(friction), -kept.met[nearest].gap, states.slip, states.work
        told.place = (1.0 / told.pressed) * moved if told.pressed > 0.0 else kept.met[nearest].point


@inlined
def tell_point(scene: Scene, state: State, work: Work, kept: RowWork, p: int, told: PointOutputs) -> None:
    """Write the outputs of a point."""
    points, met, j = scene.loops.points, kept.met[p], head_of(scene.loops, p)
    given, forces = given_points(points)[p], work.multipliers
    told.pressed, told.rubbed, told.stretch, told.slip, told.status = 0.0, ZERO, ZERO, ZERO, 0.0 + Status.OPEN.value
    if not is_closed(given, state.z):
        meet(given, points.shapes, work.frames, met)
    else:
        friction, told.status = forces[j + 1] * met.first + forces[j + 2] * met.second, 0.0 + Status.STICKS.value
        if is_slipping(given, state.z):
            friction, told.status = forces[j] * met.tangential, 0.0 + Status.SLIPS.value
            told.slip = met.surface.T @ (met.rates.y * met.first + met.rates.z * met.second)
        told.pressed, told.rubbed = forces[j], met.surface.T @ friction
    told.depth = -met.gap
