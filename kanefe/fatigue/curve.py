"""S-N curves: how many cycles of a stress amplitude a material bears."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError

LEAST_STRESS, LARGEST_STRESS = 1e5, 1e11
"""Range of amplitudes at the knee of an S-N curve, Pa. Those of metals, plastics and fibres are 1 MPa to 5 GPa,
so that a number in MPa is below it."""


@checked
@dataclass(frozen=True)
class SNCurve:
    """Basquin's S-N curve, ``N = cycles (S / amplitude)^-slope``, with another slope below its knee.

    Parameters
    ----------
    amplitude : float
        Stress amplitude at the knee, Pa: half the range.
    cycles : float
        Number of cycles at the knee.
    slope : float
        Exponent above the knee, at least 1.
    slope_below : float, optional
        Exponent below the knee, at least `slope`: ``2 * slope - 1`` by Haibach, `slope` by Miner's elementary rule.
        Default: infinite, cycles below the knee do no damage.

    Raises
    ------
    ModelError
        If a number is out of range; an amplitude in MPa is named as such.

    Examples
    --------
    >>> steel = SNCurve(amplitude=160e6, cycles=1e6, slope=5, slope_below=9)
    >>> steel.life(320e6)
    31250.0
    >>> detail = SNCurve.from_range(71e6, 2e6, slope=3)  # a welded detail, of which ranges are given
    >>> detail.amplitude
    35500000.0
    """

    amplitude: float
    cycles: float
    slope: float
    slope_below: float = math.inf

    def __post_init__(self) -> None:
        if not LEAST_STRESS <= self.amplitude <= LARGEST_STRESS:
            raise ModelError(
                f"the amplitude of an S-N curve cannot be {self.amplitude:g} Pa. Remedy: give it in Pa, "
                "160e6 for 160 MPa"
            )
        if self.cycles < 1.0:
            raise ModelError(f"the cycles of an S-N curve must be at least 1, not {self.cycles:g}")
        if self.slope < 1.0 or self.slope_below < self.slope:
            raise ModelError(
                f"the slopes of an S-N curve are at least 1, and below the knee at least as above, not {self.slope:g} "
                f"and {self.slope_below:g}. Remedy: positive exponents, 5 where the curve is N ~ S^-5"
            )

    @classmethod
    @checked
    def from_range(cls, stress_range: float, cycles: float, slope: float, slope_below: float = math.inf) -> SNCurve:
        """Return the curve that has a stress range (Pa) at its knee, twice the amplitude."""
        return cls(0.5 * stress_range, cycles, slope, slope_below)

    @checked
    def life(self, amplitude: float | np.ndarray) -> np.ndarray:
        """Return how many cycles of an amplitude (Pa) are borne, without mean stress."""
        size = np.asarray(amplitude, dtype=float) / self.amplitude
        with np.errstate(divide="ignore", over="ignore"):
            return np.where(size >= 1.0, self.cycles * size**-self.slope, self.cycles * size**-self.slope_below)[()]
