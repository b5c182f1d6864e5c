"""The directions in which loads between frames stiffen a linearly implicit sweep: a change of the tree of low rank.

A sweep gives ``x = (M + s C + r K)^-1 (F + (s C + r K) du)`` with the stiffness of modes and joints. That of loads
between frames, see `kanefe.kernels.loads.load_tangents`, is a sum of products of wrenches and rows, so that Newton's
correction of ``du = x`` and ``z = known + p g`` is

    ddu - Z (W ddu + V rest) = du - x,    dz = X ddu + Y rest,    rest = z - known - p g,

where the columns of Z are what the tree answers to the wrenches, a sweep of forces each. Elimination with the largest
pivot of each load finds as many products as its tangents have: of a spring one, and three if it is under tension.
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.constraints.constraint_jacobian import walk_inward
from kanefe.kernels.constraints.row_wrenches import clear_all_forces
from kanefe.kernels.constraints.tree_sweeps import sweep_accelerations, sweep_forces_inward
from kanefe.kernels.force_elements.places import WRENCH, Wrenches
from kanefe.kernels.joints.motion import put_three as put_vector
from kanefe.kernels.joints.motion import three as vector_at
from kanefe.kernels.language import RealRows, Reals, copy, cross, entry, kernel
from kanefe.kernels.loads.acting import COORDINATE, BetweenLoads, acting_in, ends_of, loads_of
from kanefe.kernels.loads.load_tangents import (
    largest_of,
    put_tangents,
    take_off,
    tangent_memory,
    tangent_size,
)
from kanefe.kernels.loads.loads_between import evaluate_load, push_along
from kanefe.kernels.loads.point_and_field_loads import push
from kanefe.kernels.scene import Scene, Sizes, Work, bodies_of, links_of, state_in, work_in
from kanefe.kernels.steppers.step_commands import DirectedStep, StepArrays
from kanefe.kernels.sweeps.elastic import add_along_mode, total
from kanefe.kernels.tables import LoadsBetween
from kanefe.kernels.tree import Kind

NEGLIGIBLE = 1e-12
"""Fraction of the largest tangent of a load below which what is left of them is round-off."""


def directions_memory_size(between: LoadsBetween, speeds: int) -> int:
    """Return how many numbers the memory of `put_directions` has, with so many free and driven speeds."""
    return 2 * speeds + max(tangent_size(load.end_count, load.state_count) for load in BetweenLoads(between.loads))


class Directions(NamedTuple):
    """What directions are written with.

    Attributes
    ----------
    scene : Scene
    work : Work
        Of a linearly implicit evaluation.
    row, reach : ndarray, shape (free + driven,)
    """

    scene: Scene
    work: Work
    row: np.ndarray
    reach: np.ndarray


@entry()
def put_directions(
    scene: Scene, drives: RealRows, inputs: Reals, arrays: StepArrays, memory: Reals, own: Reals
) -> None:
    """Write the rows Z, then those of W and V, then X and Y, from `jacobian_row` on, and how many of the first.

    The state `at` has been evaluated, linearly implicit, with the same `memory`. `own` is of `directions_memory_size`.
    States are followed where `share_of_rates` is above zero.
    """
    step, vectors = DirectedStep(*arrays), arrays.vectors
    work, state = work_in(scene, memory), state_in(scene.tables, step.time_at, step.at, drives, inputs)
    loads, nearness, rank = loads_of(scene), acting_in(scene, work).nearness, 0
    speeds, m, most, first = len(work.applied), len(state.u), step.most_directions, step.jacobian_row
    rest, given = own[2 * speeds :], Directions(scene, work, own[:speeds], own[speeds : 2 * speeds])
    shares = step.share_damping, step.share_stiffness, step.share_of_rates
    Z, W, X = vectors[first : first + most], vectors[first + most : first + 2 * most], vectors[first + 2 * most :]
    for n in range(len(loads)):
        if loads[n].is_swept:
            continue
        followed = loads[n].state_count if shares[2] > 0.0 else 0
        count, states = WRENCH * loads[n].end_count, loads[n].first_state
        if nearness[n] <= 0.0:  # its states decay
            for i in range(states, states + followed):
                X[i] = 0.0
                X[i, m + i] = 1.0 / (1.0 + shares[2] * scene.between.decay_rates[i])
            continue
        evaluate_load(scene, state, work, n, n)
        tangents = tangent_memory(loads[n], followed, rest)
        if not put_tangents(scene, state, work, n, shares, tangents):
            tangents.T[:] = 0.0  # a step between growth and decay: the iteration will not converge, and tells it
        T = tangents.T
        for i in range(followed):
            _put_row(given, n, 1.0, T[count + i], X[states + i])
        largest, a, b = largest_of(T, count)
        least = NEGLIGIBLE * largest
        while largest > least and rank < most:
            _respond(scene, work, n, T[:count, b], Z[rank, :m])
            _put_row(given, n, 1.0 / T[a, b], T[a], W[rank])
            take_off(T, count, a, b)
            rank += 1
            largest, a, b = largest_of(T, count)
    step.rank = rank
    if shares[2] > 0.0:
        _answer_of_arms(scene, work, shares, X)


@kernel
def _answer_of_arms(scene: Scene, work: Work, shares: tuple[float, float, float], X: np.ndarray) -> None:
    """Write the rows X and Y of arms, whose stiffness is that of the sweep."""
    bodies, m = bodies_of(scene, work), Sizes(scene.tables.sizes).free_count
    for f in range(len(bodies)):
        arms = bodies[f].arms
        for i in range(len(arms)):
            arm, row = arms[i], X[int(arms[i].state)]
            share = shares[2] * arm.rate
            row[:] = 0.0
            row[bodies[f].first_deta + int(arm.mode)] = shares[1] * share * arm.pull / (1.0 + share)
            row[m + int(arm.state)] = 1.0 / (1.0 + share)


@kernel
def _respond(scene: Scene, work: Work, n: int, wrenches: np.ndarray, du: np.ndarray) -> None:
    """Write what the tree answers to wrenches on the ends of a load."""
    load, ends, own = loads_of(scene)[n], ends_of(scene), acting_in(scene, work).done[: len(wrenches)]
    copy(wrenches, own)  # a column, whose numbers are not one behind the other
    on = Wrenches(own)
    clear_all_forces(scene, work)
    for i in range(load.end_count):
        end, force = ends[load.first_end + i], on[i].force
        if end.row == COORDINATE:
            push_along(scene, work, end, force.x)
        elif end.row >= 0:
            push(scene, work, end.row, force, on[i].moment + cross(work.frames[end.row].R @ end.point, force))
    sweep_forces_inward(scene, work, True, None)
    sweep_accelerations(scene, work, True, None, du)


@kernel
def _put_row(given: Directions, n: int, share: float, along: np.ndarray, out: np.ndarray) -> None:
    """Write a share of a row over the motions of the ends of a load, and its states, over all unknowns."""
    scene, work, row, bodies = given.scene, given.work, given.row, bodies_of(given.scene, given.work)
    load, ends, on, free = loads_of(scene)[n], ends_of(scene), Wrenches(along), len(row) - len(work.driving)
    count = load.end_count
    row[:] = 0.0
    for i in range(count):
        end, force = ends[load.first_end + i], on[i].force
        if end.row == COORDINATE and end.flexible < 0:
            row[end.speed] += force.x
        elif end.row == COORDINATE:
            body = bodies[end.flexible]
            modes = row[body.first_deta : body.first_deta + body.k]
            add_along_mode(body, end.speed - body.first_deta, force.x, modes)
        elif end.row >= 0:
            moment = on[i].moment + cross(work.frames[end.row].R @ end.point, force)
            walk_inward(scene, work, end.row, (force, moment), row, given.reach)
    _over_speeds(scene, work, row, given.reach)
    out[:] = 0.0
    for i in range(free):
        out[i] = share * row[i]
    states = free + load.first_state
    for i in range(len(along) - WRENCH * count):
        out[states + i] = share * along[WRENCH * count + i]


@kernel
def _over_speeds(scene: Scene, work: Work, row: np.ndarray, found: np.ndarray) -> None:
    """Replace what a row has in N, and of modes of unit mass, by what it has of the speeds."""
    links, frames, bodies = links_of(scene), work.frames, bodies_of(scene, work)
    for i in range(len(links)):
        link = links[i]
        if link.kind == Kind.SPHERICAL or link.kind == Kind.FREE:
            speed = link.speed
            if link.kind == Kind.FREE:
                put_vector(row, speed, link.axes.T @ (frames[link.parent].R.T @ vector_at(row, speed)))
                speed += 3
            put_vector(row, speed, frames[i].R.T @ vector_at(row, speed))
    for f in range(len(bodies)):
        body = bodies[f]
        k, first = body.k, body.first_deta
        if body.transform >= 0:
            transform = body.to_modes
            for j in range(k):
                found[j] = total(transform[j], row[first : first + k])
            copy(found[:k], row[first : first + k])
