"""Motions of a ship in waves of unit height, by frequency, heading and speed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from kanefe.arguments import checked
from kanefe.environment.dispersion import wave_number
from kanefe.errors import ModelError
from kanefe.frames import Vector

NAMES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
MIRRORED = np.array((1.0, -1.0, 1.0, -1.0, 1.0, -1.0))
"""Signs of the motions of a symmetric ship in waves from the other side."""

ROUND_OFF = 1e-4
"""Excess over the known range that counts as rounding of files: of a speed relative to the highest, of a frequency
relative to itself."""

SAME_HEADING = 1e-6
"""Difference below which headings are the same, degrees."""

HEADING_DIGITS = 6

ASYMMETRY = 1e-2
"""Largest noise in the transverse motions of a symmetric ship in head or following seas, relative to the largest
transverse motion."""


@dataclass(frozen=True, eq=False)
class MotionRao:
    """Response amplitude operators: complex motions ``Re{H a exp(i(we t + phase))}`` in a wave ``a cos(we t + phase)``.

    The encounter frequency we has a sign: if it is negative, the ship overtakes the wave. Motions are in ship axes, x
    forward, y to port, z up, of a reference point, at whose mean position, which moves with the ship's speed, the phase
    of the wave is given. `kanefe.read_rao` reads it from files and checks it.

    Parameters
    ----------
    frequencies : ndarray, shape (f,)
        Wave frequencies, increasing, rad/s.
    headings_deg : ndarray, shape (h,)
        Increasing; 0: head seas, 90: from port.
    speeds : ndarray, shape (s,)
        Increasing, m/s.
    values : ndarray, shape (s, h, f, 6)
        Surge, sway and heave (m/m), roll, pitch and yaw (rad/m) about the axes of the ship.
    name : str
        Name of the file or ship, for messages.
    reference : str
        Position of the reference point, in words.
    depth : float
        Depth of the water for which it was computed, m.
    symmetric : bool, optional
        Whether the ship is symmetric. None: judged by the motions in head and following seas.

    Raises
    ------
    ModelError
        If shapes differ, an axis does not increase, or a number is not finite.
    """

    frequencies: Vector
    headings_deg: Vector
    speeds: Vector
    values: np.ndarray
    name: str = "RAO"
    reference: str = "not stated"
    depth: float = math.inf
    symmetric: bool | None = None

    def __post_init__(self) -> None:
        axes = {"frequencies": self.frequencies, "headings": self.headings_deg, "speeds": self.speeds}
        for what, axis in axes.items():
            axis = np.asarray(axis, dtype=float)
            if axis.ndim != 1 or not len(axis) or not np.all(np.isfinite(axis)) or np.any(np.diff(axis) <= 0.0):
                raise ModelError(f"{self.name}: the {what} of an RAO must be finite numbers that increase")
        if self.frequencies[0] <= 0.0 or len(self.frequencies) < 2:
            raise ModelError(f"{self.name}: an RAO needs at least two frequencies above zero, rad/s")
        if self.speeds[0] < 0.0 or self.headings_deg[0] < 0.0 or self.headings_deg[-1] > 360.0:
            raise ModelError(f"{self.name}: speeds of an RAO are zero or above, headings 0 to 360 degrees")
        wanted = (len(self.speeds), len(self.headings_deg), len(self.frequencies), 6)
        if self.values.shape != wanted:
            raise ModelError(f"{self.name}: the values of an RAO must be of shape {wanted}, not {self.values.shape}")
        if not np.all(np.isfinite(self.values)):
            at = np.argwhere(~np.isfinite(self.values))[0]
            raise ModelError(
                f"{self.name}: {NAMES[at[3]]} at {self.frequencies[at[2]]:.4g} rad/s and heading "
                f"{self.headings_deg[at[1]]:g} is not a finite number. Remedy: export it again"
            )

    @cached_property
    def is_symmetric(self) -> bool:
        """Whether the motions in waves from starboard are those from port, mirrored."""
        if self.symmetric is not None:
            return self.symmetric
        ahead = [i for i, heading in enumerate(self.headings_deg) if heading in (0.0, 180.0, 360.0)]
        if not ahead:
            return False
        transverse = abs(self.values[..., 1::2])
        largest = transverse.max(axis=(0, 1, 2))
        return bool(np.all(transverse[:, ahead].max(axis=(0, 1, 2)) <= ASYMMETRY * largest))

    @cached_property
    def _circle(self) -> tuple[Vector, np.ndarray]:
        """Headings and values over the full circle, with the first one repeated; with mirrored ones if symmetric."""
        headings, values = self.headings_deg, self.values
        if self.is_symmetric:
            headings = np.concatenate((headings, 360.0 - headings))
            values = np.concatenate((values, values * MIRRORED), axis=1)
        headings, first = np.unique(np.round(headings % 360.0, HEADING_DIGITS) % 360.0, return_index=True)
        values = values[:, first]
        return np.append(headings, headings[0] + 360.0), np.append(values, values[:, :1], axis=1)

    @cached_property
    def _heading_step(self) -> float:
        """Largest step between the headings of the file, degrees, without the range that it does not cover."""
        headings = np.unique(self.headings_deg % 360.0)
        steps = np.diff(headings, append=headings[0] + 360.0)
        return float(np.sort(steps)[-2]) if len(steps) > 1 else 0.0

    @checked
    def at(self, omega: Vector, heading_deg: Vector | float, speed: float) -> np.ndarray:
        """Return the responses at wave frequencies and headings, shape (n, 6).

        Real and imaginary parts are interpolated linearly; amplitude and phase would be wrong where a motion passes
        through zero.

        Parameters
        ----------
        omega : ndarray, shape (n,)
            rad/s.
        heading_deg : ndarray, shape (n,), or float
            Any value; full turns are removed.
        speed : float
            m/s.

        Raises
        ------
        ModelError
            If one is outside of the known range: nothing is extrapolated.
        """
        headings, values = self._circle
        values = self._at_speed(values, speed)
        i, x = _between(
            self.frequencies, np.atleast_1d(np.asarray(omega, dtype=float)), "wave frequency", "rad/s", self.name
        )
        beta = np.asarray(heading_deg, dtype=float)
        if beta.shape not in ((), np.shape(i)):
            raise ModelError(
                f"heading_deg must be one number, or one for each of {np.shape(i)} waves, not {beta.shape}"
            )
        j, y = self._place_of(headings, np.broadcast_to(beta, np.shape(i)))
        x, y = x[:, None], y[:, None]
        near, far = ((1.0 - x) * values[k, i] + x * values[k, i + 1] for k in (j, j + 1))
        return np.asarray((1.0 - y) * near + y * far)

    @checked
    def with_wave_at(self, x: float, y: float) -> MotionRao:
        """Return this RAO with phases for a wave given at a point (m, ship axes, from the reference point)."""
        beta = np.radians(self.headings_deg)
        way = -(np.cos(beta) * float(x) + np.sin(beta) * float(y))
        late = np.exp(-1j * np.multiply.outer(way, wave_number(self.frequencies, self.depth)))
        return replace(self, values=self.values * late[None, :, :, None])

    def _at_speed(self, values: np.ndarray, speed: float) -> np.ndarray:
        if len(self.speeds) == 1:
            if abs(speed - self.speeds[0]) > ROUND_OFF * max(1.0, self.speeds[0]):
                raise ModelError(
                    f"{self.name} is of {self.speeds[0]:g} m/s alone, not of {speed:g} m/s. Remedy: an RAO of that "
                    "speed: speeds are interpolated, never extrapolated"
                )
            return np.asarray(values[0])
        (i,), (x,) = _between(self.speeds, np.array([speed]), "speed", "m/s", self.name)
        return np.asarray((1.0 - x) * values[i] + x * values[i + 1])

    def _place_of(self, headings: Vector, asked: Vector) -> tuple[np.ndarray, Vector]:
        """Return the next lower headings, and the relative positions between these and the following ones."""
        found = (asked - headings[0]) % 360.0 + headings[0]
        j = np.clip(np.searchsorted(headings, found + SAME_HEADING, side="right") - 1, 0, len(headings) - 2)
        beyond, width = found - headings[j], headings[j + 1] - headings[j]
        # gaps in the headings of a file that mirroring does not fill
        unknown = (
            (SAME_HEADING < beyond) & (beyond < width - SAME_HEADING) & (width > self._heading_step + SAME_HEADING)
        )
        if np.any(unknown):
            first, last = self.headings_deg[0], self.headings_deg[-1]
            lopsided = "the ship is not symmetric, or head and following seas, which show that, are missing"
            why = "" if self.is_symmetric else f": {lopsided}"
            raise ModelError(
                f"{self.name} has headings of {first:g} to {last:g} degrees and was asked for "
                f"{asked[unknown][0] % 360.0:.4g}{why}. Remedy: an RAO of these headings (spreading seas need 90 "
                "degrees to either side), or symmetric=True if the ship is"
            )
        return j, np.where(beyond > SAME_HEADING, beyond / width, 0.0)


def at_point(responses: np.ndarray, point: Vector) -> np.ndarray:
    """Return the responses (n, 6) of another point of a ship, m from the present one: ``s + theta x point``."""
    found = responses.copy()
    found[:, :3] += np.cross(responses[:, 3:], point)
    return found


def _between(axis: Vector, at: Vector, what: str, unit: str, name: str) -> tuple[np.ndarray, Vector]:
    """Return the intervals that contain numbers, and the relative positions; a ModelError if they are off the axis."""
    allowed = ROUND_OFF * (axis[-1] if axis[0] == 0.0 else abs(at))
    beyond = (at < axis[0] - allowed) | (at > axis[-1] + allowed)
    if np.any(beyond):
        raise ModelError(
            f"{name} is known for {what} {axis[0]:.6g} to {axis[-1]:.6g} {unit} and was asked for "
            f"{at[beyond][0]:.6g} {unit}. Remedy: stay inside, since nothing is extrapolated, or an RAO with a larger "
            "range"
        )
    i = np.clip(np.searchsorted(axis, at, side="right") - 1, 0, len(axis) - 2)
    return i, np.clip((at - axis[i]) / (axis[i + 1] - axis[i]), 0.0, 1.0)
