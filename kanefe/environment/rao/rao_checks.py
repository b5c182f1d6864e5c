"""Checks of axes, signs and units of an RAO: in very long waves a ship follows the surface."""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import numpy as np

from kanefe.environment.dispersion import wave_number
from kanefe.environment.rao.rao import NAMES, MotionRao
from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.frames import Vector

LONG = 0.3
"""Largest deviation of the heave from that of the surface for waves to count as long."""

ALONG, AGAINST = 0.5, -0.5
"""Real part of a motion divided by that of the surface, above which both agree and below which they are opposed."""

SLOPES = 0.3, 3.0
"""Range of rotations in long waves divided by the slope of the surface: roll already grows towards its resonance."""

BELOW_ROLL = 2.0
"""Ratio of the frequency of the largest roll to the lowest frequency above which the sign of roll is that of the slope.
"""

INSIDE = 0.5
"""Cosine or sine of a heading above which longitudinal or transverse motions are checked."""


def surface_motion(heading_deg: float, number: float) -> Vector:
    """Return the motions (6,) of a raft that follows the surface of long deep waves, in a wave of 1 m.

    A wave ``cos(omega t - k d.x)`` along d moves water by -i d, and its slope is -i k d: a raft stays normal to the
    surface, and ``sway'' + g roll`` vanishes.

    Parameters
    ----------
    heading_deg : float
    number : float
        Wave number, rad/m.
    """
    ahead, port = np.cos(np.radians(heading_deg)), np.sin(np.radians(heading_deg))
    return np.array((1j * ahead, 1j * port, 1.0, 1j * number * port, -1j * number * ahead, 0.0))


def check_long_waves(rao: MotionRao) -> None:
    """Refuse an RAO whose motions in its longest waves are not those of the surface; the message has the likely cause.

    If its longest wave is too short for the check, an `AccuracyWarning` is issued.

    Raises
    ------
    ModelError
        If an axis, the sign of time or the unit of rotations differs from the declaration.
    """
    number = float(wave_number(rao.frequencies[:1], rao.depth)[0])
    heave = np.array([rao.values[0, i, 0, 2] for i in range(len(rao.headings_deg))])
    if np.all(abs(heave + 1.0) < LONG):
        raise _wrong(rao, "heave in long waves is opposite to the surface", "z points the other way")
    if not np.all(abs(heave - 1.0) < LONG):
        if np.all(abs(abs(heave) - 1.0) < LONG):
            raise _wrong(
                rao,
                "heave in long waves is as high as the surface but not in phase",
                "phases are of another wave",
            )
        warnings.warn(
            f"{rao.name}: its longest waves ({rao.frequencies[0]:.3g} rad/s) are too short to check axes and "
            f"signs: the ship heaves {abs(heave).max():.3g} m in 1 m. Remedy: an RAO with longer waves, or a look at "
            "Ship.plot_rao()",
            AccuracyWarning,
            stacklevel=outside(),
        )
        return
    faults = list(_opposed(rao, number))
    if faults:
        raise _wrong(rao, " and ".join(f"{NAMES[k]} in long waves is {how}" for k, how in faults), _cause(dict(faults)))


def _opposed(rao: MotionRao, number: float) -> Iterator[tuple[int, str]]:
    """Yield the motions that are opposed to the surface, or of another size."""
    found: dict[int, list[complex]] = {}
    for i, heading in enumerate(rao.headings_deg):
        wanted = surface_motion(float(heading), number)
        for k, share in ((0, wanted[0]), (1, wanted[1]), (3, wanted[1]), (4, wanted[0])):
            if abs(share) > INSIDE and not (k == 3 and not _below_roll(rao, i)):
                found.setdefault(k, []).append(complex(rao.values[0, i, 0, k] / wanted[k]))
    for k, ratios in found.items():
        middle = complex(np.median(np.real(ratios)), np.median(np.imag(ratios)))
        if middle.real < AGAINST * (abs(middle) if k > 2 else 1.0):
            yield k, "opposed"
        elif k > 2 and not SLOPES[0] < abs(middle) < SLOPES[1]:
            yield k, f"{abs(middle):.3g} times the slope"
        elif k < 3 and middle.real < ALONG:
            yield k, "not in phase with the surface"


def _below_roll(rao: MotionRao, heading: int) -> bool:
    amplitudes = abs(rao.values[0, heading, :, 3]) / wave_number(rao.frequencies, rao.depth)
    return bool(rao.frequencies[0] * BELOW_ROLL < rao.frequencies[int(np.argmax(amplitudes))])


def _cause(faults: dict[int, str]) -> str:
    """Return the part of the declaration that is probably wrong."""
    sizes = [float(how.split()[0]) for how in faults.values() if how.endswith("slope")]
    if sizes:
        if all(30.0 < size < 120.0 for size in sizes):
            return "rotations are in degrees"
        return "rotations are for waves of unit slope, not height, or in another unit of length"
    opposed = frozenset(faults)
    causes = {
        frozenset((0, 1, 3, 4)): "time goes as exp(-i omega t), or headings are those to which waves propagate",
        frozenset((0, 4)): "x points the other way, or heading 0 is following seas",
        frozenset((1, 3)): "y points the other way, or heading 90 is from the other side",
        frozenset((0, 1)): "x and y both point the other way",
        frozenset((3, 4)): "the axes of rotation both point the other way",
    }
    return causes.get(opposed, "an axis points the other way")


def _wrong(rao: MotionRao, what: str, cause: str) -> ModelError:
    return ModelError(
        f"{rao.name}: {what}, so that the deck does not stay normal to it. Probably {cause}. Remedy: declare the "
        "convention of the file"
    )
