"""Where the function of a link writes the motion of its frame M seen from its frame F, in components of F."""

from __future__ import annotations

from kanefe.kernels.compiler.addresses import NUMBERS, VALUES

# Position, axes of M, partial velocities, and their derivatives by the coordinate
P, A, V, W, DV, DW = 0, 3, 12, 15, 18, 21
MOTION_NUMBERS = 24

# Kinds of the arguments of the function: numbers, q, out
SIGNATURE = (NUMBERS, VALUES, VALUES)
