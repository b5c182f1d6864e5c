"""Friction of contacts: Coulomb's law with an anchor, that holds what it holds for ever."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.contact.geometry.shape import direction
from kanefe.errors import ModelError
from kanefe.frames import Vector, numbers
from kanefe.loads.falling_friction import share_of_static, slip_speed


@dataclass(frozen=True)
class Coulomb:
    """Dry friction: a point that sticks hangs on a spring and damper from its anchor, which moves only when it slips.

    With w the stretch of that spring, v the velocity along the surface and ``p = k w + c v``, what acts is p as far as
    ``|p| <= mu N``, and else mu N along p; ``dw/dt = (force - k w) / c``. So w follows the motion exactly while the
    point sticks, and nothing creeps.

    Parameters
    ----------
    mu : float or (float, float)
        Coefficient while it slips; two: along `along` and across it.
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

    def __post_init__(self) -> None:
        mu = numbers(self.mu)
        if mu.shape not in ((), (2,)) or not np.all(np.isfinite(mu)) or np.any(mu < 0.0):
            raise ModelError(f"mu of Coulomb must be one number or two, finite and >= 0, not {self.mu!r}")
        for name in ("static", "stribeck_speed", "stiffness", "damping", "torsional", "rolling"):
            value = getattr(self, name)
            if value is None and name not in {"stribeck_speed", "torsional", "rolling"}:
                continue
            number = numbers(value)
            if number.shape != () or not np.isfinite(number) or number < 0.0:
                raise ModelError(f"{name} of Coulomb must be one number, finite and >= 0, not {value!r}")
        if self.stiffness == 0.0 or self.damping == 0.0:
            raise ModelError("stiffness and damping of Coulomb must be > 0: what sticks hangs on them")
        if self.static is not None and self.static < mu.max():
            raise ModelError(f"static of Coulomb, {self.static:g}, is below mu, {mu.max():g}. Remedy: the larger first")
        if self.static is not None and mu.shape == (2,):
            raise ModelError("Coulomb takes either `static` or two coefficients. Remedy: one coefficient")
        if self.stribeck_speed and not self.has_memory:
            raise ModelError("stribeck_speed of Coulomb needs a `static` above mu to fall from")
        direction(self.along, "along of Coulomb")

    @property
    def has_memory(self) -> bool:
        """Whether it slips by another coefficient than it sticks by, so that it has to be known which it does."""
        return self.static is not None and self.static > numbers(self.mu).max()

    @property
    def turning_states(self) -> int:
        """How many internal states a point has for what holds it against turning."""
        return (self.torsional > 0.0) + 3 * (self.rolling > 0.0)

    def arms(self, lever: float) -> list[float]:
        """Return the lever by which the anchor of each of these states acts, of a point with one to roll on, m."""
        return [self.torsional] * (self.torsional > 0.0) + [lever] * 3 * (self.rolling > 0.0)

    @property
    def sliding(self) -> float:
        """The larger coefficient of slipping."""
        return max(self.coefficients)

    @property
    def coefficients(self) -> tuple[float, float]:
        """Of slipping, along and across."""
        mu = numbers(self.mu)
        return (float(mu), float(mu)) if mu.shape == () else (float(mu[0]), float(mu[1]))

    @property
    def static_ratio(self) -> float:
        """Static over kinetic coefficient, and 1 where there is but one."""
        largest = self.sliding
        return 1.0 if self.static is None or largest == 0.0 else self.static / largest

    def fallen(self, speed: float) -> float:
        """Return the coefficient of slipping at a speed (m/s), of that of fast slipping."""
        if self.stribeck_speed == 0.0:
            return 1.0
        return 1.0 + (self.static_ratio - 1.0) * share_of_static(speed, self.stribeck_speed)

    def slip_speed(self, pull: float, normal: float, damping: float) -> float:
        """Return how fast an anchor moves that slips (m/s), 0 if it does not; mu falls from static to its own."""
        least = self.sliding * normal
        return slip_speed(pull, least, (self.static_ratio - 1.0) * least, damping, self.stribeck_speed)

    @property
    def axis(self) -> Vector:
        """The direction of the first coefficient."""
        return direction(self.along, "along of Coulomb")
