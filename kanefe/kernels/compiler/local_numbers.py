"""Room for some numbers on the stack of a kernel, which makes no arrays of its own."""

from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

LOCAL_NUMBERS = 1024
"""How many numbers a room has."""


@cache
def _compiled() -> Any:
    """Return what makes the room, once for each place where it is called, and returns the pointer to it."""
    from llvmlite import ir
    from numba import types
    from numba.core import cgutils
    from numba.extending import intrinsic

    @intrinsic
    def local_numbers(typing: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            return cgutils.alloca_once(builder, ir.DoubleType(), size=LOCAL_NUMBERS)

        return types.CPointer(types.float64)(), build

    return local_numbers


def _on_the_stack(in_python: Function) -> Function:
    in_python.calls_by_address = _compiled  # type: ignore[attr-defined]
    return in_python


@_on_the_stack
def local_numbers() -> Any:
    """Return room for `LOCAL_NUMBERS` numbers, which may be anything at first, until the kernel that asks returns."""
    return [0.0] * LOCAL_NUMBERS
