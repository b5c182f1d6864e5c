"""A ship in a sea: motions of its decks, and their statistics."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from kanefe._public import served
from kanefe.arguments import checked
from kanefe.environment.checks import checked_number
from kanefe.environment.deck_motion import DeckMotion
from kanefe.environment.directional import DirectionalTable
from kanefe.environment.dispersion import encounter_frequency, wave_number
from kanefe.environment.harmonics import Harmonics, Ramp
from kanefe.environment.rao.rao import NAMES, MotionRao, at_point
from kanefe.environment.rao.rao_files import read_rao
from kanefe.environment.rao.rao_grid import FULL_CIRCLE
from kanefe.environment.rao.roll_damping import RollDamping
from kanefe.environment.sea import Sea
from kanefe.environment.spectra import gauss
from kanefe.environment.spreading import Spreading
from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.frames import Vector, numbers, shaped_numbers

SLOWEST_HZ = 0.03
"""Encounter frequency below which surge, sway and yaw are left out, Hz: strip theory has no restoring force in them, so
that they are unbounded there; in reality they are controlled by helmsmen or autopilots."""

HORIZONTAL = np.array((0, 1, 5))
"""Indices of surge, sway and yaw."""

REPORTED = 0.01
"""Fraction of the variance of a motion that may be left out without a warning."""

DIRECTIONS = 90
"""Number of parts of equal energy into which spreading waves are divided."""

COURSES = 32
"""Number of courses for which the neglected parts are cached: the seeds and sea states of a map share courses.
"""

STEPS = 12
"""Number of steps of each piece of an RAO between its frequencies, over which responses are integrated by four-point
Gauss quadrature."""


@dataclass(frozen=True, eq=False)
class Ship:
    """A ship on a steady course in a sea, with motions by its response amplitude operators.

    Ship axes: x forward, y to port, z up. Motions are relative to axes that move with the ship's mean speed. Points are
    given from the RAO's reference point, which is the centre of gravity in most programs (``print(ship)`` shows it).

    Parameters
    ----------
    rao : MotionRao
    sea : Sea
    speed : float
        m/s; motions are interpolated between the speeds of the RAO.
    heading_deg : float
        0: head seas, 90: from port, 180: following; -360 to 360. Beyond 180, motions of a symmetric ship are mirrored.
    slowest_hz : float
        Encounter frequency (Hz) below which surge, sway and yaw are left out; zero: nothing is left out.

    Raises
    ------
    ModelError
        If speed, heading or the waves of the sea are outside of the range of the RAO.

    Warns
    -----
    AccuracyWarning
        If more than a hundredth of the variance of surge, sway or yaw is left out, or the depth of the water differs
        between sea and RAO.

    Examples
    --------
    From a file: ``Ship.from_rao("s175.re1", speed=5.1444, heading_deg=60, sea=sea)``. With the example RAO:

    >>> import kanefe as kf
    >>> ship = kf.Ship(kf.example_rao(), kf.Sea.state(5, spreading=2, seed=7), heading_deg=60)
    >>> scene = kf.System(gravity=(0, 0, -9.81))
    >>> deck = scene.add_frame("deck", joint=kf.Free(motion=ship.at((-45, 0, 6))))

    Recorded motions of a deck, such as at 20 Hz, are given as a `PoseTable`:

    >>> times = np.arange(0.0, 10.0, 0.05)
    >>> record = ship.motions(times)[:, 0]  # surge, sway, heave, roll, pitch, yaw
    >>> turns = [kf.euler_angles("ZYX", angles[::-1]) for angles in record[:, 3:]]
    >>> joint = kf.Free(motion=kf.PoseTable(times, record[:, :3], turns))
    """

    rao: MotionRao
    sea: Sea
    speed: float = 0.0
    heading_deg: float = 0.0
    slowest_hz: float = SLOWEST_HZ

    def __post_init__(self) -> None:
        for name, given, kind in (("rao", self.rao, MotionRao), ("sea", self.sea, Sea)):
            if not isinstance(given, kind):
                raise ModelError(f"{name} of a ship must be a {kind.__name__}, not {given!r}")
        object.__setattr__(self, "heading_deg", checked_number(self.heading_deg, "heading_deg of a ship"))
        if abs(self.heading_deg) > FULL_CIRCLE:
            raise ModelError(f"heading_deg of a ship must be -360 to 360 degrees, not {self.heading_deg!r}")
        for name in ("speed", "slowest_hz"):
            object.__setattr__(self, name, checked_number(getattr(self, name), f"{name} of a ship", least=0.0))
        self._refuse_waves_outside()
        if self.rao.depth != self.sea.depth:
            warnings.warn(
                f"{self.rao.name} is for water of {self.rao.depth:g} m depth, the sea is {self.sea.depth:g} m deep. "
                "Remedy: an RAO for that depth; for waves shorter than twice both depths there is no difference",
                AccuracyWarning,
                stacklevel=outside(),
            )
        left = self.left_out
        if max(left.values(), default=0.0) > REPORTED:
            shares = ", ".join(f"{name} {100 * share:.2g} %" for name, share in left.items() if share > REPORTED)
            warnings.warn(
                f"horizontal motions slower than {self.slowest_hz:g} Hz are left out, with this share of the variance: "
                f"{shares}. Remedy: slowest_hz=0 to keep them",
                AccuracyWarning,
                stacklevel=outside(),
            )

    @classmethod
    def from_rao(
        cls,
        path: Any,
        *,
        sea: Sea,
        speed: float = 0.0,
        heading_deg: float = 0.0,
        roll_damping: float | RollDamping | None = None,
        slowest_hz: float = SLOWEST_HZ,
        **reading: Any,
    ) -> Ship:
        """Return a ship from the file of its motions in waves.

        Parameters
        ----------
        path : str, Path, xarray.Dataset or MotionRao
            VERES ``.re1``, WAMIT ``.4``, Capytaine ``.nc``, or a table ``.csv`` that declares its convention.
        sea, speed, heading_deg, slowest_hz
            See the class.
        roll_damping : float or RollDamping, optional
            Ratio of the total to the critical roll damping, in place of that of the RAO, which is too small in
            potential flow.
        **reading
            See `kanefe.read_rao`.

        Raises
        ------
        FileError, ModelError
            If the file cannot be read, contradicts its convention, or does not cover the sea.
        """
        rao = path if isinstance(path, MotionRao) else read_rao(path, **reading)
        if isinstance(path, MotionRao) and reading:
            raise ModelError(f"{', '.join(reading)} are options for a file, not for an RAO. Remedy: leave them out")
        if roll_damping is not None:
            damping = roll_damping if isinstance(roll_damping, RollDamping) else RollDamping(roll_damping)
            rao = damped(rao, damping, sea.gravity)
        return cls(rao, sea, speed, heading_deg, slowest_hz)

    @checked("rotations")
    def at(
        self,
        point: Sequence[float] | Vector,
        *,
        duration: float | None = None,
        start: float = 0.0,
        ramp: float = 30.0,
        rotations: str = "exact",
    ) -> DeckMotion:
        """Return the motion of axes fixed to the ship at a point, for `Free(motion=...)`.

        Parameters
        ----------
        point : array_like, shape (3,)
            From the reference point of the RAO, ship axes, m.
        duration : float, optional
            Last time for which it is defined, s; later times are an error. None: ramp plus duration of the sea.
        start : float
            Start of the ramp, s; before it the ship is at rest. The motion is defined from zero on, or from `start` if
            that is negative.
        ramp : float
            Duration of the ramp, s; zero: none. Statistics are taken after it.
        rotations : "exact" or "small"
            With "small" the point moves by linear theory, ``s + theta x point``; the rotation is the same.

        Raises
        ------
        ModelError
            If a number is not valid.
        """
        place = shaped_numbers(point, (3,), "a point of a ship")
        checked_number(start, "the start of a ship's motion")
        checked_number(ramp, "the ramp of a ship's motion", least=0.0)
        last = checked_number(
            start + ramp + self.sea.duration if duration is None else duration, "the duration of a ship's motion"
        )
        first = min(0.0, start)
        if last <= first:
            raise ModelError(f"the duration of a ship's motion must be after {first:g} s, not {duration!r}")
        if rotations not in ("exact", "small"):
            raise ModelError(
                f'rotations of a ship\'s motion are "exact" or "small", not {rotations!r}. Remedy: "exact"'
            )
        return DeckMotion(self.harmonics, place, Ramp(start, ramp), (first, last), rotations == "small")

    @cached_property
    def harmonics(self) -> Harmonics:
        """The six motions of the ship at the reference point in the waves of the sea."""
        waves = self.sea.waves
        headings = self.heading_deg + waves.direction_deg
        met = encounter_frequency(waves.frequency, waves.number, headings, self.speed)
        response = self._filtered(self.rao.at(waves.frequency, headings, self.speed), met)
        return Harmonics(met, response * (waves.amplitude * np.exp(1j * waves.phase))[:, None])

    @checked
    def motions(self, times: Sequence[float] | Vector) -> np.ndarray:
        """Return surge to yaw, with rates and accelerations, at times (s), without ramp, (times, 3, 6), m and rad."""
        return self.harmonics.at(np.atleast_1d(np.asarray(times, dtype=float)))

    @checked
    def response_spectra(self, omega: Sequence[float] | Vector) -> np.ndarray:
        """Return the spectra of surge to yaw over *wave* frequency (rad/s), shape (n, 6), m2 s/rad and rad2 s/rad.

        In following seas several waves have the same frequency of encounter, so that spectra over it would have poles.
        """
        at = np.atleast_1d(numbers(omega))
        if at.ndim != 1:
            raise ModelError(f"omega must be frequencies in rad/s, shape (n,), not of shape {at.shape}")
        return np.asarray(self._mean_square(at) * self.sea.spectrum.density(at)[:, None])

    def motions_std(self, point: Sequence[float] | Vector = (0.0, 0.0, 0.0)) -> dict[str, float]:
        """Return the standard deviations of the motions of a point by name, m and rad, over the range of the RAO.

        Rotations are those of the ship. From the spectral integral, not from one realisation.

        Examples
        --------
        ``ship.motions_std()["roll"]``, ``ship.motions_std((-45, 0, 6))["heave"]``
        """
        place = shaped_numbers(point, (3,), "a point of a ship")
        omega, weights = _over(self.rao.frequencies)
        variances = (weights * self.sea.spectrum.density(omega)) @ self._mean_square(omega, place)
        return dict(zip(NAMES, np.sqrt(variances).tolist(), strict=True))

    @cached_property
    def left_out(self) -> dict[str, float]:
        """Share of the variance of surge, sway and yaw below `slowest_hz`, by name; 0 to 1."""
        omega, weights = _over(self.rao.frequencies)
        weights = weights * self.sea.spectrum.density(omega)
        slow, whole = (weights @ part for part in _horizontal(self._course, self.slowest_hz))
        shares = np.divide(slow, whole, out=np.zeros(len(whole)), where=whole > 0.0)
        return {NAMES[k]: float(share) for k, share in zip(HORIZONTAL, shares, strict=True)}

    @checked
    def plot_rao(self, path: str | Path | None = None) -> Any:
        """Return a plot of the RAO at the ship's speed: amplitude and phase of each motion over wave frequency.

        Wrong phases show at the left end, where waves are long: circles mark the motions of the surface.

        Parameters
        ----------
        path : str or Path, optional
            File to write, in the format of its suffix.

        Returns
        -------
        Figure
            Of matplotlib.

        Raises
        ------
        MissingDependency
            If matplotlib is not installed.
        """
        return served("draw_rao")(self.rao, self.speed, path)

    def __str__(self) -> str:
        slow = f", surge, sway and yaw above {self.slowest_hz:g} Hz" if self.slowest_hz > 0.0 else ""
        return (
            f"{self.rao.name} at {self.speed:g} m/s, heading {self.heading_deg:g} (0: head, 90: from port){slow}; "
            f"points from {self.rao.reference}; {self.sea}"
        )

    @property
    def _course(self) -> _Course:
        sea = self.sea
        return _Course(self.rao, sea.spreading, sea.depth, sea.gravity, self.heading_deg, self.speed)

    def _mean_square(self, omega: Vector, point: Vector | None = None) -> np.ndarray:
        """Return the mean square of the responses of a point, over all directions, (n, 6)."""
        found = np.zeros((len(omega), 6))
        for share, met, response in self._course.responses(omega):
            kept = self._filtered(response, met)
            found += share * abs(kept if point is None else at_point(kept, point)) ** 2
        return found

    def _filtered(self, response: np.ndarray, met: Vector) -> np.ndarray:
        response[np.ix_(np.flatnonzero(abs(met) < 2.0 * np.pi * self.slowest_hz), HORIZONTAL)] = 0.0
        return response

    def _refuse_waves_outside(self) -> None:
        low, high = self.sea.range
        known = self.rao.frequencies
        if low >= known[0] and high <= known[-1]:
            return
        spectrum = self.sea.spectrum
        inside = max(low, float(known[0])), min(high, float(known[-1]))
        kept = spectrum.moment(0, *inside) / spectrum.moment(0) if inside[0] < inside[1] else 0.0
        peak = (
            ""
            if known[0] < spectrum.peak < known[-1]
            else (f"; even its peak, Tp = {2.0 * math.pi / spectrum.peak:.4g} s, is outside")
        )
        raise ModelError(
            f"the waves of the sea go from {low:.4g} to {high:.4g} rad/s, but {self.rao.name} is known from "
            f"{known[0]:.4g} to {known[-1]:.4g}{peak}. Remedy: an RAO that reaches further, or "
            f"frequency_range=({inside[0]:.4g}, {inside[1]:.4g}) of the sea, which keeps "
            f"{100 * kept:.3g} % of the variance of the waves"
        )


def damped(rao: MotionRao, damping: RollDamping, gravity: float) -> MotionRao:
    """Return an RAO whose roll has another damping; see `RollDamping`."""
    fitted = damping.fitted(rao)
    number = wave_number(rao.frequencies, rao.depth, gravity)
    values = rao.values.copy()
    for s, speed in enumerate(rao.speeds):
        for h, heading in enumerate(rao.headings_deg):
            met = encounter_frequency(rao.frequencies, number, float(heading), float(speed))
            values[s, h, :, 3] *= fitted.factor(met)
    return replace(rao, values=values)


@dataclass(frozen=True)
class _Course:
    """The course of a ship through waves of any height, which all seeds and seas with one spreading share."""

    rao: MotionRao
    spreading: Spreading | DirectionalTable
    depth: float
    gravity: float
    heading_deg: float
    speed: float

    def responses(self, omega: Vector) -> Iterator[tuple[float, Vector, np.ndarray]]:
        """Yield for each direction the share of the energy, frequencies of encounter (n,) and responses (n, 6)."""
        number = wave_number(omega, self.depth, self.gravity)
        count = 1 if self.spreading.is_long_crested else DIRECTIONS
        for share in (np.arange(count) + 0.5) / count:
            headings = self.heading_deg + self.spreading.quantile_at(omega, np.full(len(omega), share))
            met = encounter_frequency(omega, number, headings, self.speed)
            yield 1.0 / count, met, self.rao.at(omega, headings, self.speed)


@lru_cache(maxsize=COURSES)
def _horizontal(course: _Course, slowest_hz: float) -> tuple[np.ndarray, np.ndarray]:
    """Return mean squares of surge, sway and yaw (n, 3) at the points of `_over`: the slow part, and the total."""
    omega, _ = _over(course.rao.frequencies)
    slow, whole = np.zeros((len(omega), len(HORIZONTAL))), np.zeros((len(omega), len(HORIZONTAL)))
    for share, met, response in course.responses(omega):
        square = share * abs(response[:, HORIZONTAL]) ** 2
        whole += square
        slow += np.where(abs(met) < 2.0 * np.pi * slowest_hz, 1.0, 0.0)[:, None] * square
    return slow, whole


def _over(frequencies: Vector) -> tuple[Vector, Vector]:
    """Return points and weights of quadrature over the intervals of an RAO."""
    ends = np.interp(np.arange(STEPS * (len(frequencies) - 1) + 1) / STEPS, np.arange(len(frequencies)), frequencies)
    return gauss(ends, 4)
