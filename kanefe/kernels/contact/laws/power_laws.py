"""Normal forces by a power of the depth: Hunt and Crossley's, Hertz's, Kelvin and Voigt's, and by restitution."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from kanefe.arguments import plain_numbers, positive
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.kernels.contact.laws.normal_law import NormalForce, NormalLaw, Pressing, not_negative
from kanefe.kernels.language import Record, inlined

POWER, KELVIN_VOIGT = 0.0, 1.0


class PowerNumbers(Record):
    """Numbers of a power of the depth, in the words and units of `HuntCrossley` and `KelvinVoigt`."""

    stiffness: float
    exponent: float
    damping: float


@inlined
def by_power(numbers: Any, at: int, point: Pressing) -> NormalForce:
    """Return what Hunt and Crossley's law gives: see `NormalLaw.law`; lambda is increased by `more`."""
    own, depth = PowerNumbers(numbers, at), point.depth
    n, damping = own.exponent, 0.0 * depth + own.damping + point.more
    if n == 1.0:
        power = depth
    elif n == 1.5:
        power = depth * np.sqrt(depth)
    else:
        power = np.exp(n * np.log(depth))
    elastic = point.share * own.stiffness * power
    force = elastic * (1.0 + damping * point.rate)
    return NormalForce(force, elastic, elastic * depth / (n + 1.0), 0.0 * point.rate)


@inlined
def spring_and_damper(numbers: Any, at: int, point: Pressing) -> NormalForce:
    """Return what Kelvin and Voigt's law gives: see `NormalLaw.law`."""
    own, depth = PowerNumbers(numbers, at), point.depth
    elastic = point.share * own.stiffness * depth
    force = elastic + point.share * own.damping * point.rate
    return NormalForce(force, elastic, 0.5 * elastic * depth, 0.0 * point.rate)


@dataclass(frozen=True)
class PowerLaw(NormalLaw):
    """A force ``k d^n`` with damping."""

    numbers = PowerNumbers
    law = staticmethod(by_power)
    stiffness: float
    damping: float = 0.0
    exponent: float = 1.0

    def __post_init__(self) -> None:
        label = f"of {type(self).__name__}"
        positive(self.stiffness, f"stiffness {label}")
        not_negative(self.damping, f"damping {label}")
        exponent = numbers(self.exponent)
        if exponent.shape != () or not 1.0 <= exponent <= 4.0:
            raise ModelError(f"exponent {label} must be a number of 1 to 4, not {self.exponent!r}")
        plain_numbers(self)

    @property
    def straight(self) -> float | None:
        """Its stiffness, N/m, where it is a straight line."""
        return self.stiffness if self.exponent == 1.0 else None


@dataclass(frozen=True)
class HuntCrossley(PowerLaw):
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
class KelvinVoigt(PowerLaw):
    """``F = max(0, k d + c dd/dt)``: a spring beside a damper, which let go before they pull.

    Parameters
    ----------
    stiffness, damping : float
        k, N/m, and c, N s/m, of all points of a contact together.
    """

    exponent: float = field(default=1.0, init=False)
    kind = KELVIN_VOIGT
    law = staticmethod(spring_and_damper)


@dataclass(frozen=True)
class Hertz(HuntCrossley):
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
class Restitution(PowerLaw):
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

    restitution: float = 1.0
    least_speed: float = LEAST_SPEED
    has_impact = True

    def __init__(
        self, stiffness: float, restitution: float, exponent: float = 1.0, least_speed: float = LEAST_SPEED
    ) -> None:
        e = numbers(restitution)
        if e.shape != () or not 0.0 < e <= 1.0:
            raise ModelError(f"restitution must be a number above 0, at most 1, not {restitution!r}")
        self._set(
            stiffness=stiffness,
            damping=0.0,
            exponent=exponent,
            restitution=float(e),
            least_speed=positive(least_speed, "least_speed of Restitution"),
        )
        self.__post_init__()

    @property
    def impact_number(self) -> float:  # type: ignore[override]
        """Lambda times the speed of an impact."""
        return impact_number(self.restitution)


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
