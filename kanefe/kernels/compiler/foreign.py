"""C functions of the user: their addresses, found in what numba, ctypes or cffi give."""

import ctypes
import numbers
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from kanefe.errors import ModelError

_OfLibrary: Any = ctypes._CFuncPtr  # type: ignore[attr-defined]  # the class of all functions that ctypes opens


def address_of(given: object, what: str) -> int:
    """Return the address of a C function of the user, for `kanefe.kernels.compiler.addresses`.

    Parameters
    ----------
    given : object
        A ``numba.cfunc``, a function of a library opened by ctypes or cffi, or the address itself. Whoever has the
        address keeps the function too.
    what : str
        For messages.

    Raises
    ------
    ModelError
        If it is none of these, or null.
    """
    found = _address(given)
    if not found or (isinstance(given, numbers.Integral) and not _is_code(found)):
        raise ModelError(
            f"{what} must be a compiled function, not {given!r}. Remedy: a numba.cfunc, a function of a library opened "
            "by ctypes or cffi, or its address"
        )
    return found


@cache
def _is_code(address: int) -> bool:
    """Return whether code of this process lies at an address, if the system can say; otherwise a call would crash."""
    maps = Path("/proc/self/maps")
    if not maps.exists():
        return True
    for line in maps.read_text().splitlines():
        ends, rights = line.split()[:2]
        first, last = (int(end, 16) for end in ends.split("-"))
        if first <= address < last:
            return "x" in rights
    return False


def check_functions(functions: Iterable[object], what: str) -> None:
    """Raise a ModelError if what should be functions of the house, addresses or None is none of them."""
    for function in functions:
        if function is not None and not callable(function) and not (isinstance(function, int) and function > 0):
            raise ModelError(
                f"a function of {what} must be the address of a C function, such as numba.cfunc(...).address, not "
                f"{function!r}"
            )


def _address(given: Any) -> int:
    if isinstance(given, bool):
        return 0
    if isinstance(given, numbers.Integral):
        return int(given)
    if isinstance(given, _OfLibrary):
        return ctypes.cast(given, ctypes.c_void_p).value or 0
    if type(given).__module__ == "_cffi_backend":
        cffi = sys.modules["_cffi_backend"].FFI()
        if cffi.typeof(given).kind in ("function", "pointer"):
            return int(cffi.cast("intptr_t", given))
    address = getattr(given, "address", None)  # a numba.cfunc
    return address if isinstance(address, int) else 0
