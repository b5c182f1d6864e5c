"""Declared conventions of motions in waves, and how they become those of the house."""

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
    """What a table of motions in waves means; each must be said, because no two programs agree.

    Parameters
    ----------
    time : "exp(+iwt)" or "exp(-iwt)"
        Of what real parts are taken. Phases that lead the wave crest are of the first, those that lag of the second.
    heading_zero : "head" or "following"
    heading_90 : "port" or "starboard"
        Where waves of heading 90 come from.
    x : "forward" or "aft"
        Positive surge; roll is about it.
    y : "port" or "starboard"
        Positive sway; pitch is about it.
    z : "up" or "down"
        Positive heave; yaw is about it. The wave is positive upwards always.
    rotations : "rad/m", "deg/m", "rad/slope" or "deg/slope"
        Per height of the wave, or per its slope k a.
    reference : str
        The point whose motions they are, at which the wave is told.

    Raises
    ------
    ModelError
        If one is none of its choices, the axes are not right-handed, or the reference is empty.

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
            raise ModelError("the reference of an RAO's convention must say which point's motions they are")
        if np.prod(self._signs) < 0.0:
            raise ModelError(
                f"axes with x {self.x}, y to {self.y} and z {self.z} are left-handed. Remedy: turn one of them round, "
                "with the signs of its motions"
            )

    @classmethod
    def of(cls, said: dict[str, str], where: str) -> RaoConvention:
        """Return the convention of texts by name, as headers of files say it.

        Raises
        ------
        ModelError
            If something is not declared, or is unknown; the message names all that is missing.
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
        return np.array([1.0 if said == ours else -1.0 for said, ours in pairs])

    def headings(self, given: Vector) -> Vector:
        """Return the headings of the house, 0 to 360 degrees, in the order given."""
        turned = np.asarray(given, dtype=float) if self.heading_90 == "port" else -np.asarray(given, dtype=float)
        # of zero from behind, what is to be turned by half a turn keeps its sides
        if self.heading_zero == "following":
            turned = 180.0 - turned
        found = turned % 360.0
        return np.where(abs(found - 360.0) < 1e-9, 0.0, found)

    def values(self, given: np.ndarray, frequencies: Vector, depth: float) -> np.ndarray:
        """Return motions in the axes, signs and units of the house; `given` is (..., frequencies, 6)."""
        found = np.array(given, dtype=complex)
        if self.time == "exp(-iwt)":
            found = found.conj()
        found *= np.tile(self._signs, 2)
        if self.rotations.startswith("deg"):
            found[..., 3:] *= np.pi / 180.0
        if self.rotations.endswith("slope"):
            found[..., 3:] *= wave_number(frequencies, depth)[:, None]
        return found
