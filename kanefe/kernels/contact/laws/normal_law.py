"""Interface of normal laws for compiled code, contacts, scenes and runs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.kernels.force_elements.blocks import flat

STEP = 1e-30
"""Imaginary step of a depth, m: a step this small has no truncation error."""


class Pressed(NamedTuple):
    """What a law gives: force (N), the part of it that is elastic, and the energy of that (J)."""

    force: float
    elastic: float
    potential: float


class NormalLaw(ABC):
    """A normal force on what is a depth within a surface.

    A law is a file beside this one: a class for the user, which checks what it is given and has it as a named `block`
    of numbers, and the function of these numbers that is compiled, called by `normal_force` of the table of laws.

    Attributes
    ----------
    kind : float
        By which `normal_force` knows the law.
    law : function
        (numbers, at, share, depth, rate, more, branch) -> force, elastic part, its energy, and rate of the branch, as
        `normal_force` of the table of laws has them; a force below 0 does not act.
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
    law: ClassVar[Callable[..., Any]]
    has_impact: ClassVar[bool] = False
    has_branch: ClassVar[bool] = False
    impact_number: float = 0.0
    least_speed: float = 1.0
    stiffness: float
    damping: float

    @property
    @abstractmethod
    def block(self) -> tuple[Any, ...]:
        """Its numbers for compiled code."""

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
        force, elastic, energy, _ = self._pressed(d, rate, share, more)
        return Pressed(max(0.0, float(force)), float(elastic), float(energy))

    def slope(self, d: float, share: float = 1.0) -> float:
        """Return how fast the force at rest grows with the depth d > 0 (m) of a point with a share of it, N/m."""
        return float(self._pressed(complex(d, STEP), 0.0 * 1j, share, 0.0)[0].imag) / STEP

    def _pressed(self, d: Any, rate: Any, share: float, more: float) -> Any:
        return self.law(flat(self.block).tolist(), 0, share, d, rate, more, 0.0)

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
