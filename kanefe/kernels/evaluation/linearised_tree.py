"""The equations of motion of a tree, linearised row by row: few entries a row, whatever their number.

With accelerations as unknowns beside motions the equations are local. Of each row of the tree are unknown its motion x
(turn, displacement, velocity, angular velocity, accelerations: 18 numbers), the force and moment y that it needs from
its parent, and changes z, du of its own coordinates and speeds, of joint and modes; of loads their internal states:

    x_i - X_i x_parent - G_i (z_i, du_i, g du_i) = 0,          how a row moves by its parent and by itself,
    y_i - K_i x_i - sum over children of y - loads = 0,          what it needs,
    P_i y_i - tau_i (z_i, du_i) + i g du_i = 0                   along its joint, likewise for modes,

where g stands for d/dt. Changes of vectors are those that are seen from the row, which turns: so its turn matters only
to what does not turn with it. All blocks are derivatives of single kernels by complex steps, of all rows at once:
displaced are the motions of the rows as their forces and their children see them, one of 18 numbers in each pass, then
the coordinates and the speeds. So a linearisation costs some twenty evaluations, however many rows there are. The
matrix is ``known + g masses``; in the order of the unknowns, from the tips of the tree inward, its elimination fills in
what couples: nothing beside the tree, and along the paths between ends of loads.

For trees without loops, beams that bend far, points of flexible bodies and loads of joint reactions.
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.bodies import BorderedBody
from kanefe.kernels.compiler.arrays import ValueRows, Values
from kanefe.kernels.evaluation import linear_unknowns
from kanefe.kernels.evaluation.derivatives import COMPLEX_STEP
from kanefe.kernels.evaluation.evaluation import DONE_AS, KEEPS
from kanefe.kernels.evaluation.linear_blocks import put_answer, put_load_changes, put_tree
from kanefe.kernels.evaluation.linear_unknowns import Entries, Linearised, Motions, Needs, Part, Places, Size, Unknowns
from kanefe.kernels.language import (
    COMPLEX,
    IntegerRows,
    Prepared,
    RealRows,
    Reals,
    call_address,
    entry,
    inlined,
    kernel,
)
from kanefe.kernels.loads.acting import acting_in, loads_of
from kanefe.kernels.loads.loads_between import apply_load, evaluate_load
from kanefe.kernels.scene import Scene, bodies_of, links_of, rates_in, state_in, work_in
from kanefe.kernels.steppers.step_commands import VECTOR
from kanefe.kernels.sweeps.elastic import modal_state, total
from kanefe.kernels.tree import Frame, Kind, Link
from kanefe.kernels.values.tensors import ZERO, cross


@inlined
def _sees(of_row: int, of_parent: int) -> bool:
    """Return whether a vector of the motion of a row depends on one of its parent's."""
    if of_parent == Part.TURN:
        return of_row == Part.PLACE
    if of_parent == Part.SPIN:
        return of_row == Part.VELOCITY or of_row == Part.PULL or of_row == Part.TWIST
    return of_parent == Part.TWIST and of_row == Part.PULL


@kernel
def _put_forces(given: Linearised, i: int, column: int) -> None:
    """Put how a displacement changes what a row needs by itself, and what the modes of its body need."""
    work, unknowns, link = given.work, given.unknowns, links_of(given.scene)[i]
    place, frame = Places(unknowns.places)[i], work.frames[i]
    turn = linear_unknowns.vector_of(frame, given.kept[i], Part.TURN)
    linear_unknowns.put_changes(given.known, place.need, column, frame.f - cross(turn, frame.f), -1.0)
    linear_unknowns.put_changes(given.known, place.need + 3, column, frame.n - cross(turn, frame.n), -1.0)
    if place.modes > 0:
        _put_modes(given, bodies_of(given.scene, work)[link.flexible], column)


@kernel
def _put_modes(given: Linearised, body: BorderedBody, column: int) -> None:
    """Put how a displacement changes the forces on the modes, over the coordinates of the body."""
    for j in range(body.k):
        row = given.unknowns.speeds[body.first_deta + j]
        if body.transform < 0:
            linear_unknowns.put_entry(given.known, row, column, -body.p[j].imag / COMPLEX_STEP)
        else:
            linear_unknowns.put_entry(given.known, row, column, -total(body.to_modes[j], body.p).imag / COMPLEX_STEP)


@inlined
def _put_joint(given: Linearised, i: int, parent: Frame, column: int, is_applied: bool) -> None:
    """Put how a displacement changes what is left along the joint of a row: its axes, or what is applied along it."""
    scene, work, unknowns = given.scene, given.work, given.unknowns
    link, need = links_of(scene)[i], given.felt[i]
    for c in range(Places(unknowns.places)[i].joint):
        speed = link.speed + c
        if is_applied:
            left = -work.applied[speed]
        else:
            left = linear_unknowns.along_joint(link, work.frames[i], parent, (need.f, need.n), c)
        linear_unknowns.put_entry(given.known, unknowns.speeds[speed], column, left.imag / COMPLEX_STEP)


@inlined
def _put_felt(given: Linearised, i: int, parent: Frame, column: int) -> None:
    """Put how what the parent of a row needs for it changes as the row is displaced with that."""
    link, felt = links_of(given.scene)[i], given.felt[i]
    if link.parent < 0 or link.kind == Kind.FREE:
        return
    carrier, arm = Places(given.unknowns.places)[link.parent].need, given.work.frames[i].p - parent.p
    linear_unknowns.put_changes(given.known, carrier, column, felt.f, -1.0)
    linear_unknowns.put_changes(given.known, carrier + 3, column, felt.n + cross(arm, felt.f), -1.0)


@inlined
def _is_wet(given: Linearised, i: int) -> bool:
    """Return whether a row has a body in a fluid, whose forces depend on its velocity."""
    link = links_of(given.scene)[i]
    if link.kind == Kind.INTERFACE or link.flexible < 0:
        return False
    return bool(bodies_of(given.scene, given.work)[link.flexible].wet >= 0)


@inlined
def _depends(link: Link, group: int, is_speed: bool) -> bool:
    """Return whether a vector of the motion of a row depends on its own coordinates, or on their speeds."""
    if is_speed and group < Part.VELOCITY:
        return False
    if link.kind == Kind.REVOLUTE or link.kind == Kind.SPHERICAL:
        return group in (Part.SPIN, Part.TWIST) if is_speed else group != Part.PLACE
    return True


@kernel
def _pass_motion(given: Linearised, c: int) -> None:
    """Put how all forces, and the motions of children, change with one number of the motions of the rows."""
    scene, work, places = given.scene, given.work, Places(given.unknowns.places)
    links, frames = links_of(scene), work.frames
    for i in range(len(links)):
        linear_unknowns.restore(frames[i], given.kept[i])
        linear_unknowns.displace(frames[i], c)
    if c // 3 != Part.PLACE:
        linear_unknowns.exert(given, False)
        for i in range(len(links)):
            acts = _is_wet(given, i) if c // 3 == Part.VELOCITY else c // 3 != Part.TURN or places[i].turns
            if acts:
                _put_forces(given, i, places[i].motion + c)
    for i in range(len(links) - 1, -1, -1):  # children first: the motions of their parents are still displaced alone
        link = links[i]
        if link.parent < 0:
            continue
        linear_unknowns.move_row(given, i)
        row, column = places[i].motion, places[link.parent].motion + c
        linear_unknowns.put_entry(given.known, row + c, column, -1.0)
        for part in range(Part.TWIST + 1):
            if _sees(part, c // 3):
                linear_unknowns.put_changes(
                    given.known, row + 3 * part, column, linear_unknowns.vector_of(frames[i], given.kept[i], part), -1.0
                )


@kernel
def _put_own(given: Linearised, i: int, column: int, is_speed: bool, is_joint: bool) -> None:
    """Put how a row moves, and what it and loads on it give its parent, as it is displaced from that."""
    scene, work, unknowns, known, masses = given.scene, given.work, given.unknowns, given.known, given.masses
    link, place, frame = links_of(scene)[i], Places(unknowns.places)[i], work.frames[i]
    for k in range(place.first_load, place.first_load + place.loads):
        put_answer(given, unknowns.inner[k], column, acting_in(scene, work).nearness[unknowns.inner[k]].real > 0.0)
    for part in range(Part.TWIST + 1):
        if _depends(link, part, is_speed):
            x = linear_unknowns.vector_of(frame, given.kept[i], part)
            linear_unknowns.put_changes(known, place.motion + 3 * part, column, x, -1.0)
    if is_speed:  # accelerations change by what changes the speeds as these do by the speeds
        if _depends(link, Part.VELOCITY, True):
            linear_unknowns.put_changes(masses, place.motion + 3 * Part.PULL, column, frame.v, -1.0)
        linear_unknowns.put_changes(masses, place.motion + 3 * Part.TWIST, column, frame.w, -1.0)
        return
    parent = work.frames[link.parent]
    if is_joint:
        _put_joint(given, i, parent, column, False)
    _put_felt(given, i, parent, column)


@kernel
def _pass_own(given: Linearised, moves: np.ndarray, c: int, is_speed: bool) -> None:
    """Put how motions and forces change with the coordinate or the speed number c of each row."""
    scene, state, work, unknowns = given.scene, given.state, given.work, given.unknowns
    links, frames, bodies, places = links_of(scene), work.frames, bodies_of(scene, work), Places(unknowns.places)
    columns = unknowns.speeds if is_speed else unknowns.coordinates
    linear_unknowns.displace_own(given, moves, c, is_speed)
    for f in range(len(bodies)):
        modal_state(bodies[f], state.q, state.u)
    linear_unknowns.restore_all(given)
    for i in range(len(links) - 1, -1, -1):
        need, felt = given.needs[i], given.felt[i]
        linear_unknowns.move_row(given, i)  # its parent is in place
        turn = linear_unknowns.vector_of(frames[i], given.kept[i], Part.TURN)
        felt.f, felt.n = need.f + cross(turn, need.f), need.n + cross(turn, need.n)
        speed = linear_unknowns.own_speed(given, i, c)
        if speed >= 0:
            _put_own(given, i, columns[speed], is_speed, c < places[i].joint)
    linear_unknowns.restore_all(given)
    linear_unknowns.exert(given, True)
    for i in range(len(links)):
        speed = linear_unknowns.own_speed(given, i, c)
        if speed < 0 or links[i].kind == Kind.INTERFACE:
            continue
        if c < places[i].joint:
            _put_joint(given, i, frames[links[i].parent], columns[speed], True)
        else:
            _put_forces(given, i, columns[speed])


@kernel
def _put_needs(given: Linearised) -> None:
    """Write what each row needs with what it carries: as it is, nothing displaced."""
    scene, work, needs, loads = given.scene, given.work, given.needs, loads_of(given.scene)
    links, frames = links_of(scene), work.frames
    for i in range(len(links)):
        needs[i].f, needs[i].n = ZERO + 0.0 * frames[i].p, ZERO + 0.0 * frames[i].p
    linear_unknowns.exert(given, False)
    for n in range(len(loads)):
        if acting_in(scene, work).nearness[n].real > 0.0:
            evaluate_load(scene, given.state, work, n, n)
            apply_load(scene, work, n, n, given.rates.dz)
    for i in range(len(links) - 1, -1, -1):
        link, need = links[i], needs[i]
        need.f, need.n = need.f + frames[i].f, need.n + frames[i].n
        if link.parent >= 0 and link.kind != Kind.FREE:
            carrier = needs[link.parent]
            carrier.f = carrier.f + need.f
            carrier.n = carrier.n + need.n + cross(frames[i].r, need.f)


class Evaluated(NamedTuple):
    """What has been evaluated where equations are linearised.

    Attributes
    ----------
    call : Prepared
        Of `kanefe.kernels.evaluation.evaluation.evaluate` with the first four of these arrays.
    drives, inputs, vectors, memory : ndarray
    own : ndarray
        Of `own_size`.
    moves : ndarray of int, shape (moves, 3)
        Kind, coordinate and speed: how coordinates move.
    """

    call: Prepared
    drives: RealRows
    inputs: Reals
    vectors: ValueRows
    memory: Values
    own: Values
    moves: IntegerRows


@entry(COMPLEX)
def linearise(evaluated: Evaluated, scene: Scene, unknowns: Unknowns, known: Entries, masses: Entries) -> bool:
    """Write the entries of the linearised equations at the state in `vectors`; return whether there are accelerations.

    In the scene every interface carries something, so that forces on it stay there.
    """
    evaluation, drives, inputs, vectors, memory, own, moves = evaluated
    evaluation.places[KEEPS] = False
    call_address(evaluation.address, (evaluation.places, evaluation.numbers))
    known.found[0] = masses.found[0] = 0
    if evaluation.numbers[DONE_AS] < 0.0:
        return False
    work, state = work_in(scene, memory), state_in(scene.tables, 0.0, vectors[VECTOR.at], drives, inputs)
    links, frames, loads, places = links_of(scene), work.frames, loads_of(scene), Places(unknowns.places)
    kept, own_needs = Motions(own), own[len(own) - 2 * Size.NEED * (len(links) + 1) :]
    needs, felt = Needs(own_needs), Needs(own_needs[len(links) * Size.NEED :])
    rates = rates_in(scene.tables, vectors[VECTOR.slope])
    given = Linearised(scene, state, work, rates, unknowns, kept, needs, felt, known, masses)
    most = 0
    for i in range(len(links)):
        frame = frames[i]
        frame.Z, frame.Y = frame.Z + frame.a, frame.Y + frame.alpha
        linear_unknowns.restore(kept[i], frame)
        most = max(most, places[i].joint + places[i].modes)
    _put_needs(given)
    put_tree(given)
    for c in range(Size.MOTION):
        _pass_motion(given, c)
    for c in range(2 * most):
        _pass_own(given, moves, c // 2, c % 2 == 1)
    linear_unknowns.set_real(given)
    linear_unknowns.restore_all(given)
    for n in range(len(loads)):
        put_load_changes(given, n)
    return True
