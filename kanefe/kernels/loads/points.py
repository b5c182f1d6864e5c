"""Points of a flexible body at which loads act: their motion and their forces on the modes, all of them at once.

They have no rows: nothing of them is computed where no load acts. The motion of the points of loads beside each other
is one product with eta and one with deta, and their forces come to the modes by the transpose of it.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import (
    accumulate,
    as_vector,
    cross,
    matrix,
    minus,
    nine_of,
    plus,
    product,
    put_three,
    rotated,
    rotated_back,
    three,
    vector,
)
from kanefe.kernels.compiler._numba import inlined, vector_kernel
from kanefe.kernels.force_elements.bushing import nine
from kanefe.kernels.force_elements.places import END_NUMBERS, WRENCH, WRENCHES, A, P, V, W
from kanefe.kernels.layout import (
    COUNT,
    FORCE,
    MOMENT,
    OMEGA,
    POSITION,
    ROW,
    SLOPES,
    VELOCITY,
    WORK_DETA,
    WORK_ETA,
    WORK_FORCE,
    R,
)
from kanefe.kernels.loads.loads_layout import (
    FIRST_END,
    FIRST_POINT,
    NEAR,
    OF_POINTS,
    POINT_COUNT,
    POINT_END,
    POINT_NUMBERS,
    TEAM,
    place_of_load,
    span_of_load,
)
from kanefe.kernels.loads.markers import MARKER_AXES, POINT
from kanefe.kernels.loads.reach import BODY, IS_PLAIN, POINTS, POOL, TURNS
from kanefe.kernels.scene import Scene, Work
from kanefe.kernels.sweeps.elastic import span, transposed_product
from kanefe.kernels.sweeps.slopes import slope_motion
from kanefe.kernels.tables import LoadsBetween


@inlined
def width_of(between: LoadsBetween, team: int) -> int:
    """Return how many numbers the motion of a point has."""
    return 6 if between.reach.teams[team, TURNS] else 3


@inlined
def columns_of(between: LoadsBetween, team: int) -> int:
    """Return how many numbers the motion of all points of a team has."""
    return width_of(between, team) * between.reach.teams[team, POINTS]


@inlined
def basis_span(between: LoadsBetween, team: int, k: int) -> slice:
    """Return where the motion of the points of a team from the modes, (k, 3 or 6 points), is in `Reach.points`."""
    teams = between.reach.teams
    at = teams[team, POOL] + 3 * teams[team, POINTS]
    return slice(at, at + k * columns_of(between, team))


@inlined
def gather_points(scene: Scene, work: Work, team: int, first: int, last: int) -> None:
    """Write displacements and rates of the points of loads beside each other."""
    between, flexible, modal, workspace = scene.between, scene.flexible, work.modal, work.acting
    if team >= 0 and between.reach.teams[team, BODY] >= 0:
        body, width = flexible.bodies[between.reach.teams[team, BODY]], width_of(between, team)
        begin = between.loads[first, FIRST_POINT]
        size = width * (between.loads[last - 1, FIRST_POINT] + between.loads[last - 1, POINT_COUNT] - begin)
        space = workspace[between.workspace_size[NEAR] :]
        basis = between.reach.points[basis_span(between, team, body[COUNT])].reshape(
            body[COUNT], columns_of(between, team)
        )
        rates_at = rates_place(between)
        transposed_product(basis, width * begin, modal[span(body, WORK_ETA)], space[:size])
        transposed_product(basis, width * begin, modal[span(body, WORK_DETA)], space[rates_at : rates_at + size])


@inlined
def rates_place(between: LoadsBetween) -> int:
    """Return where the rates of points are in their workspace, behind 6 numbers of each."""
    return 6 * (between.workspace_size[OF_POINTS] // POINT_NUMBERS)


@inlined
def put_points(scene: Scene, work: Work, n: int, first_gathered: int) -> None:
    """Write the motion of the points of a load as its ends."""
    between, flexible, workspace, rows = scene.between, scene.flexible, work.acting, work.frames.numbers
    ends = workspace[place_of_load(between) :]
    team = between.loads[n, TEAM]
    row, width, slopes = (
        flexible.bodies[between.reach.teams[team, BODY], ROW],
        width_of(between, team),
        flexible.sizes[SLOPES],
    )
    space, rates_at = workspace[between.workspace_size[NEAR] :], rates_place(between)
    skipped = between.loads[n, FIRST_POINT] - between.loads[first_gathered, FIRST_POINT]
    G, origin, velocity = matrix(rows, row, R), vector(rows, row, POSITION), vector(rows, row, VELOCITY)
    for e in range(between.loads[n, POINT_COUNT]):
        at = width * (skipped + e)
        place = three(between.reach.points, between.reach.teams[team, POOL] + 3 * (between.loads[n, FIRST_POINT] + e))
        w = vector(rows, row, OMEGA)
        lever = rotated(G, plus(place, three(space, at)))
        p, axes = plus(origin, lever), G
        v = plus(plus(velocity, cross(w, lever)), rotated(G, three(space, rates_at + at)))
        if width == 6:
            slope_rates = three(space, rates_at + at + 3)
            turned, tangent, _ = slope_motion(slopes, as_vector(three(space, at + 3)), as_vector(slope_rates))
            turn, T = nine_of(turned), nine_of(tangent)
            axes, w = product(G, turn), plus(w, rotated(G, rotated(T, slope_rates)))
            for i in range(9):
                space[2 * rates_at + 9 * (skipped + e) + i] = T[i]
        if not between.reach.teams[team, IS_PLAIN]:
            marker = between.loads[n, FIRST_END] + between.loads[n, POINT_END] + e
            arm = rotated(axes, vector(between.markers, marker, POINT))
            p, v = plus(p, arm), plus(v, cross(w, arm))
            axes = product(axes, matrix(between.markers, marker, MARKER_AXES))
        end = END_NUMBERS * (between.loads[n, POINT_END] + e)
        put_three(ends, end + P, p)
        for i in range(9):
            ends[end + A + i] = axes[i]
        put_three(ends, end + V, v)
        put_three(ends, end + W, w)


@inlined
def take_shares(scene: Scene, work: Work, n: int, first_gathered: int) -> None:
    """Apply forces at the points of a load to their body, and write them, in G, in the place of displacements."""
    between, flexible, workspace, rows = scene.between, scene.flexible, work.acting, work.frames.numbers
    out = workspace[span_of_load(between, n)]
    team = between.loads[n, TEAM]
    row, width = flexible.bodies[between.reach.teams[team, BODY], ROW], width_of(between, team)
    space, ends = workspace[between.workspace_size[NEAR] :], workspace[place_of_load(between) :]
    skipped = between.loads[n, FIRST_POINT] - between.loads[first_gathered, FIRST_POINT]
    G, origin, zero = matrix(rows, row, R), vector(rows, row, POSITION), 0.0 * rows[row, R]
    force, moment = (zero, zero, zero), (zero, zero, zero)
    for e in range(between.loads[n, POINT_COUNT]):
        end = between.loads[n, POINT_END] + e
        f, m = three(out, WRENCHES + WRENCH * end), three(out, WRENCHES + WRENCH * end + 3)
        force = plus(force, f)
        moment = plus(moment, plus(m, cross(minus(three(ends, END_NUMBERS * end + P), origin), f)))
        put_three(space, width * (skipped + e), rotated_back(G, f))
        if width == 6:
            if not between.reach.teams[team, IS_PLAIN]:
                marker = between.loads[n, FIRST_END] + end
                axes, point = matrix(between.markers, marker, MARKER_AXES), vector(between.markers, marker, POINT)
                m = plus(m, cross(rotated(nine(ends, END_NUMBERS * end + A), rotated_back(axes, point)), f))
            T = nine(space, 2 * rates_place(between) + 9 * (skipped + e))
            put_three(space, width * (skipped + e) + 3, rotated_back(T, rotated_back(G, m)))
    accumulate(rows, row, FORCE, (-force[0], -force[1], -force[2]))
    accumulate(rows, row, MOMENT, (-moment[0], -moment[1], -moment[2]))


@inlined
def clear_points(between: LoadsBetween, n: int, first_gathered: int, workspace: np.ndarray) -> None:
    """Write no forces at the points of a load that does not act."""
    if between.loads[n, POINT_COUNT] > 0:
        width = width_of(between, between.loads[n, TEAM])
        at = width * (between.loads[n, FIRST_POINT] - between.loads[first_gathered, FIRST_POINT])
        at += between.workspace_size[NEAR]
        for i in range(at, at + width * between.loads[n, POINT_COUNT]):
            workspace[i] = 0.0


@inlined
def push_points(scene: Scene, work: Work, team: int, first: int, last: int) -> None:
    """Apply forces at the points of loads beside each other to the modes."""
    between, flexible, modal, workspace = scene.between, scene.flexible, work.modal, work.acting
    if team >= 0 and between.reach.teams[team, BODY] >= 0:
        body, width = flexible.bodies[between.reach.teams[team, BODY]], width_of(between, team)
        begin = between.loads[first, FIRST_POINT]
        size = width * (between.loads[last - 1, FIRST_POINT] + between.loads[last - 1, POINT_COUNT] - begin)
        shares = workspace[between.workspace_size[NEAR] :][:size]
        basis = between.reach.points[basis_span(between, team, body[COUNT])].reshape(
            body[COUNT], columns_of(between, team)
        )
        add_shares(basis, width * begin, shares, modal[span(body, WORK_FORCE)])


@vector_kernel
def add_shares(basis: np.ndarray, first: int, shares: np.ndarray, p: np.ndarray) -> None:
    """Add forces at points, in G, to those on the modes."""
    for j in range(len(p)):
        row, s = basis[j, first:], p.dtype.type(0.0)
        for i in range(len(shares)):
            s += row[i] * shares[i]
        p[j] += s
