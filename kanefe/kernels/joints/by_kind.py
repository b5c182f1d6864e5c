"""The table of the kinds of links: what each does in the sweeps.

A link without a joint, FIXED, and a driven coordinate are passed by: they have no speed to eliminate.
"""

from typing import Any

import numpy as np

from kanefe.kernels.joints import axis, ball
from kanefe.kernels.joints.free import accelerate_free, eliminate_free, move_free, moved_freely
from kanefe.kernels.joints.given import move_given
from kanefe.kernels.joints.handing import Carried, Felt, hand_inward
from kanefe.kernels.joints.motion import Relative, put_motion, put_three, three
from kanefe.kernels.joints.revolute import eliminate_revolute, move_revolute
from kanefe.kernels.language import ZERO, Vector, cross, dot, inlined
from kanefe.kernels.scene import State
from kanefe.kernels.tree import AxisFrame, BallFrame, Frame, FreeFrame, GivenFrame, Kind, Link


@inlined
def partials(link: Link, frame: Frame) -> tuple[Vector, Vector]:
    """Return the partial velocity of the origin and the partial angular velocity of a link of one coordinate, in N."""
    if link.kind == Kind.GIVEN:
        given = GivenFrame(frame)
        v, w = given.partial_v, given.partial_w
    else:
        v, w = link.along * frame.R.z, link.about * frame.R.z
    return v, w


@inlined
def move(link: Link, frame: Frame, parent: Frame, state: State, numbers: np.ndarray) -> None:
    """Write the motion of a link. `numbers`: constants of given links."""
    R, r, kind, drives, q, u = parent.R @ link.axes, parent.R @ link.place, link.kind, state.drives, state.q, state.u
    if kind == Kind.REVOLUTE:
        frame.R, spin, twist = move_revolute(link, R, drives, q, u)
        put_motion(frame, parent, r, Relative(ZERO, spin, ZERO, twist))
    elif kind == Kind.AXIS:
        frame.R, arm, relative = axis.move_axis(link, R, drives, q, u)
        put_motion(frame, parent, r + arm, relative)
    elif kind == Kind.SPHERICAL:
        frame.R, spin = ball.move_ball(link, R, q, u)
        put_motion(frame, parent, r, Relative(ZERO, spin, ZERO, ZERO))
    elif kind == Kind.FREE:
        frame.R, arm, slide, spin = move_free(link, R, q, u)
        put_motion(frame, parent, r + arm, Relative(slide, spin, ZERO, ZERO))
    elif kind == Kind.GIVEN:
        frame.R, arm, given = move_given(link, numbers, frame, R, axis.motion_along(link, drives, q, u))
        put_motion(frame, parent, r + arm, given)
    else:
        frame.R = R
        put_motion(frame, parent, r, Relative(ZERO, ZERO, ZERO, ZERO))


@inlined
def eliminate(link: Link, frame: Frame, applied: np.ndarray, is_implicit: bool, added: np.ndarray) -> bool:
    """Write what the acceleration of the joint of a link follows from; return whether its speeds have inertia."""
    kind, is_regular = link.kind, True
    if kind == Kind.SPHERICAL:
        is_regular = ball.eliminate_ball(link, BallFrame(frame))
    elif kind == Kind.FREE:
        is_regular = eliminate_free(link, FreeFrame(frame))
    elif kind != Kind.FIXED and link.drive < 0:
        along, speed = AxisFrame(frame), link.speed
        resists = link.armature + added[speed] if is_implicit else link.armature
        if kind == Kind.REVOLUTE:
            is_regular = eliminate_revolute(along, applied[speed], resists)
        else:
            v, w = partials(link, frame)
            is_regular = axis.eliminate_along(along, v, w, applied[speed], resists)
    return is_regular


@inlined
def hand_across(link: Link, frame: Frame, parent: Frame, applied: np.ndarray) -> None:
    """Add inertia and force of a link to its parent, as this feels them across the joint, which gives way."""
    kind = link.kind
    if kind == Kind.SPHERICAL:
        hand_inward(parent, frame.r, ball.across_ball(link, BallFrame(frame), applied))
    elif kind != Kind.FREE:
        felt = Felt(frame.M, frame.H, frame.J, frame.f, frame.n)
        if kind != Kind.FIXED and link.drive < 0:
            felt = axis.across_axis(AxisFrame(frame))
        hand_inward(parent, frame.r, felt)


@inlined
def hand_through(link: Link, frame: Frame, applied: np.ndarray) -> tuple[Vector, Vector]:
    """Return the force and moment that the parent is to feel of those of a link, whose joint gives way."""
    kind, f, n = link.kind, frame.f, frame.n
    if kind == Kind.SPHERICAL:
        _, f, n = ball.force_through_ball(link, BallFrame(frame), frame.R @ three(applied, link.speed), f, n)
    elif kind == Kind.FREE:
        f, n = ZERO, ZERO
    elif kind != Kind.FIXED and link.drive < 0:
        along = AxisFrame(frame)
        v, w = partials(link, frame)
        rest, f, n = axis.force_along(along, v, w, applied[link.speed], f, n)
        along.rest = rest
    return f, n


@inlined
def accelerate(link: Link, frame: Frame, parent: Frame, applied: np.ndarray, du: np.ndarray) -> None:
    """Write du of the joint of a link, and its share in the accelerations of the link."""
    kind, alpha = link.kind, parent.alpha
    a = parent.a + cross(alpha, frame.r)  # as if it was fixed
    if kind == Kind.SPHERICAL:
        alpha = ball.accelerate_ball(link, BallFrame(frame), a, alpha, applied, du)
    elif kind == Kind.FREE:
        a, alpha = accelerate_free(link, FreeFrame(frame), parent.R @ link.axes, (a, alpha), applied, du)
    elif kind != Kind.FIXED and link.drive < 0:
        rate = axis.acceleration_along(AxisFrame(frame), a, alpha)
        du[link.speed] = rate
        if kind == Kind.REVOLUTE:
            alpha = alpha + rate * frame.R.z
        else:
            v, w = partials(link, frame)
            a, alpha = a + rate * v, alpha + rate * w
    frame.a, frame.alpha = a, alpha


@inlined
def give_way(link: Link, frame: Frame, answer: np.ndarray, f: Vector, n: Vector) -> tuple[Vector, Vector]:
    """Write how the joint of a link answers to what it needs from its parent; return what is left of that.

    Parameters
    ----------
    answer : ndarray, shape (speeds,)
        Acceleration of the joint, in place of what is applied along it; turning of a ball, both accelerations of a free
        body.
    """
    kind = link.kind
    if kind == Kind.SPHERICAL:
        turning, f, n = ball.force_through_ball(link, BallFrame(frame), 0.0 * n, f, n)
        put_three(answer, 0, turning)
    elif kind == Kind.FREE:
        a, alpha = moved_freely(FreeFrame(frame), -f, -n)
        put_three(answer, 0, a)
        put_three(answer, 3, alpha)
        f, n = 0.0 * f, 0.0 * n
    elif len(answer) > 0:
        v, w = partials(link, frame)
        answer[0], f, n = axis.force_along(AxisFrame(frame), v, w, answer[0], f, n)
    return f, n


@inlined
def moved_by(link: Link, frame: Frame, carried: Carried, applied: Any, sizes: np.ndarray) -> tuple[Any, Any]:
    """Return the square of how far a joint moves the end of a way, over displacements of some sizes, and if it could.

    A joint with partial velocities v and w has ``v F + w (M + r x F)`` of force and moment at the end, with the lever r
    to it, and could have the root of ``(v F)^2 + w^2 (M^2 + r^2 F^2)``.

    Parameters
    ----------
    applied : number
        What acts along an axis directly.
    sizes : ndarray, shape (free,)
    """
    kind, size, pull, couple, lever = link.kind, sizes[link.speed], carried.pull, carried.couple, carried.lever
    twist, along = couple + cross(lever, pull), dot(pull, pull)
    about, across = dot(twist, twist), dot(couple, couple) + dot(lever, lever) * along
    if kind == Kind.SPHERICAL:
        own, reach = size * size * about, size * size * across
    elif kind == Kind.FREE:
        shift, turn = size * size * along, sizes[link.speed + 3]
        own, reach = shift + turn * turn * about, shift + turn * turn * across
    else:
        v, w = partials(link, frame)
        moved, could = applied + dot(v, pull) + dot(w, twist), dot(v, v) * along + dot(w, w) * across
        own, reach = size * size * moved * moved, size * size * (applied * applied + could)
    return own, reach


@inlined
def shared_answer(link: Link, frame: Frame, f: Vector, n: Vector, own: np.ndarray, other: np.ndarray) -> Any:
    """Return what a joint gives along a row of a loop by a unit multiplier of another, from the answers to both.

    Parameters
    ----------
    f, n : Vector
        What the link needs from its parent for the first.
    """
    kind = link.kind
    if kind == Kind.SPHERICAL:
        along = dot(n, three(other, 0))
    elif kind == Kind.FREE:
        along = -(dot(f, three(other, 0)) + dot(n, three(other, 3)))
    else:
        along = own[0] * other[0] / AxisFrame(frame).pivot
    return along


@inlined
def answer_along(link: Link, frame: Frame, parent: Frame, applied: np.ndarray, answer: np.ndarray) -> Any:
    """Return what the forces on a link give of the acceleration along a row of a loop, by its joint's answer to it."""
    kind, speed = link.kind, link.speed
    if kind == Kind.SPHERICAL:
        along = dot(three(answer, 0), frame.n - frame.R @ three(applied, speed))
    elif kind == Kind.FREE:
        f = frame.f - parent.R @ (link.axes @ three(applied, speed))
        n = frame.n - frame.R @ three(applied, speed + 3)
        along = -(dot(three(answer, 0), f) + dot(three(answer, 3), n))
    else:
        own = AxisFrame(frame)
        along = answer[0] * own.rest / own.pivot
    return along


@inlined
def answer_further(link: Link, frame: Frame, multiplier: Any, answer: np.ndarray) -> None:
    """Add what a multiplier gives of the acceleration along a coordinate; forces that were added say it of others."""
    if link.kind != Kind.SPHERICAL and link.kind != Kind.FREE:
        AxisFrame(frame).rest += multiplier * answer[0]


@inlined
def put_coordinate_rates(link: Link, q: np.ndarray, u: np.ndarray, rates: np.ndarray) -> None:
    """Write dq/dt of the joint of a link."""
    kind, at, speed = link.kind, link.coordinate, link.speed
    if kind == Kind.SPHERICAL:
        ball.put_euler_rates(rates, at, q, three(u, speed))
    elif kind == Kind.FREE:
        for c in range(3):
            rates[at + c] = u[speed + c]
        ball.put_euler_rates(rates, at + 3, q, three(u, speed + 3))
    elif kind != Kind.FIXED and kind != Kind.INTERFACE and link.drive < 0:
        rates[at] = u[speed]


@inlined
def advance_joint(link: Link, q: np.ndarray, step: np.ndarray, share: Any, moved: np.ndarray) -> None:
    """Write the coordinates of the joint of a link, moved by a share of a step."""
    kind, at, speed = link.kind, link.coordinate, link.speed
    if kind == Kind.SPHERICAL:
        ball.put_turned(moved, at, q, share * step[speed], share * step[speed + 1], share * step[speed + 2])
    elif kind == Kind.FREE:
        for c in range(3):
            moved[at + c] = q[at + c] + share * step[speed + c]
        ball.put_turned(moved, at + 3, q, share * step[speed + 3], share * step[speed + 4], share * step[speed + 5])
    elif kind != Kind.FIXED and kind != Kind.INTERFACE and link.drive < 0:
        moved[at] = q[at] + share * step[speed]
