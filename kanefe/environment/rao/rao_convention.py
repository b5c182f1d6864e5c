"""Declared conventions of motions in waves, and their conversion to that of kanefe."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from kanefe.environment.dispersion import wave_number
from kanefe.errors import ModelError
from kanefe.frames import Vector

CHOICES: dict[str, tuple[str, ...]] = {
    "time": ("exp(+iwt)", "exp(-iwt)"),
    "heading_zero": ("head", "following"),
    "heading_90": ("port", "starboard"),
    "x": ("forward", "aft"),
    "y": ("port", "starboard"),
    "z": ("up", "down"),
    "rotations": ("rad/m", "deg/m", "rad/slope", "deg/slope"),
}


@dataclass(frozen=True)
class RaoConvention:
    """The convention of a table of motions in waves; each part must be given, because programs differ.

    Parameters
    ----------
    time : "exp(+iwt)" or "exp(-iwt)"
        Time factor of complex amplitudes: phases lead the wave crest with the first, and lag with the second.
    heading_zero : "head" or "following"
    heading_90 : "port" or "starboard"
        Side from which waves of heading 90 come.
    x : "forward" or "aft"
        Positive surge; roll is about it.
    y : "port" or "starboard"
        Positive sway; pitch is about it.
    z : "up" or "down"
        Positive heave; yaw is about it. The wave elevation is always positive upward.
    rotations : "rad/m", "deg/m", "rad/slope" or "deg/slope"
        Per wave amplitude, or per wave slope k a.
    reference : str
        The point whose motions are given, and at which the phase of the wave is given.

    Raises
    ------
    ModelError
        If one is not among its choices, the axes are not right-handed, or the reference is empty.

    Examples
    --------
    >>> import kanefe as kf
    >>> convention = kf.RaoConvention(
    ...     time="exp(+iwt)", heading_zero="following", heading_90="starboard", x="forward", y="port", z="up",
    ...     rotations="deg/m", reference="centre of gravity",
    ... )
    """

    time: str
    heading_zero: str
    heading_90: str
    x: str
    y: str
    z: str
    rotations: str
    reference: str

    def __post_init__(self) -> None:
        for name, known in CHOICES.items():
            if getattr(self, name) not in known:
                raise ModelError(
                    f"{name} of an RAO's convention is one of {', '.join(known)}, not {getattr(self, name)!r}"
                )
        if not isinstance(self.reference, str) or not self.reference.strip():
            raise ModelError("the reference of an RAO's convention must name the point whose motions are given")
        if np.prod(self._signs) < 0.0:
            raise ModelError(
                f"axes with x {self.x}, y to {self.y} and z {self.z} are left-handed. Remedy: reverse one of them, "
                "with the signs of its motions"
            )

    @classmethod
    def of(cls, said: dict[str, str], where: str) -> RaoConvention:
        """Return the convention of texts by name, as in headers of files.

        Raises
        ------
        ModelError
            If a part is not declared or not valid; the message names all missing parts.
        """
        names = [field.name for field in fields(cls)]
        missing = [name for name in names if name not in said]
        if missing:
            raise ModelError(
                f"{where}: {', '.join(missing)} of the convention {'is' if len(missing) == 1 else 'are'} not declared. "
                f"Remedy: lines '# name: value' at its head, or convention=kanefe.RaoConvention(...)"
            )
        return cls(**{name: said[name] for name in names})

    @property
    def _signs(self) -> Vector:
        """Signs of the axes relative to x forward, y to port, z up."""
        pairs = (self.x, "forward"), (self.y, "port"), (self.z, "up")
        return np.array([1.0 if given == ours else -1.0 for given, ours in pairs])

    def headings(self, given: Vector) -> Vector:
        """Return headings in the convention of kanefe, 0 to 360 degrees, in the given order."""
        turned = np.asarray(given, dtype=float) if self.heading_90 == "port" else -np.asarray(given, dtype=float)
        # reversing the direction of zero does not exchange port and starboard
        if self.heading_zero == "following":
            turned = 180.0 - turned
        found = turned % 360.0
        return np.where(abs(found - 360.0) < 1e-9, 0.0, found)

    def values(self, given: np.ndarray, frequencies: Vector, depth: float) -> np.ndarray:
        """Return motions in the axes, signs and units of kanefe; `given` is (..., frequencies, 6)."""
        found = np.array(given, dtype=complex)
        if self.time == "exp(-iwt)":
            found = found.conj()
        found *= np.tile(self._signs, 2)
        if self.rotations.startswith("deg"):
            found[..., 3:] *= np.pi / 180.0
        if self.rotations.endswith("slope"):
            found[..., 3:] *= wave_number(frequencies, depth)[:, None]
        return found
