"""Damage of a stress history: its cycles by rainflow, and Miner's sum over them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.fatigue.curve import SNCurve
from kanefe.fatigue.mean_stress import MeanStress
from kanefe.frames import numbers
from kanefe.kernels.fatigue.cycle_damage import Correction, DamageLaw, damage_of_cycle
from kanefe.kernels.values.filled import filled_from

MOST_BINS = 100_000
"""Largest number of bins of a histogram."""

STRAINS = (1e-6, 1.0)
"""Between these, the largest value of a history is taken for a strain, not a stress in Pa; below is round-off."""


@dataclass(frozen=True, eq=False)
class Cycles:
    """Cycles of a history, in the order in which they are closed.

    Attributes
    ----------
    ranges, means : ndarray, shape (cycles,)
        In the unit of the history.
    counts : ndarray, shape (cycles,)
        1, or 1/2 for half a cycle.
    """

    ranges: np.ndarray
    means: np.ndarray
    counts: np.ndarray

    def table(self) -> list[tuple[float, float]]:
        """Return pairs of a range and the number of its cycles, ascending."""
        sizes, which = np.unique(self.ranges, return_inverse=True)
        return list(zip(sizes.tolist(), np.bincount(which, self.counts).tolist(), strict=True))

    @checked
    def histogram(self, bins: int = 64) -> tuple[np.ndarray, np.ndarray]:
        """Return the numbers of cycles (bins,) in bins of equal width, and the edges of the ranges (bins + 1,)."""
        if not 1 <= bins <= MOST_BINS:
            raise ModelError(f"a histogram has 1 to {MOST_BINS} bins, not {bins}")
        return np.histogram(self.ranges, bins, (0.0, float(self.ranges.max(initial=0.0)) or 1.0), weights=self.counts)


@dataclass(frozen=True, eq=False)
class Damage:
    """Damage of a history by Miner's rule.

    Attributes
    ----------
    total : float
        Share of the life that the history uses up; at 1 a crack is expected.
    cycles : Cycles
    of_cycles : ndarray, shape (cycles,)
        Share of each cycle, with its count.
    """

    total: float
    cycles: Cycles
    of_cycles: np.ndarray

    @property
    def repeats(self) -> float:
        """How often the history can be repeated."""
        return 1.0 / self.total if self.total > 0.0 else np.inf

    def __str__(self) -> str:
        if not self.total > 0.0:
            return f"damage 0: all of {self.cycles.counts.sum():g} cycles are below the endurance limit"
        worst = int(self.of_cycles.argmax())
        return (
            f"damage {self.total:.3g}, {self.repeats:.3g} repeats; {self.cycles.counts.sum():g} cycles, the range "
            f"{self.cycles.ranges[worst] / 1e6:.4g} MPa about {self.cycles.means[worst] / 1e6:.4g} MPa does "
            f"{self.of_cycles[worst] / self.total:.0%}"
        )


@checked()
def count_cycles(history: np.ndarray) -> Cycles:
    """Return the cycles of a history of any quantity, by rainflow counting (ASTM E1049-85, 5.4.4).

    Parameters
    ----------
    history : array_like, shape (T,)

    Raises
    ------
    ModelError
        If the history is not a row of finite numbers.
    MissingDependency
        If rainflow is not installed.

    Examples
    --------
    >>> count_cycles([-2, 1, -3, 5, -1, 3, -4, 4, -2]).table()
    [(3.0, 0.5), (4.0, 1.5), (6.0, 0.5), (8.0, 1.0), (9.0, 0.5)]
    """
    from kanefe.fatigue._rainflow import cycles_of

    return Cycles(*cycles_of(_checked_history(history)).T)


@checked("curve", "mean_stress")
def damage(history: np.ndarray, curve: SNCurve, *, mean_stress: MeanStress | None = None) -> Damage:
    """Return the damage of a stress history by Miner's rule.

    Parameters
    ----------
    history : array_like, shape (T,)
        Stress in Pa; a strain of a gauge times Young's modulus.
    curve : SNCurve
    mean_stress : Goodman, Gerber or Walker, optional
        Default: mean stress is not regarded, as for welded details.

    Raises
    ------
    ModelError
        If the history is not a row of finite numbers or cannot be a stress in Pa, or a cycle alone breaks the material.
    MissingDependency
        If rainflow is not installed.

    Examples
    --------
    >>> steel = SNCurve(amplitude=160e6, cycles=1e6, slope=5)
    >>> t = np.linspace(0.0, 10.0, 1001)
    >>> print(damage(320e6 * np.sin(2 * np.pi * t), steel))
    damage 0.000314, 3.19e+03 repeats; 10 cycles, the range 640 MPa about 0 MPa does 10%
    """
    stress = _checked_history(history)
    largest = float(np.abs(stress).max())
    if STRAINS[0] < largest < STRAINS[1]:
        raise ModelError(
            f"the history has at most {largest:.3g}, which is a strain rather than a stress in Pa. Remedy: multiply it "
            "by Young's modulus in Pa"
        )
    cycles = count_cycles(stress)
    law = DamageLaw(law_of(curve, mean_stress))
    pairs = zip((0.5 * cycles.ranges).tolist(), cycles.means.tolist(), strict=True)
    shares = cycles.counts * np.array([damage_of_cycle(amplitude, mean, law) for amplitude, mean in pairs])
    if not np.isfinite(shares).all():
        raise ModelError(
            f"a mean stress of {cycles.means.max() / 1e6:.4g} MPa breaks the material at once: it is above the "
            "ultimate strength. Remedy: check the strength and the stress, both in Pa"
        )
    return Damage(float(shares.sum()), cycles, shares)


def law_of(curve: SNCurve, mean_stress: MeanStress | None) -> np.ndarray:
    """Return the numbers of curve and correction, as `kanefe.kernels.fatigue.cycle_damage` takes them."""
    correction, parameter = (Correction.NONE, 0.0) if mean_stress is None else mean_stress.numbers()
    return filled_from(curve, DamageLaw, correction=correction, parameter=parameter)


def _checked_history(history: np.ndarray) -> np.ndarray:
    found = numbers(history)
    if found.ndim != 1 or len(found) < 2 or not np.isfinite(found).all():
        raise ModelError(
            f"a history must be a row of at least two finite numbers, not of the shape {found.shape}. Remedy: one "
            "gauge or one column, such as strains[:, 0]"
        )
    return found
