"""Which loads can act at a state: balls about what touches, against boxes and balls about what is touched.

A load whose balls are all out of the bounds of its first end does nothing, and its ends are not looked at. What is
found is exact: it depends on the state alone, whatever the speeds are. What touches but for round-off is in reach. A
ball on a flexible body grows by a bound on how far its points are displaced, ``sum_j w_j |eta_j|``.
"""

from typing import Annotated, Any

import numpy as np

from kanefe.kernels.contact.broad_phase import BALL, overlap, sort_along_widest
from kanefe.kernels.language import Array, Many, Record, Rows, Start, Values, inlined, kernel, vector_kernel
from kanefe.kernels.loads.acting import Acting, acting_in
from kanefe.kernels.scene import Scene, Work, bodies_of
from kanefe.kernels.tree import Frames
from kanefe.kernels.values.tensors import Matrix, Vector, dot

WIDER = 1e-12
"""Size that balls have more, relative to the coordinates of their places: far more than round-off of a touch."""


class ReachSizes(Record):
    """Which loads are found by a sweep over balls: of `Reach.sizes`."""

    first_swept: int  # the first of them; all others are in teams
    swept_balls: int  # how many balls the sweep has, the first ones
    has_swept_states: bool  # whether one of these loads has internal states


class Team(Record):
    """Loads beside each other that act, or do not, by the same bounds."""

    first_load: int
    load_count: int
    ball: int  # about all their ends; -1: none
    first_state: int  # internal states; -1: they are not beside each other
    state_count: int
    body: int  # flexible body of their points; -1: they have none
    point_count: int
    turns: bool  # whether points turn, and whether all ends are the points themselves
    is_plain: bool
    mode_count: int  # modes of the body, and numbers of the motion of all points
    column_count: int
    constants: Annotated[int, Start("points")]  # where what follows begins in `Reach.points`
    places: Annotated[Values, Many(Vector, "point_count")]  # undeformed, in G
    # (modes, columns): motion from the modes: 3 numbers of each point, or 6 of those that turn
    basis: Annotated[np.ndarray, Array("mode_count", "column_count")]


class Teams(Rows[Team]):
    """All teams: of `Reach.teams` and `Reach.points`."""


class Ball(Record):
    """A ball, in N or in a row."""

    centre: Vector
    radius: float


class Balls(Rows[Ball]):
    """Balls one behind the other in a list."""


class RowBall(Ball):
    """A ball about what touches."""

    row: int  # -1: N
    swell: int  # what it grows by; -1: nothing


class RowBalls(Rows[RowBall]):
    """All balls, those that are swept first: of `Reach.balls` and `Reach.centres`."""


class Swell(Record):
    """What balls on a flexible body grow by."""

    body: int
    mode_count: int
    first: Annotated[int, Start("weights")]  # where its weights begin
    weights: Annotated[np.ndarray, Array("mode_count")]  # (modes,)


class Swells(Rows[Swell]):
    """All of them: of `Reach.swells` and `Reach.weights`."""


class Bound(Record):
    """Where a load can act: a box in the row of its first end."""

    row: int  # -1: N
    first_ball: int  # of its balls among `Reach.members`; none: it may always act
    ball_count: int
    origin: Vector
    axes: Matrix
    lower: Vector  # corners
    upper: Vector
    rounding: float  # how far it is rounded, m
    stretch: float  # by how much a ball counts as larger
    is_room: float  # above zero: what is in it does not reach


class Bounds(Rows[Bound]):
    """Of all loads: of `Reach.loads` and `Reach.bounds`."""


class Pair(Record):
    """Two balls a < b, as ``a * balls + b``, and the swept load that acts where they overlap."""

    balls: int
    load: int


class Pairs(Rows[Pair]):
    """All pairs, in rising order: of `Reach.pairs`."""


@inlined
def teams_of(scene: Scene) -> Teams:
    """Return the teams of a scene."""
    return Teams(scene.between.reach.teams, scene.between.reach.points)


@inlined
def find_near(scene: Scene, work: Work) -> int:
    """Write how near all loads are, and in rising order the swept ones that are; return how many these are."""
    reach, teams, acting, frames = scene.between.reach, teams_of(scene), acting_in(scene, work), work.frames
    bounds, balls, nearness = Bounds(reach.loads, reach.bounds), Balls(acting.balls), acting.nearness
    place_balls(scene, work)
    for i in range(len(teams)):
        team = teams[i]
        last = team.first_load + team.load_count
        if team.ball >= 0:
            gap = gap_of(bounds[team.first_load], balls[team.ball], frames)
            if gap > 0.0:
                for n in range(team.first_load, last):
                    nearness[n] = -gap
                continue
        for n in range(team.first_load, last):
            gap, bound = 0.0, bounds[n]
            for m in range(bound.ball_count):
                to_ball = gap_of(bound, balls[reach.members[bound.first_ball + m]], frames)
                gap = to_ball if m == 0 else min(gap, to_ball)
            nearness[n] = -gap if gap > 0.0 else 1.0
    return find_swept(scene, work)


@inlined
def find_swept(scene: Scene, work: Work) -> int:
    """Write which swept loads are near, of balls that are placed; return how many."""
    reach = scene.between.reach
    sizes = ReachSizes(reach.sizes)
    if sizes.swept_balls == 0:
        return 0
    return sweep_over_balls(Pairs(reach.pairs), len(reach.balls), sizes, acting_in(scene, work))


@kernel
def sweep_over_balls(pairs: Pairs, balls: int, sizes: ReachSizes, acting: Acting) -> int:
    """Write which swept loads are near, and their numbers in rising order; return how many these are."""
    count, keys, order, nearness, near = sizes.swept_balls, acting.keys, acting.order, acting.nearness, acting.near
    nearness[sizes.first_swept :] = 0.0
    placed, found = acting.balls, 0
    axis = sort_along_widest(placed, count, keys, order)
    for i in range(count):
        a = int(order[i].real)
        end = placed[BALL * a + axis].real + placed[BALL * a + 3].real
        for j in range(i + 1, count):
            b = int(order[j].real)
            if keys[b].real > end:
                break
            if not overlap(placed, a, b):
                continue
            pair = min(a, b) * balls + max(a, b)
            for place in range(place_of_pair(pairs, pair), len(pairs)):
                if pairs[place].balls != pair:
                    break
                near[found] = pairs[place].load
                nearness[pairs[place].load] = 1.0
                found += 1
    for i in range(1, found):  # in rising order: sums do not depend on where the balls are
        moved, j = near[i], i
        while j > 0 and near[j - 1].real > moved.real:
            near[j] = near[j - 1]
            j -= 1
        near[j] = moved
    return found


@inlined
def place_of_pair(pairs: Pairs, pair: int) -> int:
    """Return the first place of a pair in a list in rising order, or that of the next."""
    low, high = 0, len(pairs)
    while low < high:
        middle = (low + high) // 2
        if pairs[middle].balls < pair:
            low = middle + 1
        else:
            high = middle
    return low


@inlined
def place_balls(scene: Scene, work: Work) -> None:
    """Write centres in N and radii of all balls, grown by what their bodies are displaced."""
    reach, acting, bodies, frames = scene.between.reach, acting_in(scene, work), bodies_of(scene, work), work.frames
    swells, grown = Swells(reach.swells, reach.weights), acting.grown
    for s in range(len(swells)):
        grown[s] = weighed_sizes(swells[s].weights, bodies[swells[s].body].eta)
    balls, placed = RowBalls(reach.balls, reach.centres), Balls(acting.balls)
    for b in range(len(balls)):
        ball, frame = balls[b], frames[balls[b].row]
        centre, radius = real_vector(frame.p) + real_matrix(frame.R) @ ball.centre, ball.radius
        if ball.swell >= 0:
            radius += grown[ball.swell].real
        placed[b].centre, placed[b].radius = centre, radius + WIDER * (radius + size_of(centre))


@vector_kernel
def weighed_sizes(weights: np.ndarray, x: np.ndarray) -> float:
    """Return the sum of the sizes of numbers times their weights."""
    s = 0.0
    for i in range(len(x)):
        s += weights[i] * abs(x[i].real)
    return s


@inlined
def gap_of(bound: Bound, ball: Ball, frames: Frames) -> Any:
    """Return how far a ball is from the bounds of a load, m, at least; up to zero: the load may act."""
    frame = frames[bound.row]
    place = real_vector(frame.p)
    x = real_matrix(frame.R).T @ (real_vector(ball.centre) - place) - bound.origin
    return gap_to(bound, bound.axes.T @ x, ball.radius.real + WIDER * size_of(place))


@inlined
def size_of(place: Vector) -> Any:
    """Return the largest of the coordinates of a place."""
    return max(abs(place.x), abs(place.y), abs(place.z))


@inlined
def gap_to(bound: Bound, x: Vector, radius: float) -> Any:
    """Return how far a ball is from bounds, seen in their axes."""
    below, above = bound.lower - x, x - bound.upper
    out = Vector(max(below.x, above.x), max(below.y, above.y), max(below.z, above.z))
    if bound.is_room > 0.0:
        return -max(out.x, out.y, out.z) - radius
    out = Vector(max(out.x, 0.0), max(out.y, 0.0), max(out.z, 0.0))
    return np.sqrt(dot(out, out)) - bound.rounding - bound.stretch * radius


@inlined
def real_vector(a: Vector) -> Vector:
    """Return the real part of a vector."""
    return Vector(a.x.real, a.y.real, a.z.real)


@inlined
def real_matrix(A: Matrix) -> Matrix:
    """Return the real part of a matrix."""
    x, y, z = A.x, A.y, A.z
    return Matrix(x.x.real, y.x.real, z.x.real, x.y.real, y.y.real, z.y.real, x.z.real, y.z.real, z.z.real)
