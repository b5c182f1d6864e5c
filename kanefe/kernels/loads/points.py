"""Points of a flexible body at which loads act: their motion and their forces on the modes, all of them at once.

They have no rows: nothing of them is computed where no load acts. The motion of the points of loads beside each other
is one product with eta and one with deta, and their forces come to the modes by the transpose of it.
"""

import numpy as np

from kanefe.kernels.force_elements.places import Done, Ends, Wrenches
from kanefe.kernels.joints.motion import put_three, three
from kanefe.kernels.language import ZERO, Matrix, Record, Rows, cross, inlined, vector_kernel
from kanefe.kernels.loads.acting import acting_in, ends_of, loads_of
from kanefe.kernels.loads.reach import Team, teams_of
from kanefe.kernels.scene import FlexibleSizes, Scene, Work, bodies_of
from kanefe.kernels.sweeps.elastic import transposed_product
from kanefe.kernels.sweeps.slopes import slope_motion


class Tangent(Record):
    """How the slopes of a point turn it.

    Attributes
    ----------
    T : Matrix
        From their rates to an angular velocity, in G.
    """

    T: Matrix


class Tangents(Rows[Tangent]):
    """Those of the points of a team, in a list."""


@inlined
def width_of(team: Team) -> int:
    """Return how many numbers the motion of a point has."""
    return 6 if team.turns else 3


@inlined
def span_of_points(scene: Scene, number: int, first: int, last: int) -> tuple[int, int]:
    """Return where the motion of the points of loads beside each other begins in their team, and how long it is."""
    loads, width = loads_of(scene), width_of(teams_of(scene)[number])
    begin, end = loads[first].first_point, loads[last - 1].first_point + loads[last - 1].point_count
    return width * begin, width * (end - begin)


@inlined
def has_points(scene: Scene, number: int) -> bool:
    """Return whether a team has points; -1: of a load that is in none."""
    return number >= 0 and teams_of(scene)[number].body >= 0


@inlined
def gather_points(scene: Scene, work: Work, number: int, first: int, last: int) -> None:
    """Write displacements and rates of the points of loads of a team beside each other."""
    if has_points(scene, number):
        team, acting = teams_of(scene)[number], acting_in(scene, work)
        body, (begin, size) = bodies_of(scene, work)[team.body], span_of_points(scene, number, first, last)
        transposed_product(team.basis, begin, body.eta, acting.shifts[:size])
        transposed_product(team.basis, begin, body.deta, acting.rates[:size])


@inlined
def put_points(scene: Scene, work: Work, n: int, first_gathered: int) -> None:
    """Write the motion of the points of a load as its ends."""
    loads, acting = loads_of(scene), acting_in(scene, work)
    load, team = loads[n], teams_of(scene)[loads[n].team]
    width, skipped, markers = width_of(team), load.first_point - loads[first_gathered].first_point, ends_of(scene)
    frame, places = work.frames[bodies_of(scene, work)[team.body].link], team.places
    shifts, rates, ends = acting.shifts, acting.rates, Ends(acting.ends)
    for e in range(load.point_count):
        at, end, G = width * (skipped + e), ends[load.point_end + e], frame.R
        lever = G @ (places[load.first_point + e] + three(shifts, at))
        end.p, end.A, end.w = frame.p + lever, G, frame.w
        end.v = frame.v + cross(frame.w, lever) + G @ three(rates, at)
        if team.turns:
            slope_rates, slopes = three(rates, at + 3), three(shifts, at + 3)
            turn, T, _ = slope_motion(FlexibleSizes(scene.flexible.sizes).measure, slopes, slope_rates)
            Tangents(acting.tangents)[skipped + e].T = T
            end.A, end.w = G @ turn, frame.w + G @ (T @ slope_rates)
        if not team.is_plain:
            marker = markers[load.first_end + load.point_end + e]
            arm = end.A @ marker.point
            end.p, end.v, end.A = end.p + arm, end.v + cross(end.w, arm), end.A @ marker.axes


@inlined
def take_shares(scene: Scene, work: Work, n: int, first_gathered: int) -> None:
    """Apply forces at the points of a load to their body, and write them, in G, in the place of displacements."""
    loads, acting = loads_of(scene), acting_in(scene, work)
    load, team = loads[n], teams_of(scene)[loads[n].team]
    width, skipped, markers = width_of(team), load.first_point - loads[first_gathered].first_point, ends_of(scene)
    frame = work.frames[bodies_of(scene, work)[team.body].link]
    ends, wrenches, back, force, moment = Ends(acting.ends), Wrenches(Done(acting.done).wrenches), frame.R.T, ZERO, ZERO
    for e in range(load.point_count):
        end, on = ends[load.point_end + e], wrenches[load.point_end + e]
        f, m = on.force, on.moment
        force += f
        moment += m + cross(end.p - frame.p, f)
        put_three(acting.shifts, width * (skipped + e), back @ f)
        if team.turns:
            if not team.is_plain:
                marker = markers[load.first_end + load.point_end + e]
                m += cross(end.A @ (marker.axes.T @ marker.point), f)
            T = Tangents(acting.tangents)[skipped + e].T
            put_three(acting.shifts, width * (skipped + e) + 3, T.T @ (back @ m))
    frame.f -= force
    frame.n -= moment


@inlined
def clear_points(scene: Scene, work: Work, n: int, first_gathered: int) -> None:
    """Write no forces at the points of a load that does not act."""
    loads, shifts = loads_of(scene), acting_in(scene, work).shifts
    if loads[n].point_count > 0:
        width = width_of(teams_of(scene)[loads[n].team])
        at = width * (loads[n].first_point - loads[first_gathered].first_point)
        for i in range(at, at + width * loads[n].point_count):
            shifts[i] = 0.0


@inlined
def push_points(scene: Scene, work: Work, number: int, first: int, last: int) -> None:
    """Apply forces at the points of loads of a team beside each other to the modes."""
    if has_points(scene, number):
        team, (begin, size) = teams_of(scene)[number], span_of_points(scene, number, first, last)
        add_shares(team.basis, begin, acting_in(scene, work).shifts[:size], bodies_of(scene, work)[team.body].p)


@vector_kernel
def add_shares(basis: np.ndarray, first: int, shares: np.ndarray, p: np.ndarray) -> None:
    """Add forces at points, in G, to those on the modes."""
    for j in range(len(p)):
        row, s = basis[j, first:], p.dtype.type(0.0)
        for i in range(len(shares)):
            s += row[i] * shares[i]
        p[j] += s
