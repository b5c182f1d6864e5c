"""Event values of loads in states of a run: values of functions of loads between frames."""

from typing import Annotated, NamedTuple

import numpy as np

from kanefe.kernels.compiler.arrays import Integers, RealRows, Reals
from kanefe.kernels.force_elements.places import done_size
from kanefe.kernels.language import Array, Record, Rows, call_address, copy, entry, inlined, kernel
from kanefe.kernels.loads.acting import COORDINATE, acting_in, ends_of, loads_of
from kanefe.kernels.loads.loads_between import evaluate_alone
from kanefe.kernels.loads.reach import Balls, ReachSizes, find_near, find_swept
from kanefe.kernels.loads.telling import States, state_at
from kanefe.kernels.scene import Scene, Work, work_in
from kanefe.kernels.sweeps.outward import sweep_outward
from kanefe.kernels.values.tensors import Vector, dot

NEAR, ALL = -1, -2
"""Values for the loads that are looked at: those that come near, and all."""

PATH = 2.0
"""Distance, in multiples of the longest distance between two positions in a step, within which a contact may be missed.
"""


class Path(Record):
    """Where a swept ball is in a step."""

    low: Vector  # corners of a box about its centres
    high: Vector
    last: Vector  # the last centre
    way: float  # the longest displacement along an axis


class Paths(Rows[Path]):
    """Those of all swept balls, in a list."""


class WatchWork(Work, is_frozen=True):
    """What watching writes besides."""

    watched_count: int  # loads and swept balls
    swept_ball_count: int
    # (loads,): of each load that is watched in a step how far away it comes, was, and moves between two states,
    # at least
    least: Annotated[np.ndarray, Array("watched_count")]
    last: Annotated[np.ndarray, Array("watched_count")]
    moved: Annotated[np.ndarray, Array("watched_count")]
    paths: Annotated[np.ndarray, Array(f"{Path.number_count}swept_ball_count")]  # `Paths`


class WatchedLoads(NamedTuple):
    """Loads that are watched."""

    counts: Integers  # (loads,): how many event values each has
    # (values, 2): what is written of a load that cannot act: so much of how far it is from acting, and so much
    # where that is not known
    far: RealRows


class Looks(NamedTuple):
    """What is asked for, and what is found."""

    # (4,): number of a load whose states an event changes (below zero: none does), number of the event, first and
    # number of the states: these are written to the first state, and to `found` by how much the potential energy
    # grows, J
    changing: Integers
    # (1,): number of the load that alone is looked at; the number of loads: none; NEAR: those that come near in a
    # step, and all of one state; ALL: all
    only: Integers
    found: RealRows  # (T, values)
    near: Reals  # (loads,): written: above zero for loads that were looked at, whose values are no estimates


@entry()
def watch_states(scene: Scene, watched: WatchedLoads, states: States, looks: Looks, memory: Reals) -> None:
    """Write the event values of loads in some states, or change a state by an event.

    Of several states, those of a step, it is told of loads that come nowhere near how far away they are, at least. Of
    one state all are looked at.

    Parameters
    ----------
    scene : Scene
        With these loads alone between frames, the addresses of what they are watched by, and `WatchWork`.
    watched : WatchedLoads
    states : States
    looks : Looks
    memory : ndarray
        For `WatchWork`.
    """
    near, only = looks.near, looks.only[0]
    near[:] = 1.0
    if looks.changing[0] >= 0:
        change_states(scene, states, looks, memory)
        return
    if only >= 0:
        near[:] = 0.0
        if only < len(near):
            near[only] = 1.0
    elif only == NEAR and len(states.states) > 1 and len(scene.between.reach.balls) > 0:
        find_coming_near(scene, watched, states, looks, memory)
    if near.sum() > 0.0:
        put_values(scene, watched, states, looks, work_in(scene, memory))


@inlined
def has_frames(scene: Scene) -> bool:
    """Return whether loads have ends that are frames: of joint coordinates nothing else has to be known of a scene."""
    ends, found = ends_of(scene), False
    for end in range(len(ends)):
        found = found or ends[end].row != COORDINATE
    return found


@kernel
def change_states(scene: Scene, states: States, looks: Looks, memory: np.ndarray) -> None:
    """Change the first state by an event."""
    work, asked = work_in(scene, memory), WatchWork(scene.work, memory).least
    n, event, first, count = looks.changing[0], looks.changing[1], looks.changing[2], looks.changing[3]
    load, state, acting, z = loads_of(scene)[n], state_at(scene, states, 0), acting_in(scene, work), states.states[0]
    if has_frames(scene):
        sweep_outward(scene, state, work, False)
    evaluate_alone(scene, state, work, n)
    out = acting.done[: done_size(load.end_count, load.state_count)]
    out[0], asked[0] = 0.0, float(event)
    copy(z[first : first + count], out[1 : 1 + count])
    constants = scene.between.numbers[load.first_number :]
    call_address(load.complex_function, (state.t, constants, asked, acting.ends, z[first:], out))
    copy(out[1 : 1 + count], z[first : first + count])
    looks.found[0, 0] = out[0]


@kernel
def find_coming_near(scene: Scene, watched: WatchedLoads, states: States, looks: Looks, memory: np.ndarray) -> None:
    """Write which loads come near in a step, and of all how far away they are, at least."""
    work, own = work_in(scene, memory), WatchWork(scene.work, memory)
    acting, near, far, found = acting_in(scene, work), looks.near, watched.far, looks.found
    balls, paths, least, last, moved = Balls(acting.balls), Paths(own.paths), own.least, own.last, own.moved
    near[:] = moved[:] = 0.0
    for k in range(len(states.states)):
        sweep_outward(scene, state_at(scene, states, k), work, False)
        find_near(scene, work)
        enclose_balls(balls, paths, own.swept_ball_count, k == 0)
        at = 0
        for n in range(len(near)):
            gap = -min(acting.nearness[n], 0.0)
            least[n] = gap if k == 0 else min(least[n], gap)
            if k > 0:
                moved[n] = max(moved[n], abs(gap - last[n]))
            last[n] = gap
            for i in range(at, at + watched.counts[n]):
                found[k, i] = far[i, 0] * gap + (far[i, 1] if gap == 0.0 else 0.0)
            at += watched.counts[n]
    put_enclosing(balls, paths, own.swept_ball_count)
    find_swept(scene, work)
    first_swept = ReachSizes(scene.between.reach.sizes).first_swept
    for n in range(len(near)):
        if acting.nearness[n] > 0.0 if n >= first_swept else least[n] <= PATH * moved[n]:
            near[n] = 1.0


@kernel
def put_values(scene: Scene, watched: WatchedLoads, states: States, looks: Looks, work: Work) -> None:
    """Write the event values of loads that are near."""
    loads, done, counts, moves = loads_of(scene), acting_in(scene, work).done, watched.counts, has_frames(scene)
    for k in range(len(states.states)):
        state, at = state_at(scene, states, k), 0
        if moves:
            sweep_outward(scene, state, work, False)
        for n in range(len(loads)):
            if looks.near[n] > 0.0:
                evaluate_alone(scene, state, work, n)
                copy(done[: counts[n]], looks.found[k, at : at + counts[n]])
            at += counts[n]


@inlined
def enclose_balls(balls: Balls, paths: Paths, count: int, is_first: bool) -> None:
    """Take in where the centres of swept balls are: a box about all places of each, and its longest way."""
    for b in range(count):
        path, x = paths[b], balls[b].centre
        if is_first:
            path.low, path.high, path.way = x, x, 0.0
        else:
            low, high, d = path.low, path.high, x - path.last
            path.low = Vector(min(low.x, x.x), min(low.y, x.y), min(low.z, x.z))
            path.high = Vector(max(high.x, x.x), max(high.y, x.y), max(high.z, x.z))
            path.way = max(path.way, abs(d.x), abs(d.y), abs(d.z))
        path.last = x


@inlined
def put_enclosing(balls: Balls, paths: Paths, count: int) -> None:
    """Write balls about all that swept balls were in, and may have been between, in their place."""
    for b in range(count):
        ball, path = balls[b], paths[b]
        size = path.high - path.low
        ball.centre = 0.5 * (path.low + path.high)
        ball.radius += 0.5 * np.sqrt(dot(size, size)) + PATH * path.way
