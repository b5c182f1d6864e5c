"""Units in which one scene can be written: what a metre, a kilogram and a second are in them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Units:
    """A system of units.

    Attributes
    ----------
    length, mass, time : float
        How many units a metre, a kilogram and a second are.

    Examples
    --------
    Millimetres, tonnes and seconds, in which a newton is one and a pascal a millionth:

    >>> mm = Units(length=1e3, mass=1e-3)
    >>> round(mm.force, 12), round(mm.pressure, 12)
    (1.0, 1e-06)
    """

    length: float = 1.0
    mass: float = 1.0
    time: float = 1.0

    @property
    def speed(self) -> float:
        """How many units 1 m/s is."""
        return self.length / self.time

    @property
    def rate(self) -> float:
        """How many units 1 rad/s is."""
        return 1.0 / self.time

    @property
    def acceleration(self) -> float:
        """How many units 1 m/s2 is."""
        return self.length / self.time**2

    @property
    def force(self) -> float:
        """How many units 1 N is."""
        return self.mass * self.acceleration

    @property
    def moment(self) -> float:
        """How many units 1 N m, or 1 J, is."""
        return self.force * self.length

    @property
    def inertia(self) -> float:
        """How many units 1 kg m2 is."""
        return self.mass * self.length**2

    @property
    def stiffness(self) -> float:
        """How many units 1 N/m is."""
        return self.mass / self.time**2

    @property
    def damping(self) -> float:
        """How many units 1 N s/m is."""
        return self.mass / self.time

    @property
    def pressure(self) -> float:
        """How many units 1 Pa is."""
        return self.force / self.length**2

    @property
    def density(self) -> float:
        """How many units 1 kg/m3 is."""
        return self.mass / self.length**3


SI = Units()
MILLIMETRES = Units(length=1e3, mass=1e-3)
"""Units mm, t, s, which imply N and MPa."""
