"""Stribeck's friction with breakaway: an anchor that holds, and a coefficient that falls and rises with the speed."""

from dataclasses import dataclass
from typing import Any, Self

from kanefe.arguments import plain_numbers, positive
from kanefe.errors import ModelError
from kanefe.kernels.contact.falling import SteadyNumbers, steady_numbers
from kanefe.kernels.contact.laws.anchoring import Slip, by_anchor, pull_of
from kanefe.kernels.contact.laws.friction_law import AnchoredFriction, Rubbed, Sliding, check_numbers
from kanefe.kernels.language import Record, inlined, norm

STRIBECK = 3.0


class StribeckNumbers(Record):
    """Numbers of `Stribeck`, in its words and units."""

    mu: float
    breakaway: float
    stribeck_speed: float
    exponent: float
    viscous: float
    stiffness: float
    damping: float


@inlined
def stribeck(numbers: Any, at: int, point: Sliding) -> Rubbed:
    """Return what friction gives at a point: see `kanefe.kernels.contact.laws.rub`."""
    own = StribeckNumbers(numbers, at)
    k, c = point.share * own.stiffness, point.share * own.damping
    pull = pull_of(k, c, point)
    N, damping = point.pressed, c + own.viscous * point.pressed
    slip = Slip(own.mu * N, own.breakaway * N, damping, own.stribeck_speed, own.exponent)
    return by_anchor(k, c, pull, norm(pull), point, slip)


@dataclass(frozen=True)
class Stribeck(AnchoredFriction):
    """Dry friction with breakaway, ``T = N (mu + (breakaway - mu) exp(-(s/stribeck_speed)^exponent) + viscous s)``.

    s is the speed of the slip. What sticks hangs on a spring and damper from its anchor, as with `Coulomb`, and begins
    to slip at ``breakaway N``; friction then falls with the speed (Stribeck 1902; Bo & Pavelescu 1982), and rises again
    by what a lubricant adds. `Coulomb` with `static` and `stribeck_speed` is this law with an exponent of 2 and without
    a viscous part.

    Parameters
    ----------
    mu : float
        Coefficient of dry friction in fast sliding.
    breakaway : float
        Coefficient at which it begins to slip, above `mu`.
    stribeck_speed : float
        Speed over which friction falls, m/s.
    exponent : float
        Of the fall: 2, 1 of a steeper one, 0.5 of the steepest.
    viscous : float
        Coefficient over speed, s/m.
    stiffness : float, optional
        Of the anchors of all points together, N/m; default: that of a normal law that is a straight line.
    damping : float, optional
        Of the anchors of all points together, N s/m; default: critical for the masses that move on both sides.

    Raises
    ------
    ModelError
        If `breakaway` is not above `mu`, or a number is none.

    Examples
    --------
    >>> import kanefe as kf
    >>> pad = kf.Stribeck(0.3, breakaway=0.5, stribeck_speed=0.01, exponent=1.0, viscous=0.2)
    >>> round(pad.coefficient(0.0), 3), round(pad.coefficient(0.01), 3), round(pad.coefficient(1.0), 3)
    (0.5, 0.376, 0.5)
    """

    mu: float
    breakaway: float
    stribeck_speed: float
    exponent: float = 2.0
    viscous: float = 0.0
    stiffness: float | None = None
    damping: float | None = None

    kind = STRIBECK
    numbers = StribeckNumbers
    has_memory = True

    def __post_init__(self) -> None:
        check_numbers(self, "mu", "breakaway", "viscous", may_lack=False)
        check_numbers(self, "stiffness", "damping")
        for name in ("stribeck_speed", "exponent"):
            positive(getattr(self, name), f"{name} of Stribeck")
        if self.stiffness == 0.0 or self.damping == 0.0:
            raise ModelError("stiffness and damping of Stribeck must be > 0: they hold a sticking point")
        if not self.breakaway > self.mu:
            raise ModelError(
                f"breakaway of Stribeck, {float(self.breakaway):g}, must be above mu, {float(self.mu):g}. Remedy: "
                "the larger, or Coulomb(mu)"
            )
        plain_numbers(self)

    @property
    def coefficients(self) -> tuple[float, float]:
        """Coefficients of fast dry slip, along and across."""
        return self.mu, self.mu

    @property
    def holding(self) -> float:
        """The coefficient at which it begins to slip."""
        return self.breakaway

    @property
    def steady(self) -> SteadyNumbers:
        """Its coefficients in steady sliding."""
        return steady_numbers(self.mu, self.breakaway, self.stribeck_speed, self.exponent, self.viscous)

    def stuck(self, factor: float) -> Self:
        """Return the law with so many times larger coefficients, under which all sticks."""
        return self.with_numbers(mu=factor * self.mu, breakaway=factor * self.breakaway)
