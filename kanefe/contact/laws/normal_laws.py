"""Normal forces of contacts that yield: what the penetration and its rate give."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from kanefe.contact.geometry.shape import positive
from kanefe.errors import ModelError
from kanefe.frames import numbers

HUNT_CROSSLEY, KELVIN_VOIGT = 0.0, 1.0


class Pressed(NamedTuple):
    """What a law gives: force (N), the part of it that is elastic, and the energy of that (J)."""

    force: float
    elastic: float
    potential: float


@dataclass(frozen=True)
class NormalLaw:
    """A force ``F = stiffness d^exponent`` on what is a depth d within a surface, and its damping.

    Attributes
    ----------
    stiffness : float
        N/m^exponent; of all points of a contact together, which share it.
    damping : float
        Of Hunt and Crossley's law lambda, s/m; of Kelvin and Voigt's c, N s/m.
    exponent : float
    restitution : float or None
        In place of the damping: see `Restitution`.
    """

    stiffness: float
    damping: float = 0.0
    exponent: float = 1.0
    restitution: float | None = None
    kind: ClassVar[float] = HUNT_CROSSLEY

    def __post_init__(self) -> None:
        label = f"of {type(self).__name__}"
        positive(self.stiffness, f"stiffness {label}")
        damping = numbers(self.damping)
        if damping.shape != () or not np.isfinite(damping) or damping < 0.0:
            raise ModelError(f"damping {label} must be one number, finite and >= 0, not {self.damping!r}")
        exponent = numbers(self.exponent)
        if exponent.shape != () or not 1.0 <= exponent <= 4.0:
            raise ModelError(f"exponent {label} must be a number of 1 to 4, not {self.exponent!r}")

    def pressed(self, d: float, rate: float, share: float, damping: float) -> Pressed:
        """Return the force at a depth d > 0 (m) and its rate (m/s) of a point with a share of the stiffness."""
        elastic = share * self.stiffness * d**self.exponent
        potential = elastic * d / (self.exponent + 1.0)
        if self.kind == KELVIN_VOIGT:
            return Pressed(max(0.0, elastic + share * damping * rate), elastic, potential)
        return Pressed(elastic * max(0.0, 1.0 + damping * rate), elastic, potential)

    def slope(self, d: float, share: float) -> float:
        """Return how fast the elastic force of a point grows with the depth d > 0 (m), N/m."""
        return share * self.stiffness * self.exponent * d ** (self.exponent - 1.0)


@dataclass(frozen=True)
class HuntCrossley(NormalLaw):
    """``F = k d^n max(0, 1 + lambda dd/dt)``: damping that grows with the depth, and never pulls (Hunt, Crossley 1975).

    Parameters
    ----------
    stiffness : float
        k, N/m^n.
    damping : float
        lambda, s/m.
    exponent : float
        n.

    Examples
    --------
    >>> import kanefe as kf
    >>> float(kf.HuntCrossley(1e7, damping=0.3).pressed(1e-3, 0.5, 1.0, 0.3).force.round(6))
    11500.0
    """


@dataclass(frozen=True)
class KelvinVoigt(NormalLaw):
    """``F = max(0, k d + c dd/dt)``: a spring beside a damper, which let go before they pull."""

    kind = KELVIN_VOIGT

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.exponent != 1.0:
            raise ModelError("the exponent of KelvinVoigt is 1. Remedy: HuntCrossley for another")


@dataclass(frozen=True)
class Hertz(NormalLaw):
    """``F = k d^1.5``: two elastic balls, or a ball on a half space.

    `Hertz.of_sphere` has k from radius and moduli.
    """

    exponent: float = 1.5

    @classmethod
    def of_sphere(
        cls,
        radius: float,
        E: float,
        nu: float,
        other_E: float | None = None,
        other_nu: float = 0.0,
        damping: float = 0.0,
    ) -> Hertz:
        """Return the law of a ball on a plane: ``k = 4/3 E* sqrt(R)``, ``1/E* = (1 - nu^2)/E + (1 - nu2^2)/E2``.

        Parameters
        ----------
        radius : float
            m; of two balls ``R1 R2 / (R1 + R2)``.
        E, nu : float
            Young's modulus (Pa) and Poisson's ratio of the ball.
        other_E, other_nu : float, optional
            Of the other body; default: it is rigid.
        damping : float
            lambda, s/m.

        Raises
        ------
        ModelError
            If a modulus or the radius is not above zero, or a Poisson's ratio not within -1 and 0.5.

        Examples
        --------
        >>> import kanefe as kf
        >>> round(kf.Hertz.of_sphere(0.01, 210e9, 0.3, 210e9, 0.3).stiffness / 1e9, 4)
        15.3846
        """
        compliance = (1.0 - _poisson(nu, "nu") ** 2) / positive(E, "E of a ball")
        if other_E is not None:
            compliance += (1.0 - _poisson(other_nu, "other_nu") ** 2) / positive(other_E, "other_E of a ball")
        return cls(4.0 / 3.0 / compliance * math.sqrt(positive(radius, "radius of a ball")), damping)


def _poisson(value: object, what: str) -> float:
    number = numbers(value)
    if number.shape != () or not -1.0 < number <= 0.5:
        raise ModelError(f"{what} of a ball, Poisson's ratio, must be above -1 and at most 0.5, not {value!r}")
    return float(number)


LEAST_SPEED = 1e-3


@dataclass(frozen=True)
class Restitution(NormalLaw):
    """``F = k d^n max(0, 1 + lambda dd/dt)``, lambda set at each impact, so that a given share of its speed is left.

    Newton's coefficient e, the speed after an impact over that before, follows from ``lambda v`` alone, whatever k, n
    and the masses: see `impact_number`. Impacts slower than `least_speed` take lambda as of that speed.

    Parameters
    ----------
    stiffness : float
        k, N/m^n.
    restitution : float
        e, above 0, at most 1.
    exponent : float
        n.
    least_speed : float
        m/s.
    """

    least_speed: float = LEAST_SPEED

    def __init__(
        self, stiffness: float, restitution: float, exponent: float = 1.0, least_speed: float = LEAST_SPEED
    ) -> None:
        e = numbers(restitution)
        if e.shape != () or not 0.0 < e <= 1.0:
            raise ModelError(f"restitution must be a number above 0, at most 1, not {restitution!r}")
        for name, value in (
            ("stiffness", stiffness),
            ("damping", 0.0),
            ("exponent", exponent),
            ("restitution", float(e)),
            ("least_speed", positive(least_speed, "least_speed of Restitution")),
        ):
            object.__setattr__(self, name, value)
        self.__post_init__()

    def damping_at(self, speed: float) -> float:
        """Return lambda (s/m) for an impact at a speed (m/s)."""
        return impact_number(self.restitution or 1.0) / max(speed, self.least_speed)


def impact_number(restitution: float) -> float:
    """Return lambda v of the impact that leaves a share `restitution` of the speed.

    From the energy of the path in and out, ``dv/dd = -F/(m v)``: with ``x = lambda v`` the speed before and after hold
    ``x - ln(1 + x) = -e x - ln(1 - e x)``, the same for all k, n and m.

    Examples
    --------
    >>> float(round(impact_number(0.7484350), 5))
    0.5
    """
    if restitution >= 1.0:
        return 0.0
    from scipy.optimize import brentq

    def left_over(x: float) -> float:
        return x - math.log1p(x) + restitution * x + math.log1p(-restitution * x)

    most = (1.0 - 1e-14) / restitution
    if left_over(most) > 0.0:  # below 0.03 the speed after comes as near to 1 / lambda as numbers tell
        return most
    least = 1e-3 * (1.0 - restitution)
    return float(brentq(left_over, least, most, xtol=1e-300, rtol=1e-14))
