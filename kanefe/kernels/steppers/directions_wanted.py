"""Where a method that wants the directions in which loads are stiff, and what finds them, meet.

See `kanefe.kernels.evaluation.stiff_directions`; a method has these places before its own.
"""

from __future__ import annotations

from kanefe.kernels.steppers.step_commands import OF_METHOD, REALS_OF_METHOD

DIRECTIONS = 9
"""Number of a command: as IMPLICIT, and then write Z, W and X from JACOBIAN_ROW on."""

MOST_DIRECTIONS, RANK = OF_METHOD, OF_METHOD + 1
"""Integers: how many directions there is room for, 0 if none are wanted, and how many were found."""
BEHIND_DIRECTIONS = OF_METHOD + 2

SHARE_OF_RATES = REALS_OF_METHOD
"""Real: share of the rates of internal states in what they are at the end of a step; 0: they are not followed."""
REALS_BEHIND_DIRECTIONS = REALS_OF_METHOD + 1
