"""Forces of the wind on a moving frame by tables over the angle of the wind (Eq. 11)."""

import math
from typing import Annotated, Any

import numpy as np

from kanefe.kernels.force_elements.periodic_load import put_own
from kanefe.kernels.force_elements.places import SIGNATURE, Done, Ends, Wrench
from kanefe.kernels.language import ZERO, Behind, Record, Rows, Vector, called_by_address, inlined, numbers_from


class AerodynamicsNumbers(Record):
    """Numbers of the forces of wind: kg/m3, m2, how many pieces its table has; `WindNumbers`, and then the pieces."""

    density: float
    flat_area: float
    piece_count: float
    wind: Annotated[Any, Behind()]


class WindNumbers(Record):
    """Numbers of a wind: how many gusts and harmonics of turbulence it has, its mean, and these."""

    gust_count: float
    harmonic_count: float
    mean: Vector
    gusts: Annotated[Any, Behind()]


class Gust(Record):
    """A gust, s and m/s."""

    start: float
    duration: float
    velocity: Vector


class Gusts(Rows[Gust]):
    """Gusts, and what follows them."""


class Harmonic(Record):
    """A harmonic of turbulence: rad/s, and m/s with the cosine and the sine."""

    frequency: float
    cosine: Vector
    sine: Vector


class Harmonics(Rows[Harmonic]):
    """Harmonics of turbulence, and what follows them."""


class Piece(Record):
    """A piece of the table: where it begins, rad, and what goes with four powers of the angle from there, m2 and m3."""

    angle: float
    constant: Wrench
    slope: Wrench
    square: Wrench
    cube: Wrench


class Pieces(Rows[Piece]):
    """The pieces of a table, by rising angles."""


@called_by_address(*SIGNATURE)
def aerodynamics(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write force and moment; see `AerodynamicsNumbers`."""
    own, done = AerodynamicsNumbers(numbers), Done(out)
    wind = blown(t, own, ends)
    x, y, z = wind.x, wind.y, wind.z
    pressure = 0.5 * own.density * (x * x + y * y)
    up = z if z.real >= 0.0 else -z
    lift = Vector(0.0, 0.0, 0.5 * own.density * own.flat_area * up * z)
    if pressure.real == 0.0:
        put_own(lift, ZERO, ends, done)
        return
    # where the wind comes from; the angle to the nearest real direction makes it right for complex numbers
    near = np.arctan2(-y.real, -x.real)
    c, s = -np.cos(near), -np.sin(near)
    force, moment = areas_at(own, near, near + np.arctan((c * y - s * x) / (c * x + s * y)))
    put_own(pressure * force + lift, pressure * moment, ends, done)


@inlined
def blown(t: float, own: AerodynamicsNumbers, ends: Any) -> Vector:
    """Return the wind relative to the frame, in its axes."""
    end = Ends(ends)[0]
    return end.A.T @ (wind_at(t, WindNumbers(own.wind)) - end.v)


@inlined
def areas_at(own: AerodynamicsNumbers, near: Any, angle: Any) -> tuple[Vector, Vector]:
    """Return the areas for wind from an angle, that may be complex, near a real one: of forces and of moments."""
    wind = WindNumbers(own.wind)
    harmonics = Harmonics(numbers_from(Gusts(wind.gusts)[int(wind.gust_count)]))
    pieces = Pieces(numbers_from(harmonics[int(wind.harmonic_count)]))
    if near < pieces[0].angle:
        angle, near = angle + 2.0 * np.pi, near + 2.0 * np.pi
    low, high = 0, int(own.piece_count)
    while high - low > 1:
        middle = (low + high) // 2
        if pieces[middle].angle <= near:
            low = middle
        else:
            high = middle
    piece = pieces[low]
    a, b, c, d, h = piece.constant, piece.slope, piece.square, piece.cube, angle - piece.angle
    force = a.force + h * (b.force + h * (c.force + h * d.force))
    return force, a.moment + h * (b.moment + h * (c.moment + h * d.moment))


@inlined
def wind_at(t: float, own: WindNumbers) -> Vector:
    """Return the velocity of a wind: mean, gusts and turbulence."""
    velocity, gusts, count = own.mean, Gusts(own.gusts), int(own.gust_count)
    for i in range(count):
        gust = gusts[i]
        since = t - gust.start
        if since > 0.0 and since < gust.duration:
            velocity += 0.5 * (1.0 - math.cos(2.0 * math.pi * since / gust.duration)) * gust.velocity
    harmonics = Harmonics(numbers_from(gusts[count]))
    for i in range(int(own.harmonic_count)):
        one = harmonics[i]
        velocity += math.cos(one.frequency * t) * one.cosine + math.sin(one.frequency * t) * one.sine
    return velocity
