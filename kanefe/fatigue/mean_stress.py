"""Corrections for the mean stress of cycles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.fatigue.curve import LARGEST_STRESS, LEAST_STRESS
from kanefe.kernels.fatigue.cycle_damage import Correction


class MeanStress:
    """A correction for mean stress: `Goodman`, `Gerber` or `Walker`, which have one parameter each."""

    _correction: ClassVar[int]

    def numbers(self) -> tuple[int, float]:
        """Return which correction it is in kernels, and its parameter."""
        (parameter,) = vars(self).values()
        return self._correction, parameter


@checked
@dataclass(frozen=True)
class Goodman(MeanStress):
    """Goodman's correction: the amplitude counts as ``S_a / (1 - S_m / ultimate)``; pressure on the mean does not help.

    Parameters
    ----------
    ultimate : float
        Ultimate tensile strength, Pa. (With the yield strength it is Soderberg's correction.)
    """

    _correction: ClassVar[int] = Correction.GOODMAN

    ultimate: float

    def __post_init__(self) -> None:
        _check_strength(self.ultimate)


@checked
@dataclass(frozen=True)
class Gerber(MeanStress):
    """Gerber's correction: the amplitude counts as ``S_a / (1 - (S_m / ultimate)^2)`` for a mean stress above zero.

    Parameters
    ----------
    ultimate : float
        Ultimate tensile strength, Pa.
    """

    _correction: ClassVar[int] = Correction.GERBER

    ultimate: float

    def __post_init__(self) -> None:
        _check_strength(self.ultimate)


@checked
@dataclass(frozen=True)
class Walker(MeanStress):
    """Walker's correction, ``(S_m + S_a)^(1 - gamma) S_a^gamma``; with 1/2 that of Smith, Watson and Topper.

    Parameters
    ----------
    gamma : float
        Between 0 and 1; 1: mean stress has no influence.
    """

    _correction: ClassVar[int] = Correction.WALKER

    gamma: float = 0.5

    def __post_init__(self) -> None:
        if not 0.0 <= self.gamma <= 1.0:
            raise ModelError(f"gamma of Walker's correction is between 0 and 1, not {self.gamma:g}")


def _check_strength(ultimate: float) -> None:
    if not LEAST_STRESS <= ultimate <= LARGEST_STRESS:
        raise ModelError(f"an ultimate strength cannot be {ultimate:g} Pa. Remedy: give it in Pa, 500e6 for 500 MPa")
