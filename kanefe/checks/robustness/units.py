"""Systems of units in which the same scene can be written."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Units:
    """A system of units.

    Attributes
    ----------
    length, mass, time : float
        Value of 1 m, 1 kg and 1 s in these units.

    Examples
    --------
    Millimetres, tonnes and seconds, in which 1 N is 1 and 1 Pa is 1e-6:

    >>> mm = Units(length=1e3, mass=1e-3)
    >>> round(mm.force, 12), round(mm.pressure, 12)
    (1.0, 1e-06)
    """

    length: float = 1.0
    mass: float = 1.0
    time: float = 1.0

    @property
    def speed(self) -> float:
        """Value of 1 m/s in these units."""
        return self.length / self.time

    @property
    def rate(self) -> float:
        """Value of 1 rad/s in these units."""
        return 1.0 / self.time

    @property
    def acceleration(self) -> float:
        """Value of 1 m/s2 in these units."""
        return self.length / self.time**2

    @property
    def force(self) -> float:
        """Value of 1 N in these units."""
        return self.mass * self.acceleration

    @property
    def moment(self) -> float:
        """Value of 1 N m, or 1 J, in these units."""
        return self.force * self.length

    @property
    def inertia(self) -> float:
        """Value of 1 kg m2 in these units."""
        return self.mass * self.length**2

    @property
    def stiffness(self) -> float:
        """Value of 1 N/m in these units."""
        return self.mass / self.time**2

    @property
    def damping(self) -> float:
        """Value of 1 N s/m in these units."""
        return self.mass / self.time

    @property
    def pressure(self) -> float:
        """Value of 1 Pa in these units."""
        return self.force / self.length**2

    @property
    def density(self) -> float:
        """Value of 1 kg/m3 in these units."""
        return self.mass / self.length**3


SI = Units()
MILLIMETRES = Units(length=1e3, mass=1e-3)
"""mm, t, s, N and MPa."""
