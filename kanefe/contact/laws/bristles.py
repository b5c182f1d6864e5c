"""LuGre friction: bristles that bend, and slip where they are dragged (Canudas de Wit and others, 1995)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kanefe.contact.geometry.shape import positive
from kanefe.errors import ModelError
from kanefe.frames import Vector, numbers
from kanefe.loads.falling_friction import share_of_static

STEADY = 0.99
"""Of what it comes to in steady sliding: bristles bent so far are told to slip."""


@dataclass(frozen=True)
class LuGre:
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
    >>> kf.LuGre(1e5, 300.0, 0.4, coulomb=1.0, static=1.5, stribeck_speed=1e-3).steady(0.0)
    1.5
    """

    sigma0: float
    sigma1: float
    sigma2: float
    coulomb: float
    static: float
    stribeck_speed: float

    has_memory = False
    turning_states = 0

    def __post_init__(self) -> None:
        for name in ("sigma0", "sigma1", "coulomb", "stribeck_speed"):
            positive(getattr(self, name), f"{name} of LuGre")
        viscous, static = numbers(self.sigma2), numbers(self.static)
        if viscous.shape != () or not np.isfinite(viscous) or viscous < 0.0:
            raise ModelError(f"sigma2 of LuGre must be one number, finite and >= 0, not {self.sigma2!r}")
        if static.shape != () or not self.coulomb <= static < math.inf:
            raise ModelError(f"static of LuGre must be a number of at least coulomb = {self.coulomb:g}")

    def steady(self, speed: float) -> float:
        """Return g, the coefficient of friction in steady sliding but for its viscous part."""
        return self.coulomb + (self.static - self.coulomb) * share_of_static(speed, self.stribeck_speed)

    def arms(self, lever: float) -> list[float]:
        """Return the levers of what holds against turning: there is none."""
        return []

    def bent(self, n: Vector, v: Vector, z: Vector, is_resting: bool) -> tuple[Vector, Vector, float]:
        """Return the friction for a normal force of 1, the rate of z, and how far it is beyond sticking (Eq. 11).

        `n` is the normal, `v` the velocity along the surface, `z` the deflection, all (3,). About a state of rest the
        bristles follow the motion.
        """
        speed = float(np.linalg.norm(v))
        g = self.steady(speed)
        rate = v if is_resting else v - self.sigma0 * speed / g * z
        flat, flat_rate = z - (z @ n) * n, rate - (rate @ n) * n
        drag = self.sigma0 * flat + self.sigma1 * flat_rate + self.sigma2 * v
        return drag, rate, self.sigma0 * float(np.linalg.norm(flat)) - STEADY * g
