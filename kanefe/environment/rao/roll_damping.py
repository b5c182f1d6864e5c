"""Additional roll damping: potential theory neglects that of bilge keels and of the friction of the hull."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kanefe.environment.checks import checked_number
from kanefe.environment.dispersion import encounter_frequency, wave_number
from kanefe.environment.rao.rao import MotionRao
from kanefe.errors import ModelError
from kanefe.frames import Vector

BESIDE = 2
"""Number of points on either side of the largest roll through which the response of one degree of freedom is fitted."""


@dataclass(frozen=True)
class RollDamping:
    """The roll damping of a ship, in place of that of its RAO.

    Roll near its resonance is taken as motion with one degree of freedom: ``wn^2 - we^2 + 2 i z wn we`` times the roll
    is the moment of the waves, which is the same with the new ratio z. The coupling with sway and yaw is not changed.

    Parameters
    ----------
    ratio : float
        Ratio of the total to the critical roll damping.
    frequency : float, optional
        Natural frequency of roll wn, rad/s.
    ratio_of_rao : float, optional
        Damping ratio of the RAO. If both are None, they are fitted by least squares to the peak of the RAO's roll in
        the seas closest to beam seas, at the lowest speed.

    Raises
    ------
    ModelError
        If a number is not above zero, or a ratio not below one.

    Examples
    --------
    >>> import kanefe as kf
    >>> damping = kf.RollDamping(0.08, frequency=0.43, ratio_of_rao=0.03)
    """

    ratio: float
    frequency: float | None = None
    ratio_of_rao: float | None = None

    def __post_init__(self) -> None:
        for name in ("ratio", "frequency", "ratio_of_rao"):
            value = getattr(self, name)
            if value is not None or name == "ratio":
                number = checked_number(value, f"{name} of a RollDamping", above=0.0)
                object.__setattr__(self, name, number)
                if name != "frequency" and number >= 1.0:
                    raise ModelError(
                        f"{name} of a RollDamping must be below 1, critical damping, above which a ship does not "
                        f"roll, not {number:g}. Remedy: {number / 100.0:g} for {number:g} %"
                    )

    def fitted(self, rao: MotionRao) -> RollDamping:
        """Return the damping with natural frequency and ratio of an RAO.

        Raises
        ------
        ModelError
            If they are not given and its roll has no peak of one degree of freedom.
        """
        if self.frequency is not None and self.ratio_of_rao is not None:
            return self
        frequency, ratio = roll_resonance(rao)
        return RollDamping(self.ratio, self.frequency or frequency, self.ratio_of_rao or ratio)

    def factor(self, encounter: Vector) -> np.ndarray:
        """Return the factor on roll at encounter frequencies in rad/s, for a fitted damping."""
        wn, of_rao = self.frequency or 1.0, self.ratio_of_rao or self.ratio
        stiff = wn**2 - encounter**2
        return np.asarray((stiff + 2j * of_rao * wn * encounter) / (stiff + 2j * self.ratio * wn * encounter))


def roll_resonance(rao: MotionRao) -> tuple[float, float]:
    """Return natural frequency (rad/s) and damping ratio of the roll of an RAO, by least squares about its peak.

    With one degree of freedom, the inverse square of the roll per slope is ``c ((wn^2 - we^2)^2 + (2 z wn we)^2)``, a
    polynomial of the second degree in we^2.

    Raises
    ------
    ModelError
        If the peak is at an end of the RAO, or the roll about it is not that of one degree of freedom.
    """
    heading = int(np.argmax(abs(np.sin(np.radians(rao.headings_deg)))))
    number = wave_number(rao.frequencies, rao.depth)
    squares = (abs(rao.values[0, heading, :, 3]) / number) ** 2
    met = encounter_frequency(rao.frequencies, number, float(rao.headings_deg[heading]), float(rao.speeds[0]))
    peak = int(np.argmax(squares))
    unknown = "Remedy: RollDamping(ratio, frequency=..., ratio_of_rao=...)"
    if not 0 < peak < len(squares) - 1:
        raise ModelError(
            f"the roll of {rao.name} has no peak within its frequencies from which to find its damping. {unknown}"
        )
    near = slice(max(peak - BESIDE, 0), peak + BESIDE + 1)
    # rows are weighted by the squares themselves, for relative errors
    terms = squares[near, None] * np.power.outer(met[near] ** 2, np.arange(3))
    (free, first, second), *_ = np.linalg.lstsq(terms, np.ones(len(terms)), rcond=None)
    fourth = free / second
    natural = fourth**0.25 if fourth > 0.0 else 0.0
    damped = first / second + 2.0 * natural**2
    low, high = np.sort(met[[near.start, min(near.stop, len(met)) - 1]])
    if not (low < natural < high and damped > 0.0):
        raise ModelError(f"the roll of {rao.name} about its peak is not that of one degree of freedom. {unknown}")
    return float(natural), float(math.sqrt(damped) / (2.0 * natural))
