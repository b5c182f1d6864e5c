"""What writes the values that functions of the user give: a function of one type for all scenes, called by address."""

from collections.abc import Callable
from typing import Any

from kanefe.kernels.compiler._numba_functions import Part, compiled_filler
from kanefe.kernels.compiler.arrays import FILLER
from kanefe.kernels.compiler.entries import pointer


@pointer(FILLER)
def fill_nothing(t: float, y: Any, inputs: Any) -> None:
    """Write nothing: of a scene without functions of the user."""
    return


def filler(parts: tuple[Part, ...]) -> Callable[..., None]:
    """Return a function (t, y, inputs) that writes what functions of the user give, all of them compiled."""
    return compiled_filler(parts) if parts else fill_nothing
