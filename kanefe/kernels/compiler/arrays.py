"""Kinds of arrays in the signatures of kernels that are called from outside: what of, and with how many axes.

All are contiguous in C's order. From these annotations come the C functions that kernels are built to, see
`kanefe.kernels.compiler.signatures`.
"""

from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

import numpy as np

VALUE = "value"
"""Mark of arrays that exist twice: their numbers are complex where the state of the scene is."""

Integers = Annotated[np.ndarray, "int64", 1]
IntegerRows = Annotated[np.ndarray, "int64", 2]
Reals = Annotated[np.ndarray, "float64", 1]
RealRows = Annotated[np.ndarray, "float64", 2]
RealBlocks = Annotated[np.ndarray, "float64", 3]
Values = Annotated[np.ndarray, VALUE, 1]
ValueRows = Annotated[np.ndarray, VALUE, 2]

# Functions of one type for all, called by address
FILLER, ADVANCE, INTERPOLATE = "filler", "advance", "interpolate"

Filler = Annotated[Callable[..., None], FILLER]
"""(t, y, inputs): function that writes values of compiled functions of the user, see
`kanefe.kernels.compiler.filling.filler`."""
Advance = Annotated[Callable[..., int], ADVANCE]
"""(integers, reals, vectors, table): function that continues a method and returns its next command."""
Interpolate = Annotated[Callable[..., Any], INTERPOLATE]
"""(integers, reals, vectors, table, t, out): function that writes the state at a time in the last step."""


class Prepared(NamedTuple):
    """A call of a built kernel with all its arguments, as kernels see it: ``call_address(address, (places, numbers))``.

    Attributes
    ----------
    address : int
    places, numbers : ndarray
        See `kanefe.kernels.compiler.signatures`: scalars among them may be written before each call.
    """

    address: int
    places: Integers
    numbers: Reals


NOT_CALLED = Prepared(0, np.zeros(1, dtype=np.int64), np.zeros(1))
"""Takes the place of a call that a run does not make."""
