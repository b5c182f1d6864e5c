"""Loads between frames and along joint coordinates (Eq. 11): ends gathered, functions called, wrenches applied."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import cross, plus, put_three, three
from kanefe.kernels.compiler._numba import inlined, vector_kernel
from kanefe.kernels.compiler.calls import call_address
from kanefe.kernels.force_elements.places import (
    END_NUMBERS,
    GIVEN,
    POTENTIAL,
    TAKEN,
    WRENCH,
    WRENCHES,
    A,
    P,
    V,
    W,
)
from kanefe.kernels.loads.loads_layout import (
    A_POINT,
    AT,
    COMPLEX,
    COORDINATE,
    END_COUNT,
    FIRST_END,
    FIRST_NUMBER,
    FIRST_STATE,
    INPUT,
    POINT_COUNT,
    REAL,
    SPEED,
    STATE_COUNT,
    TEAM,
    place_of_load,
    span_of_load,
)
from kanefe.kernels.loads.markers import axes_of, lever_of, motion_of
from kanefe.kernels.loads.point_and_field_loads import push
from kanefe.kernels.loads.points import clear_points, gather_points, push_points, put_points, take_shares
from kanefe.kernels.loads.reach import (
    FIRST_LOAD,
    FIRST_STATE_OF_TEAM,
    FIRST_SWEPT,
    HAS_SWEPT_STATES,
    LOADS,
    STATES_OF_TEAM,
    find_near,
    near_load,
    nearness_at,
)
from kanefe.kernels.scene import Scene, State, Work
from kanefe.kernels.tables import LoadsBetween


@inlined
def add_loads_between(scene: Scene, state: State, work: Work, rates: np.ndarray) -> tuple[Any, Any]:
    """Apply loads between frames and write the rates of their states; return the power taken and the power given."""
    between, workspace, states = scene.between, work.acting, state.z
    taken = given = 0.0 * work.frames[0].p.x
    reach = between.reach
    swept = find_near(scene, work)
    nearness = workspace[nearness_at(reach) :]
    teams = len(reach.teams)
    for i in range(teams + swept):
        team = i if i < teams else -1
        first = reach.teams[i, FIRST_LOAD] if i < teams else near_load(reach, i - teams, workspace)
        last = first + (reach.teams[i, LOADS] if i < teams else 1)
        while first < last and nearness[first].real <= 0.0:
            first += 1
        while first < last and nearness[last - 1].real <= 0.0:
            last -= 1
        if i < teams:
            taken += decay_beside(between, team, first, last, states, rates)
        if first == last:
            continue
        gather_points(scene, work, team, first, last)
        for n in range(first, last):
            if nearness[n].real <= 0.0:
                taken += decay(between, between.loads[n, FIRST_STATE], between.loads[n, STATE_COUNT], states, rates)
                clear_points(between, n, first, workspace)
                continue
            evaluate_load(scene, state, work, n, first)
            apply_load(scene, work, n, first, rates)
            out = place_of_load(between) + END_NUMBERS * between.loads[n, END_COUNT]
            taken, given = taken + workspace[out + TAKEN], given + workspace[out + GIVEN]
        push_points(scene, work, team, first, last)
    if reach.sizes[HAS_SWEPT_STATES]:
        for n in range(reach.sizes[FIRST_SWEPT], len(between.loads)):
            if nearness[n].real <= 0.0:
                taken += decay(between, between.loads[n, FIRST_STATE], between.loads[n, STATE_COUNT], states, rates)
    return taken, given


@inlined
def decay_beside(between: LoadsBetween, team: int, first: int, last: int, states: np.ndarray, rates: np.ndarray) -> Any:
    """Do the same as `decay` for the loads of a team before one and from another on, of which none acts."""
    teams, taken = between.reach.teams, 0.0 * states.dtype.type(0.0)
    begin, end = teams[team, FIRST_LOAD], teams[team, FIRST_LOAD] + teams[team, LOADS]
    if first == last and teams[team, FIRST_STATE_OF_TEAM] >= 0:
        return decay(between, teams[team, FIRST_STATE_OF_TEAM], teams[team, STATES_OF_TEAM], states, rates)
    for n in range(begin, end):
        if first == last or n < first or n >= last:
            taken += decay(between, between.loads[n, FIRST_STATE], between.loads[n, STATE_COUNT], states, rates)
    return taken


@vector_kernel
def decay(between: LoadsBetween, first: int, count: int, states: np.ndarray, rates: np.ndarray) -> Any:
    """Write the rates of states of loads that do not act; return the power that they take."""
    taken, z, change = states.dtype.type(0.0), states[first:], rates[first:]
    speeds, energies = between.decay_rates[first:], between.decay_energies[first:]
    for i in range(count):
        change[i] = -speeds[i] * z[i]
        taken += 2.0 * speeds[i] * energies[i] * z[i] * z[i]
    return taken


@inlined
def potential_between(scene: Scene, state: State, work: Work) -> Any:
    """Return the energy in loads between frames."""
    between, workspace, states = scene.between, work.acting, state.z
    energy = 0.0 * work.frames[0].p.x
    find_near(scene, work)
    nearness = workspace[nearness_at(between.reach) :]
    for n in range(len(between.loads)):
        if nearness[n].real > 0.0:
            gather_points(scene, work, between.loads[n, TEAM], n, n + 1)
            evaluate_load(scene, state, work, n, n)
            energy += workspace[place_of_load(between) + END_NUMBERS * between.loads[n, END_COUNT] + POTENTIAL]
            continue
        first = between.loads[n, FIRST_STATE]
        for i in range(first, first + between.loads[n, STATE_COUNT]):
            energy += between.decay_energies[i] * states[i] * states[i]
    return energy


@inlined
def evaluate_load(scene: Scene, state: State, work: Work, n: int, first_gathered: int) -> None:
    """Write the motion of the ends of a load, and what it does: see `kanefe.kernels.force_elements.places`.

    Points have been gathered from those of load `first_gathered` on.
    """
    between, workspace, rows = scene.between, work.acting, work.frames.numbers
    first, count = between.loads[n, FIRST_END], between.loads[n, END_COUNT]
    ends, out = workspace[place_of_load(between) :], workspace[span_of_load(between, n)]
    for i in range(count):
        row, at = between.rows[first + i], END_NUMBERS * i
        if row == COORDINATE:
            put_coordinate(between.markers[first + i], state, ends[at : at + END_NUMBERS])
            continue
        if row == A_POINT:
            continue
        p, v, w = motion_of(row, lever_of(between.markers, first + i, row, rows), rows)
        axes = axes_of(between.markers, first + i, row, rows)
        put_three(ends, at + P, p)
        for c in range(9):
            ends[at + A + c] = axes[c]
        put_three(ends, at + V, v)
        put_three(ends, at + W, w)
    if between.loads[n, POINT_COUNT] > 0:
        put_points(scene, work, n, first_gathered)
    out[:] = 0.0
    address = between.addresses[n, COMPLEX if np.iscomplexobj(rows) else REAL]
    own = between.numbers[between.loads[n, FIRST_NUMBER] :]
    given, z = state.inputs[between.loads[n, INPUT] :], state.z[between.loads[n, FIRST_STATE] :]
    call_address(address, (state.t, own, given, ends, z, out))


@inlined
def apply_load(scene: Scene, work: Work, n: int, first_gathered: int, rates: np.ndarray) -> None:
    """Apply what a load has written, and write the rates of its states."""
    between = scene.between
    first, count = between.loads[n, FIRST_END], between.loads[n, END_COUNT]
    out = work.acting[span_of_load(between, n)]
    for i in range(count):
        row = between.rows[first + i]
        if row == COORDINATE:
            work.applied[int(between.markers[first + i, SPEED])] += out[WRENCHES + WRENCH * i]
            continue
        if row < 0:  # N, which does not move, or a point
            continue
        force, moment = three(out, WRENCHES + WRENCH * i), three(out, WRENCHES + WRENCH * i + 3)
        lever = lever_of(between.markers, first + i, row, work.frames.numbers)
        push(scene, work, row, force, plus(moment, cross(lever, force)))
    if between.loads[n, POINT_COUNT] > 0:
        take_shares(scene, work, n, first_gathered)
    of_states = between.loads[n, FIRST_STATE]
    for i in range(between.loads[n, STATE_COUNT]):
        rates[of_states + i] = out[WRENCHES + WRENCH * count + i]


@inlined
def put_coordinates(scene: Scene, state: State, work: Work, n: int) -> None:
    """Write the motion of the ends of a load that is along joint coordinates alone."""
    between = scene.between
    ends, first = work.acting[place_of_load(between) :], between.loads[n, FIRST_END]
    for i in range(between.loads[n, END_COUNT]):
        at = END_NUMBERS * i
        put_coordinate(between.markers[first + i], state, ends[at : at + END_NUMBERS])


@inlined
def put_coordinate(marker: np.ndarray, state: State, end: np.ndarray) -> None:
    """Write a joint coordinate as the motion of an end: it and its rate, x of position and velocity."""
    at = int(marker[AT])
    if at >= 0:
        end[P], end[V] = state.q[at], state.u[int(marker[SPEED])]
    else:
        end[P], end[V] = state.drives[-1 - at, 0], state.drives[-1 - at, 1]
