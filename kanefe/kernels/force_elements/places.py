"""Where a load between frames finds the motion of its ends, and where it writes what it does."""

from __future__ import annotations

from kanefe.kernels.compiler.addresses import NUMBER, NUMBERS, VALUES

# Of an end, in components of N
P, A, V, W = 0, 3, 12, 15
END_NUMBERS = 18

# Of what is written; then force and moment of each end, then the rates of the states
POTENTIAL, TAKEN, GIVEN, WRENCHES = range(4)
WRENCH = 6

# Kinds of the arguments of the function: t, numbers, inputs, ends, states, out
SIGNATURE = (NUMBER, NUMBERS, NUMBERS, VALUES, VALUES, VALUES)

# The same of a function that writes what events of a load look at, for real numbers alone
WATCH_SIGNATURE = (NUMBER, *[NUMBERS] * 5)
