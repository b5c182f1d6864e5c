"""Coulomb's friction at an anchor, that holds what it holds for ever (Eq. 11)."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from kanefe.arguments import plain_numbers
from kanefe.errors import ModelError
from kanefe.frames import direction, numbers
from kanefe.kernels.contact.falling import SteadyNumbers, steady_numbers
from kanefe.kernels.contact.laws.anchoring import Slip, by_anchor, pull_of
from kanefe.kernels.contact.laws.friction_law import AnchoredFriction, Rubbed, Sliding, check_numbers
from kanefe.kernels.language import Record, Vector, across, cross, dot, inlined, norm, unit
from kanefe.kernels.values.filled import filled_from

COULOMB = 1.0
GAUSSIAN = 2.0
"""Exponent of the decrease from static friction."""


class CoulombNumbers(Record):
    """Numbers of `Coulomb`, in its words and units."""

    mu_along: float
    mu_across: float
    static_ratio: float
    stribeck_speed: float
    stiffness: float
    damping: float
    torsional: float
    rolling: float
    axis: Vector


@inlined
def coulomb(numbers: Any, at: int, point: Sliding) -> Rubbed:
    """Return what friction gives at a point: see `kanefe.kernels.contact.laws.rub`."""
    own = CoulombNumbers(numbers, at)
    k, c = point.share * own.stiffness, point.share * own.damping
    pull = pull_of(k, c, point)
    size, mu = measured(own, pull, point)
    least = mu * point.pressed
    return by_anchor(k, c, pull, size, point, Slip(least, own.static_ratio * least, c, own.stribeck_speed, GAUSSIAN))


@inlined
def measured(own: CoulombNumbers, pull: Vector, point: Sliding) -> tuple[Any, float]:
    """Return the size of a pull and the coefficient it is measured by; of two coefficients both as of one."""
    mu = own.mu_along
    if own.mu_across == mu:
        return norm(pull), mu
    first = unit(across(point.A_s @ own.axis, point.normal))
    x, y = dot(pull, first) / mu, dot(pull, cross(point.normal, first)) / own.mu_across
    return np.sqrt(x * x + y * y), 1.0


@dataclass(frozen=True)
class Coulomb(AnchoredFriction):
    """Dry friction: a point that sticks hangs on a spring and damper from its anchor, which moves only when it slips.

    With w the stretch of that spring, v the velocity along the surface and ``p = k w + c v``, what acts is p as far as
    ``|p| <= mu N``, and else mu N along p; ``dw/dt = (force - k w) / c``. So w follows the motion exactly while the
    point sticks, and nothing creeps.

    Parameters
    ----------
    mu : float or (float, float)
        Coefficient while it slips; two, above zero: along `along` and across it.
    static : float, optional
        Coefficient at which it begins to slip; default: the same.
    stribeck_speed : float
        The speed (m/s) over which mu falls from `static` to `mu`, as ``exp(-(v / stribeck_speed)^2)``; 0: at once.
    stiffness : float, optional
        k of all points together, N/m; default: that of a normal law that is a straight line.
    damping : float, optional
        c of all points together, N s/m; default: what is critical for the masses that move on both sides with all that
        their joints hold, in series.
    along : "x", "y", "z" or array_like, shape (3,)
        The direction of the first of two coefficients, in the axes of the surface.
    torsional : float
        Radius rho of the patch that each point stands for, m: friction holds against spinning about the normal up to
        ``mu rho N`` (two thirds of the radius of a disc pressed evenly), by an anchor of stiffness ``k rho^2``.
    rolling : float
        Arm of rolling resistance, m: it holds against rolling up to ``rolling N``, as on a slope of
        ``tan(angle) = rolling / radius``, by an anchor of stiffness ``k radius^2``. Of balls and rings.

    Raises
    ------
    ModelError
        If a coefficient is negative, `static` is below `mu`, or a number is none.

    Examples
    --------
    >>> import kanefe as kf
    >>> kf.Coulomb(0.6, static=0.8).static
    0.8
    """

    mu: float | tuple[float, float]
    static: float | None = None
    stribeck_speed: float = 0.0
    stiffness: float | None = None
    damping: float | None = None
    along: object = "x"
    torsional: float = 0.0
    rolling: float = 0.0

    kind = COULOMB
    numbers = CoulombNumbers

    def __post_init__(self) -> None:
        mu = numbers(self.mu)
        if mu.shape not in ((), (2,)) or not np.all(np.isfinite(mu)) or np.any(mu < 0.0):
            raise ModelError(f"mu of Coulomb must be one number or two, finite and >= 0, not {self.mu!r}")
        if mu.any() and not mu.all():
            raise ModelError(
                f"two coefficients of Coulomb must both be above zero, or none, not {self.mu!r}: friction acts along "
                "the pull, and there is none where the pull has a part that it cannot take. Remedy: a small one"
            )
        check_numbers(self, "static", "stribeck_speed", "stiffness", "damping", "torsional", "rolling")
        if self.stiffness == 0.0 or self.damping == 0.0:
            raise ModelError("stiffness and damping of Coulomb must be > 0: they hold a sticking point")
        if self.static is not None and self.static < mu.max():
            raise ModelError(
                f"static of Coulomb, {float(self.static):g}, is below mu, {mu.max():g}. Remedy: exchange them"
            )
        if self.static is not None and mu.shape == (2,):
            raise ModelError("Coulomb takes either `static` or two coefficients. Remedy: one coefficient")
        if self.stribeck_speed and not self.has_memory:
            raise ModelError("stribeck_speed of Coulomb needs a `static` above mu to fall from")
        direction(self.along, "along of Coulomb")
        plain_numbers(self)

    @property
    def block(self) -> np.ndarray:
        """Its numbers for compiled code."""
        along, across = self.coefficients
        axis = direction(self.along, "along of Coulomb")
        return filled_from(self, CoulombNumbers, mu_along=along, mu_across=across, axis=axis)

    @property
    def has_memory(self) -> bool:  # type: ignore[override]
        """Whether it slips by another coefficient than it sticks by, so that it has to be known which it does."""
        return self.static is not None and self.static > self.sliding

    @property
    def turning_states(self) -> int:  # type: ignore[override]
        """How many internal states a point has for what holds it against turning."""
        return (self.torsional > 0.0) + 3 * (self.rolling > 0.0)

    def arms(self, lever: float) -> list[float]:
        """Return the lever by which the anchor of each of these states acts, of a point with one to roll on, m."""
        return [self.torsional] * (self.torsional > 0.0) + [lever] * 3 * (self.rolling > 0.0)

    @property
    def holding(self) -> float:
        """The larger coefficient at which it begins to slip."""
        return self.sliding if self.static is None else self.static

    @property
    def coefficients(self) -> tuple[float, float]:
        """Coefficients of slip, along and across."""
        mu = numbers(self.mu)
        return (float(mu), float(mu)) if mu.shape == () else (float(mu[0]), float(mu[1]))

    @property
    def static_ratio(self) -> float:
        """Static over kinetic coefficient, and 1 where there is but one."""
        largest = self.sliding
        return 1.0 if self.static is None or largest == 0.0 else self.static / largest

    @property
    def steady(self) -> SteadyNumbers:
        """Its coefficients in steady sliding, the larger ones."""
        return steady_numbers(self.sliding, self.holding, self.stribeck_speed, GAUSSIAN)

    @property
    def axis(self) -> np.ndarray | None:  # type: ignore[override]
        """The direction of the first of two coefficients, in axes of the surface; None: there is but one."""
        return direction(self.along, "along of Coulomb") if len(set(self.coefficients)) > 1 else None

    def stuck(self, factor: float) -> Self:
        """Return the law with so many times larger coefficients, under which all sticks."""
        mu = tuple(factor * one for one in self.coefficients)
        static = None if self.static is None else factor * self.static
        return self.with_numbers(mu=mu if self.axis is not None else mu[0], static=static)
