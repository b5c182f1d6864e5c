"""Motion transfer functions of VERES (ShipX): files .re1."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from kanefe.environment.rao.rao import MotionRao
from kanefe.environment.rao.rao_convention import RaoConvention
from kanefe.environment.rao.rao_grid import Rows, number_lines, numbers_of
from kanefe.errors import FileError

TEXT_LINES = 6
"""Number of text lines at the start of the file; four with numbers follow."""


def read_veres(path: Path, *, symmetric: bool | None = None) -> MotionRao:
    """Return the RAO of a file: six lines of text; density and gravity; Lpp, breadth, draught; the centre of gravity.

    Then the numbers of speeds, headings, frequencies and motions; for each speed a line with speed, sinkage, trim and
    the point of the motions (from Lpp/2 and the baseline); for each heading and each frequency a line with its value,
    and one for each motion with number, real and imaginary part. Axes are x aft, y to starboard, z up; heading 0 is
    head seas, 90 from port; motions are the real parts with ``exp(+i omega t)``; rotations are in rad/m.

    Raises
    ------
    FileError
        If the file is truncated, or another file of VERES.
    """
    lines = number_lines(path, "motions of VERES")
    place = TEXT_LINES

    def numbers(count: int) -> list[float]:
        nonlocal place
        if place >= len(lines):
            raise FileError(f"{path} ends in line {len(lines)}, before its last motion. Remedy: export it again")
        place += 1
        return numbers_of(lines[place - 1], count, f"{path}, line {place}")

    numbers(2), numbers(3), numbers(2)
    speeds, headings, frequencies, motions = (int(n) for n in numbers(4)[:4])
    if motions != 6 or min(speeds, headings, frequencies) < 1 or speeds * headings * frequencies > len(lines):
        raise FileError(
            f"{path} claims {speeds} speeds, {headings} headings, {frequencies} frequencies and {motions} motions: no "
            "file of six motions in waves. Remedy: the file .re1 of VERES"
        )
    count = speeds * headings * frequencies
    found = Rows(np.empty(count), np.empty(count), np.empty(count), np.empty((count, 6), dtype=complex))
    row, reference = 0, ""
    for _ in range(speeds):
        speed, _, _, ahead, height = numbers(5)[:5]
        reference = f"{ahead:g} m from Lpp/2 (VERES: aft is positive), {height:g} m above the baseline"
        for _ in range(headings):
            heading = numbers(1)[0]
            for _ in range(frequencies):
                found.speeds[row], found.headings[row], found.frequencies[row] = speed, heading, numbers(1)[0]
                for motion in range(6):
                    number, real, imaginary = numbers(3)[:3]
                    if number != motion + 1:
                        raise FileError(
                            f"{path}, line {place}: motion {motion + 1} was expected. Remedy: export it again"
                        )
                    found.values[row, motion] = complex(real, imaginary)
                row += 1
    convention = RaoConvention("exp(+iwt)", "head", "port", "aft", "starboard", "up", "rad/m", reference)
    return found.rao(path, convention, symmetric=symmetric)
