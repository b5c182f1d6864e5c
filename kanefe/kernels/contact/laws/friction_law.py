"""Interface of friction laws for compiled code, contacts, scenes and runs."""

from abc import ABC, abstractmethod
from collections import namedtuple
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, ClassVar, Self

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Vector, numbers
from kanefe.kernels.contact.falling import SteadyNumbers, steady_coefficient, steady_numbers
from kanefe.kernels.language import Record
from kanefe.kernels.values.filled import filled_from

STIFFNESS_RATIO = 1.0
"""Default stiffness of an anchor relative to that of the normal law."""

Sliding = namedtuple("Sliding", "share pressed normal A_s along stretch is_held waits rests")
"""Question to a law, about a point that touches: its share of the contact; the normal force, N; the normal, and the
axes of the surface, in N; the velocity along the surface, m/s, and the stretch, m, in N; whether it sticks as far as
that is remembered; whether an event ends the sticking, see `kanefe.kernels.constraints.tolerances.HELD_BEYOND`; and
whether the stretch follows the motion from a state of rest."""

Rubbed = namedtuple("Rubbed", "force stretch_rate stiffness slip beyond")
"""Answer of a law: friction, N, against the motion; the rate of the stretch, m/s; the stiffness whose energy is in the
stretch, N/m; the speed of the slip, m/s; and the pull beyond what friction holds, or what of it slips, N."""


class FrictionLaw(ABC):
    """A law of friction at a point of a contact: what a stretch along the surface and the motion give there.

    A law is a file beside this one: a class for the user, which checks what it is given, a record of its numbers, which
    are its attributes, and the function of these that is compiled, called by `rub` of the table of laws. A point has
    three internal states for it, the stretch in axes of the surface, m.

    Attributes
    ----------
    kind : float
        By which `rub` knows the law.
    numbers : Record
    holds : bool
        Whether what sticks stays where it is: it slips and sticks at moments that a run tells. Else it creeps.
    has_memory : bool
        Whether the coefficients of slip and stick differ, so that a state stores the status.
    turning_states : int
        States of what holds a point against turning.
    axis : ndarray, shape (3,), or None
        The direction of the first of two coefficients, in axes of the surface; None: there is but one.
    spring : float
        Stiffness of the spring of all points together whose energy counts, N/m; 0: none does.
    lacks_damping : bool
        Whether the damping of its anchors is to be that of the masses that they hold.
    at_most : (float, float) or None
        Stiffness and damping of all points that stick; None: unknown before the run.
    not_rigid, not_screened : str
        What of it rigid contacts do not have, with a remedy, and screened runs; empty: they have all.
    """

    kind: ClassVar[float]
    numbers: ClassVar[type[Record]]
    holds: ClassVar[bool] = False
    has_memory: bool = False
    turning_states: int = 0
    torsional: float = 0.0
    rolling: float = 0.0
    axis: Vector | None = None
    spring: float = 0.0
    lacks_damping: bool = False
    at_most: tuple[float, float] | None = None
    not_rigid: str = "friction of rigid contacts is Coulomb's. Remedy: kanefe.Coulomb(...)"
    not_screened: str = "friction that creeps"

    @property
    def block(self) -> np.ndarray:
        """Its numbers for compiled code; what it lacks yet counts as zero."""
        return filled_from(self, self.numbers)

    @property
    @abstractmethod
    def coefficients(self) -> tuple[float, float]:
        """Coefficients of slip, along and across."""

    @property
    def sliding(self) -> float:
        """The larger coefficient of slipping."""
        return max(self.coefficients)

    @property
    @abstractmethod
    def holding(self) -> float:
        """The coefficient at which it begins to slip, of two the larger."""

    @property
    def steady(self) -> SteadyNumbers:
        """Its coefficients in steady sliding, for compiled code: those of Coulomb's law, unless a law has others."""
        return steady_numbers(self.sliding, self.holding)

    @abstractmethod
    def coefficient(self, speed: float) -> float:
        """Return the coefficient of friction in steady sliding at a speed, m/s."""

    @property
    @abstractmethod
    def relaxation(self) -> float:
        """Rate at which the stretch of a point comes back that does not touch, 1/s."""

    @abstractmethod
    def anchor(self, share: float, normal_force: float) -> tuple[float, float]:
        """Return stiffness and damping of a point that sticks, with a share of the contact and a normal force."""

    @abstractmethod
    def large_stretch(self, weight: float) -> float:
        """Return what counts as a large stretch under a weight (N), m."""

    def arms(self, lever: float) -> list[float]:
        """Return the lever by which the anchor of each turning state acts, of a point with one to roll on, m."""
        return []

    def completed(self, stiffness: float | None, levers: Sequence[float], label: str) -> Self:
        """Return the law of a contact: `stiffness` of a normal law that is a straight line, levers of its points."""
        return self

    def with_damping(self, damping: float) -> Self:
        """Return the law with the damping that it lacks, N s/m."""
        return self

    def stuck(self, factor: float) -> Self:
        """Return the law with so many times larger coefficients, under which all sticks, where something may."""
        return self


class AnchoredFriction(FrictionLaw):
    """Friction of what hangs on a spring and damper from its anchor, which moves only when it slips.

    Attributes
    ----------
    stiffness, damping : float or None
        Of all points together, N/m and N s/m; None: those of the contact.
    """

    holds = True
    stiffness: float | None
    damping: float | None

    @property
    def relaxation(self) -> float:
        """Rate at which the stretch of a point comes back that does not touch, 1/s."""
        k, c = self.anchor(1.0, 0.0)
        return k / c if c > 0.0 else 0.0  # of a law that is not completed

    @property
    def spring(self) -> float:  # type: ignore[override]
        """Stiffness of the springs of all points together, N/m."""
        return float(self.stiffness or 0.0)

    def anchor(self, share: float, normal_force: float) -> tuple[float, float]:
        """Return stiffness and damping of a point."""
        return share * float(self.stiffness or 0.0), share * float(self.damping or 0.0)

    def large_stretch(self, weight: float) -> float:
        """Return the stretch that holds it."""
        return self.sliding * weight / float(self.stiffness or 1.0) or 1.0

    def completed(self, stiffness: float | None, levers: Sequence[float], label: str) -> Self:
        """Return the law with the stiffness of the normal law, where none is given; a ModelError says what it lacks.

        Bodies in contact yield alike in both directions, by Mindlin's theory along the surface at (1 - nu/2)/(1 - nu)
        of what they do across it.
        """
        if self.rolling > 0.0 and min(levers) <= 0.0:
            raise ModelError(f"{label} has points, which do not roll. Remedy: rolling=0, or balls, capsules, tori")
        if self.stiffness is not None:
            return self
        if stiffness is None:
            raise ModelError(
                f"{label}: the normal law has no single stiffness for the friction anchors. "
                f"Remedy: stiffness= of {type(self).__name__}"
            )
        return self.with_numbers(stiffness=STIFFNESS_RATIO * stiffness)

    def with_numbers(self, **changes: Any) -> Self:
        """Return the law with other numbers."""
        return replace(self, **changes)  # type: ignore[type-var]

    def with_damping(self, damping: float) -> Self:
        """Return the law with a damping of all points together, N s/m."""
        return self.with_numbers(damping=damping)

    @property
    @abstractmethod
    def steady(self) -> SteadyNumbers:
        """Its coefficients in steady sliding, for compiled code."""

    def coefficient(self, speed: float) -> float:
        """Return the larger coefficient of slipping at a speed (m/s)."""
        return float(steady_coefficient(self.steady, speed))

    @property
    def lacks_damping(self) -> bool:  # type: ignore[override]
        """Whether the damping of its anchors is to be that of the masses that they hold."""
        return self.damping is None

    @property
    def at_most(self) -> tuple[float, float] | None:  # type: ignore[override]
        """Stiffness and damping of all points that stick."""
        return self.anchor(1.0, 0.0)

    @property
    def not_rigid(self) -> str:  # type: ignore[override]
        """What of it rigid contacts do not have, with a remedy."""
        if len(set(self.coefficients)) > 1:
            return "friction of rigid contacts is the same in all directions. Remedy: one coefficient"
        if self.stiffness is not None or self.damping is not None:
            return "rigid contacts stick without springs. Remedy: leave out stiffness and damping"
        if self.turning_states:
            return "rigid contacts slip, but turn freely. Remedy: kanefe.HuntCrossley(...)"
        return ""

    @property
    def not_screened(self) -> str:  # type: ignore[override]
        """What of it screened runs do not have."""
        return "friction against turning" if self.turning_states else ""


def friction_law(given: object, label: str) -> FrictionLaw | None:
    """Return a law of friction, or None; a ModelError says that it is none."""
    if given is not None and not isinstance(given, FrictionLaw):
        raise ModelError(f"friction of {label} must be a law such as kanefe.Coulomb(0.3), or None, not {given!r}")
    return given


def check_numbers(law: object, *names: str, may_lack: bool = True) -> None:
    """Raise a ModelError if an attribute of a law is no number that is finite and >= 0, nor None where it may lack."""
    for name in names:
        value = getattr(law, name)
        number = numbers(0.0 if value is None and may_lack else value)
        if number.shape != () or not 0.0 <= number < float("inf"):
            raise ModelError(f"{name} of {type(law).__name__} must be one number, finite and >= 0, not {value!r}")
