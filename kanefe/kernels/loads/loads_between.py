"""Loads between frames and along joint coordinates (Eq. 11): ends gathered, functions called, wrenches applied."""

from typing import Any

import numpy as np

from kanefe.kernels.force_elements.places import Done, Ends, Wrenches, done_size, rates_of
from kanefe.kernels.language import Vector, call_address, cross, inlined, kernel, vector_kernel
from kanefe.kernels.loads.acting import COORDINATE, BetweenLoad, LoadEnd, acting_in, ends_of, loads_of
from kanefe.kernels.loads.joint_forces import along
from kanefe.kernels.loads.markers import put_motion
from kanefe.kernels.loads.point_and_field_loads import push
from kanefe.kernels.loads.points import clear_points, gather_points, push_points, put_points, take_shares
from kanefe.kernels.loads.reach import ReachSizes, Team, find_near, teams_of
from kanefe.kernels.scene import Scene, State, Work, bodies_of
from kanefe.kernels.sweeps.elastic import add_along_mode
from kanefe.kernels.tables import LoadsBetween


@inlined
def add_loads_between(scene: Scene, state: State, work: Work, dz: np.ndarray) -> tuple[Any, Any]:
    """Apply loads between frames and write the rates of their states; return the power taken and the power given."""
    between, loads, teams = scene.between, loads_of(scene), teams_of(scene)
    acting, sizes = acting_in(scene, work), ReachSizes(between.reach.sizes)
    nearness, done = acting.nearness, Done(acting.done)
    swept = find_near(scene, work)
    taken = given = 0.0 * work.frames[0].p.x
    for i in range(len(teams) + swept):
        number = i if i < len(teams) else -1
        first = teams[i].first_load if number >= 0 else int(acting.near[i - len(teams)].real)
        last = first + (teams[i].load_count if number >= 0 else 1)
        while first < last and nearness[first].real <= 0.0:
            first += 1
        while first < last and nearness[last - 1].real <= 0.0:
            last -= 1
        if number >= 0:
            taken += decay_beside(scene, teams[i], (first, last), state.z, dz)
        if first == last:
            continue
        gather_points(scene, work, number, first, last)
        for n in range(first, last):
            if nearness[n].real <= 0.0:
                taken += decay_of(between, loads[n], state.z, dz)
                clear_points(scene, work, n, first)
                continue
            evaluate_load(scene, state, work, n, first)
            apply_load(scene, work, n, first, dz)
            taken, given = taken + done.taken, given + done.given
        push_points(scene, work, number, first, last)
    if sizes.has_swept_states:
        for n in range(sizes.first_swept, len(loads)):
            if nearness[n].real <= 0.0:
                taken += decay_of(between, loads[n], state.z, dz)
    return taken, given


@inlined
def decay_beside(scene: Scene, team: Team, acting: tuple[int, int], z: np.ndarray, dz: np.ndarray) -> Any:
    """Do the same as `decay` for the loads of a team before one and from another on, of which none acts."""
    loads, taken = loads_of(scene), 0.0 * z.dtype.type(0.0)
    first, last = acting
    if first == last and team.first_state >= 0:
        return decay(scene.between, team.first_state, team.state_count, z, dz)
    for n in range(team.first_load, team.first_load + team.load_count):
        if first == last or n < first or n >= last:
            taken += decay_of(scene.between, loads[n], z, dz)
    return taken


@inlined
def decay_of(between: LoadsBetween, load: BetweenLoad, z: np.ndarray, dz: np.ndarray) -> Any:
    """Do the same as `decay` for a load."""
    return decay(between, load.first_state, load.state_count, z, dz)


@vector_kernel
def decay(between: LoadsBetween, first: int, count: int, z: np.ndarray, dz: np.ndarray) -> Any:
    """Write the rates of states of loads that do not act; return the power that they take."""
    taken, own, change = z.dtype.type(0.0), z[first:], dz[first:]
    speeds, energies = between.decay_rates[first:], between.decay_energies[first:]
    for i in range(count):
        change[i] = -speeds[i] * own[i]
        taken += 2.0 * speeds[i] * energies[i] * own[i] * own[i]
    return taken


@inlined
def potential_between(scene: Scene, state: State, work: Work) -> Any:
    """Return the energy in loads between frames."""
    loads, acting, z = loads_of(scene), acting_in(scene, work), state.z
    energy = 0.0 * work.frames[0].p.x
    find_near(scene, work)
    for n in range(len(loads)):
        load = loads[n]
        if acting.nearness[n].real > 0.0:
            evaluate_alone(scene, state, work, n)
            energy += Done(acting.done).potential
            continue
        for i in range(load.first_state, load.first_state + load.state_count):
            energy += scene.between.decay_energies[i] * z[i] * z[i]
    return energy


@kernel
def evaluate_alone(scene: Scene, state: State, work: Work, n: int) -> None:
    """Do the same as `evaluate_load` for one whose points have not been gathered."""
    gather_points(scene, work, loads_of(scene)[n].team, n, n + 1)
    evaluate_load(scene, state, work, n, n)


@inlined
def evaluate_load(scene: Scene, state: State, work: Work, n: int, first_gathered: int) -> None:
    """Write the motion of the ends of a load, and what it does: see `Acting`.

    Points have been gathered from those of load `first_gathered` on.
    """
    load, acting, between = loads_of(scene)[n], acting_in(scene, work), scene.between
    put_ends(scene, state, work, load)
    if load.point_count > 0:
        put_points(scene, work, n, first_gathered)
    out = acting.done[: done_size(load.end_count, load.state_count)]
    out[:] = 0.0
    address = load.complex_function if np.iscomplexobj(out) else load.function
    constants, given = between.numbers[load.first_number :], state.inputs[load.first_input :]
    call_address(address, (state.t, constants, given, acting.ends, state.z[load.first_state :], out))


@inlined
def apply_load(scene: Scene, work: Work, n: int, first_gathered: int, dz: np.ndarray) -> None:
    """Apply what a load has written, and write the rates of its states."""
    load, ends, done = loads_of(scene)[n], ends_of(scene), Done(acting_in(scene, work).done)
    wrenches = Wrenches(done.wrenches)
    for i in range(load.end_count):
        end, on = ends[load.first_end + i], wrenches[i]
        if end.row == COORDINATE:
            push_along(scene, work, end, on.force.x)
        elif end.row >= 0:  # not N, which does not move, nor a point
            lever = work.frames[end.row].R @ end.point
            push(scene, work, end.row, on.force, on.moment + cross(lever, on.force))
    if load.point_count > 0:
        take_shares(scene, work, n, first_gathered)
    changes = rates_of(done, load.end_count)
    for i in range(load.state_count):
        dz[load.first_state + i] = changes[i]


@inlined
def push_along(scene: Scene, work: Work, end: LoadEnd, force: Any) -> None:
    """Apply a force along a coordinate of a joint or a mode."""
    if end.flexible < 0:
        work.applied[end.speed] += force
    else:
        body = bodies_of(scene, work)[end.flexible]
        add_along_mode(body, end.speed - body.first_deta, force, body.p)


@inlined
def put_ends(scene: Scene, state: State, work: Work, load: BetweenLoad) -> None:
    """Write the motion of the ends of a load that are no points; of joint coordinates, as x, them and their rates."""
    own, ends = ends_of(scene), Ends(acting_in(scene, work).ends)
    for i in range(load.end_count):
        marker, end = own[load.first_end + i], ends[i]
        if marker.row == COORDINATE:
            position, rate = along(state, marker.coordinate, marker.speed)
            end.p, end.v = Vector(position, 0.0, 0.0), Vector(rate, 0.0, 0.0)
        elif marker.row > COORDINATE:
            put_motion(end, marker, work.frames[marker.row])
