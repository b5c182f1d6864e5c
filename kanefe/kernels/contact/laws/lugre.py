"""LuGre friction: bristles that bend, and slip where they are dragged (Canudas de Wit and others, 1995)."""

import math
from dataclasses import dataclass
from typing import Any

from kanefe.arguments import plain_numbers, positive
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.kernels.contact.falling import still_to_fall
from kanefe.kernels.contact.laws.friction_law import FrictionLaw, Rubbed, Sliding, check_numbers
from kanefe.kernels.language import Record, across, inlined, norm

LUGRE = 2.0

STEADY = 0.99
"""Deflection relative to that of steady sliding from which bristles are reported to slip."""


class LuGreNumbers(Record):
    """Numbers of `LuGre`, in its words and units."""

    sigma0: float
    sigma1: float
    sigma2: float
    coulomb: float
    static: float
    stribeck_speed: float


@inlined
def lugre(numbers: Any, at: int, point: Sliding) -> Rubbed:
    """Return what friction gives at a point: see `kanefe.kernels.contact.laws.rub`.

    About a state of rest the bristles follow the motion.
    """
    own, v, z = LuGreNumbers(numbers, at), point.along, point.stretch
    speed, least = norm(v), own.coulomb
    g = least * (1.0 + (own.static / least - 1.0) * still_to_fall(speed, own.stribeck_speed, 2.0)[1])
    rate = v
    if not point.rests:
        rate = v - (own.sigma0 * speed / g) * z
    flat = across(z, point.normal)
    force = own.sigma0 * flat + (own.sigma1 * across(rate, point.normal) + own.sigma2 * v)
    beyond = point.pressed * (own.sigma0 * norm(flat) - STEADY * g)
    return Rubbed(point.pressed * force, rate, 0.0 * point.share, norm(v - rate), beyond)


@dataclass(frozen=True)
class LuGre(FrictionLaw):
    """Friction ``T = N (s0 z + s1 dz/dt + s2 v)`` by bristles bent by z, ``dz/dt = v - s0 |v| z / g(v)``.

    ``g(v) = coulomb + (static - coulomb) exp(-(v / stribeck_speed)^2)``. What it holds creeps where a load below the
    break-away force vibrates: `Coulomb` does not. All coefficients are of the normal force; a friction of given forces
    is one of a contact whose normal force is given.

    Parameters
    ----------
    sigma0 : float
        Stiffness of the bristles, 1/m.
    sigma1 : float
        Their damping, s/m.
    sigma2 : float
        Viscous friction, s/m.
    coulomb, static : float
        Coefficients of friction of fast sliding, and of the slowest.
    stribeck_speed : float
        m/s.

    Raises
    ------
    ModelError
        If a number is no such thing.

    Examples
    --------
    >>> import kanefe as kf
    >>> kf.LuGre(1e5, 300.0, 0.4, coulomb=1.0, static=1.5, stribeck_speed=1e-3).coefficient(0.0)
    1.5
    """

    sigma0: float
    sigma1: float
    sigma2: float
    coulomb: float
    static: float
    stribeck_speed: float

    kind = LUGRE
    numbers = LuGreNumbers

    def __post_init__(self) -> None:
        for name in ("sigma0", "sigma1", "coulomb", "stribeck_speed"):
            positive(getattr(self, name), f"{name} of LuGre")
        check_numbers(self, "sigma2")
        static = numbers(self.static)
        if static.shape != () or not self.coulomb <= static < math.inf:
            raise ModelError(f"static of LuGre must be a number of at least coulomb = {float(self.coulomb):g}")
        plain_numbers(self)

    @property
    def coefficients(self) -> tuple[float, float]:
        """Coefficient of fast sliding."""
        return self.coulomb, self.coulomb

    @property
    def holding(self) -> float:
        """The coefficient of the slowest sliding."""
        return self.static

    def coefficient(self, speed: float) -> float:
        """Return the coefficient of friction in steady sliding at a speed (m/s)."""
        g = self.coulomb + (self.static - self.coulomb) * float(still_to_fall(speed, self.stribeck_speed, 2.0)[1])
        return g + self.sigma2 * speed

    @property
    def relaxation(self) -> float:
        """Rate at which bristles come back that do not touch, 1/s."""
        return self.sigma0 / self.sigma1

    def anchor(self, share: float, normal_force: float) -> tuple[float, float]:
        """Return stiffness and damping of bristles under a normal force."""
        return self.sigma0 * normal_force, (self.sigma1 + self.sigma2) * normal_force

    def large_stretch(self, weight: float) -> float:
        """Return the deflection at which bristles break away."""
        return self.static / self.sigma0
