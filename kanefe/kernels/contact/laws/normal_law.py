"""Interface of normal laws for compiled code, contacts, scenes and runs."""

from abc import ABC
from collections import namedtuple
from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.kernels.language import Record
from kanefe.kernels.values.filled import filled_from

STEP = 1e-30
"""Imaginary step of a depth, m: a step this small has no truncation error."""


class Pressed(NamedTuple):
    """Answer of a law: force (N), the part of it that is elastic, the energy of that (J), the branch's rate (1/s)."""

    force: float
    elastic: float
    potential: float


Pressing = namedtuple("Pressing", "share depth rate more branch")
"""Question to a law: the share of the contact that a point has; its depth, m, above 0, and the rate of that,
m/s; what an impact added to the damping; and the branch of a hysteresis, -1 to 1."""

NormalForce = namedtuple("NormalForce", "force elastic energy branch_rate")
"""Answer of a law: force and the elastic part of it (N), the energy of that (J), the rate of the branch (1/s)."""


class NormalLaw(ABC):
    """A normal force on what is a depth within a surface.

    A law is a file beside this one: a class for the user, which checks what it is given, a record of its numbers, which
    are its attributes, and the function of these that is compiled, called by `normal_force` of the table of laws.

    Attributes
    ----------
    kind : float
        By which `normal_force` knows the law.
    numbers : Record
    law : function
        (numbers, at, `Pressing`) -> `NormalForce`, of a list of numbers and where its own begin; a force below 0 does
        not act.
    stiffness : float
        What counts as such, N/m^exponent; of all points of a contact together, which share it.
    damping : float
    has_impact : bool
        Whether the contact has a state that an impact sets, and that is added to the damping: `impact_number` over its
        speed (m/s), of which `least_speed` counts at least.
    has_branch : bool
        Whether each point has a state with a rate: the branch of a hysteresis it is on, -1 to 1.
    """

    kind: ClassVar[float] = 0.0
    numbers: ClassVar[type[Record]]
    law: ClassVar[Callable[..., Any]]
    has_impact: ClassVar[bool] = False
    has_branch: ClassVar[bool] = False
    impact_number: float = 0.0
    least_speed: float = 1.0
    stiffness: float
    damping: float

    @property
    def block(self) -> np.ndarray:
        """Its numbers for compiled code."""
        return filled_from(self, self.numbers)

    @property
    def straight(self) -> float | None:
        """Its one stiffness, N/m; None: it is no straight line."""
        return None

    def pressed(self, d: float, rate: float = 0.0, share: float = 1.0, damping: float | None = None) -> Pressed:
        """Return the force at a depth and its rate.

        Parameters
        ----------
        d : float
            Depth, m, above 0.
        rate : float
            Its rate, m/s.
        share : float
            Of the stiffness, that a point has.
        damping : float, optional
            In place of its own.
        """
        more = 0.0 if damping is None else damping - self.damping
        found = self._pressed(d, rate, share, more)
        return Pressed(max(0.0, float(found.force)), float(found.elastic), float(found.energy))

    def slope(self, d: float, share: float = 1.0) -> float:
        """Return how fast the force at rest grows with the depth d > 0 (m) of a point with a share of it, N/m."""
        return float(self._pressed(complex(d, STEP), 0.0 * 1j, share, 0.0).force.imag) / STEP

    def _pressed(self, d: Any, rate: Any, share: float, more: float) -> NormalForce:
        return self.law(self.block.tolist(), 0, Pressing(share, d, rate, more, 0.0))  # type: ignore[no-any-return]

    def _set(self, **values: Any) -> None:
        """Write attributes of a law that is frozen, as it is made."""
        for name, value in values.items():
            object.__setattr__(self, name, value)


def normal_law(given: object, label: str) -> NormalLaw:
    """Return a law of normal force; a ModelError says that it is none."""
    if not isinstance(given, NormalLaw):
        raise ModelError(f"normal of {label} must be a law such as kanefe.HuntCrossley(1e6), not {given!r}")
    return given


def not_negative(value: object, what: str) -> float:
    """Return a finite number of at least zero; a ModelError names what it is."""
    number = numbers(value)
    if number.shape != () or not np.isfinite(number) or number < 0.0:
        raise ModelError(f"{what} must be one number, finite and >= 0, not {value!r}")
    return float(number)
