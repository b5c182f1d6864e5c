"""Friction against turning, of Coulomb's: about the normal, and against rolling, by anchors (Eq. 11)."""

from collections import namedtuple
from typing import Any

from kanefe.kernels.contact.laws.coulomb import CoulombNumbers
from kanefe.kernels.language import Vector, across, dot, inlined, norm

Turning = namedtuple("Turning", "share lever pressed normal A_s omega gone")
"""A point that turns on the surface. `share, lever`: of the contact that the point has; from its centre to where it
touches, m; `pressed`: normal force, N; 0 where it does not touch: anchors then follow; `normal, omega, gone`: normal;
angular velocity of what touches past the surface, rad/s; how far it turned since a rest, rad; in N; `A_s`: from the
axes of the surface to those of N."""

Braked = namedtuple("Braked", "moment twist_rate energy taken work")
"""The moment against turning (N m), the rate of a twist (rad/s), energy, power taken and that of slipping alone."""

Held = namedtuple("Held", "moment energy taken work about_rate rolling_rate")
"""The moment on the surface, energy, powers, and the rates of twists: about the normal, and in the surface's axes."""


@inlined
def couple(law: CoulombNumbers, point: Turning, states: Any, first: int) -> Held:
    """Return what holds a point against turning.

    The states from `first` on are the twist about the normal, rad, and that of rolling in axes of the surface, rad, as
    far as there is friction against them.
    """
    normal, zero = point.normal, 0.0 * point.pressed
    none = Vector(zero, zero, zero)
    spin = roll = Braked(none, none, zero, zero, zero)
    about, along = dot(point.omega, normal) * normal, dot(point.gone, normal)
    if law.torsional > 0.0:
        twist = (states[first] + along) * normal
        most = max(law.mu_along, law.mu_across) * law.torsional * point.pressed
        spin = braked(law, point.share * law.torsional**2, twist, twist, about, most)
        first += 1
    if law.rolling > 0.0:
        twist = point.A_s @ Vector(states[first], states[first + 1], states[first + 2]) + across(point.gone, normal)
        most = law.rolling * point.pressed
        roll = braked(law, point.share * point.lever**2, twist, across(twist, normal), point.omega - about, most)
    return Held(
        spin.moment + roll.moment,
        spin.energy + roll.energy,
        spin.taken + roll.taken,
        spin.work + roll.work,
        dot(spin.twist_rate, normal),
        point.A_s.T @ roll.twist_rate,
    )


@inlined
def braked(law: CoulombNumbers, size: Any, twist: Vector, along: Vector, rate: Vector, most: Any) -> Braked:
    """Return what an anchor against turning gives, whose stiffness and damping are so many times those of the law.

    `twist` is the whole state of the anchor, `along` that of it which follows the motion.
    """
    k, c = size * law.stiffness, size * law.damping
    pull = k * along + c * rate
    length = norm(pull)
    moment = pull if length.real <= most.real else (most / length) * pull
    given = -(law.stiffness / law.damping) * twist
    if c.real > 0.0:  # what has no share of the contact has an anchor too, which comes back
        given += (1.0 / c) * moment
    work = dot(moment, rate - given) if most.real > 0.0 else 0.0 * length
    return Braked(moment, given, 0.5 * k * dot(twist, twist), dot(moment, rate) - k * dot(twist, given), work)
