"""Bearings: a shaft that turns on and on, held by coefficients over its speed (Eq. 11)."""

from typing import Annotated, Any, NamedTuple

from kanefe.kernels.force_elements.bushing import SixBySix, put_on_both, rates_from_a, six_by_six
from kanefe.kernels.force_elements.places import SIGNATURE, WATCH_SIGNATURE, Done, Ends
from kanefe.kernels.language import Behind, Record, Rows, Vector, called_by_address, cross, dot, inlined


class BearingNumbers(Record):
    """Numbers of a bearing: its axis, how many ends and speeds, and a `BearingRow` for each speed, or for all."""

    axis: Vector
    ends: float
    speeds: float
    rows: Annotated[Any, Behind()]


class Coefficients(Record):
    """A matrix (6, 6) at a speed of rotation, and its slope over the speed."""

    values: SixBySix
    slopes: SixBySix


class BearingRow(Record):
    """What holds a shaft at a speed of rotation."""

    speed: float
    stiffness: Coefficients
    damping: Coefficients


class BearingRows(Rows[BearingRow]):
    """Coefficients at rising speeds."""


EDGE = 1e-9
"""Excess of a speed over the range of a table, relative to it, that still counts as its end."""


class Blend(NamedTuple):
    """How coefficients at a speed are those of a table."""

    row: int  # that below the speed; -1: coefficients are constant
    low: Any  # weights of its values, of the next one's, and of the slopes of both
    high: Any
    low_slope: Any
    high_slope: Any


@called_by_address(*SIGNATURE)
def bearing(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write what it exerts on bearing and shaft; see `BearingNumbers`."""
    own, done, a, b = BearingNumbers(numbers), Done(out), Ends(ends)[0], Ends(ends)[1]
    e, blend = own.axis, blend_at(own, speed_of(own, ends))
    k, rows = max(blend.row, 0), BearingRows(own.rows)
    K, next_K, C, next_C = rows[k].stiffness, rows[k + 1].stiffness, rows[k].damping, rows[k + 1].damping
    d, axis = held_in(own, ends)
    rate, turn = rates_from_a(a, b)
    tilt, tilting = cross(e, axis), cross(e, cross(turn, axis))
    spring, spring_r = held_by(blend, K, next_K, d, tilt)
    beside, beside_r = held_by(blend, K, next_K, rate, tilting)
    brake, brake_r = held_by(blend, C, next_C, rate, tilting)
    friction_force = dot(e, held_by(blend, C, next_C, 0.0 * rate, dot(e, turn) * e)[1])
    moment = -cross(axis, cross(spring_r + brake_r, e)) - friction_force * axis
    of_springs = dot(rate, spring) + dot(tilting, spring_r)
    done.taken = dot(rate, brake) + dot(tilting, brake_r) + friction_force * dot(axis, turn)
    if own.speeds > 0.0:
        done.given = -of_springs
    else:
        done.potential = 0.5 * (dot(d, spring) + dot(tilt, spring_r))
        done.given = 0.5 * (dot(d, beside) + dot(tilt, beside_r) - of_springs)
    put_on_both(ends, -(spring + brake), moment, done)


@called_by_address(*WATCH_SIGNATURE)
def watch_bearing(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write how far the speed is within the table."""
    own = BearingNumbers(numbers)
    rows, speed = BearingRows(own.rows), speed_of(own, ends)
    low, high = rows[0].speed, rows[int(own.speeds) - 1].speed
    out[0] = min(speed - low, high - speed) + EDGE * (high - low)


@inlined
def held_in(own: BearingNumbers, ends: Any) -> tuple[Vector, Vector]:
    """Return where the shaft is in the bearing, and its axis, in the axes of the bearing."""
    a, b = Ends(ends)[0], Ends(ends)[1]
    return a.A.T @ (b.p - a.p), a.A.T @ (b.A @ own.axis)


@inlined
def speed_of(own: BearingNumbers, ends: Any) -> Any:
    """Return the speed that the coefficients follow: of the last end about the axis, seen from the bearing."""
    a, spinning = Ends(ends)[0], Ends(ends)[int(own.ends) - 1]
    return dot(own.axis, a.A.T @ (spinning.w - a.w))


@inlined
def blend_at(own: BearingNumbers, speed: Any) -> Blend:
    """Return how coefficients at a speed are those of the table: cubics by values and slopes at both ends."""
    count, k, none, rows = int(own.speeds), 0, 0.0 * speed, BearingRows(own.rows)
    if count == 0:
        return Blend(-1, none, none, none, none)
    while k < count - 2 and speed.real > rows[k + 1].speed:
        k += 1
    span = rows[k + 1].speed - rows[k].speed
    s = (speed - rows[k].speed) / span
    if s.real < 0.0:
        s = none
    elif s.real > 1.0:
        s = none + 1.0
    low, high = (1.0 + 2.0 * s) * (1.0 - s) * (1.0 - s), s * s * (3.0 - 2.0 * s)
    return Blend(k, low, high, span * s * (1.0 - s) * (1.0 - s), span * s * s * (s - 1.0))


@inlined
def held_by(blend: Blend, low: Coefficients, high: Coefficients, shift: Vector, turn: Vector) -> tuple[Vector, Vector]:
    """Return force and moment of a displacement and a rotation, or of their rates."""
    a = six_by_six(low.values, shift, turn)
    if blend.row < 0:
        return a
    b = six_by_six(high.values, shift, turn)
    c, d = six_by_six(low.slopes, shift, turn), six_by_six(high.slopes, shift, turn)
    force = blend.low * a[0] + blend.high * b[0] + blend.low_slope * c[0] + blend.high_slope * d[0]
    return force, blend.low * a[1] + blend.high * b[1] + blend.low_slope * c[1] + blend.high_slope * d[1]
