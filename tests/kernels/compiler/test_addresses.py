"""C functions called by their address: from compiled code and from Python, of the house and of the user."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.kernels.compiler.addresses import COMPLEX_NUMBERS, INTEGER, NUMBER, NUMBERS, house_address
from kanefe.kernels.compiler.arrays import Integers, Reals, ValueRows
from kanefe.kernels.compiler.calls import call_address
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.compiler.foreign import address_of
from kanefe.kernels.compiler.signatures import COMPLEX, REAL


def scaled(s: float, numbers: Any, out: Any) -> None:
    out[0] = numbers[0] * s
    out[1] = numbers[1] + s


def scaled_complex(s: Any, numbers: Any, out: Any) -> None:
    out[0] = numbers[0] * s[0]
    out[1] = numbers[1] + s[0]


def counted(count: int, out: Any) -> None:
    out[count] = 1.0 / count


@entry(REAL, COMPLEX)
def call_either(addresses: Integers, numbers: Reals, workspace: ValueRows) -> None:
    """Call the real or the complex function with workspace[0, 0], as the workspace is."""
    out = workspace[1, 1:3]
    if workspace.itemsize == 8:
        call_address(addresses[0], (workspace[0, 0].real, numbers, out))
    else:
        call_address(addresses[1], (workspace[0, 0:1], numbers, out))
    workspace[0, 1] = out[0] + out[1]


def called(addresses: np.ndarray, s: Any, numbers: np.ndarray) -> Any:
    workspace = np.zeros((2, 3), dtype=type(s))
    workspace[0, 0] = s
    call_either.bound(addresses, numbers, workspace, is_complex=isinstance(s, complex))()
    return workspace[0, 1]


@entry()
def counted_to(address: int, count: int, out: Reals) -> None:
    call_address(address, (count, out))


NUMBERS_GIVEN = np.array([5.0, 0.25])


def own_addresses() -> np.ndarray:
    real = house_address(scaled, NUMBER, NUMBERS, NUMBERS)
    return np.array([real, house_address(scaled_complex, COMPLEX_NUMBERS, NUMBERS, COMPLEX_NUMBERS)])


def test_functions_of_the_house() -> None:
    assert called(own_addresses(), 3.0, NUMBERS_GIVEN) == 18.25
    assert called(own_addresses(), 3.0 + 1j, NUMBERS_GIVEN) == 18.25 + 6j
    out = np.zeros(5)
    counted_to(house_address(counted, INTEGER, NUMBERS), 4, out)
    assert out.tolist() == [0.0, 0.0, 0.0, 0.0, 0.25]


def test_functions_of_a_library() -> None:
    pointer = ctypes.POINTER(ctypes.c_double)

    @ctypes.CFUNCTYPE(None, ctypes.c_double, pointer, pointer)
    def doubled(s: float, numbers: Any, out: Any) -> None:
        out[0], out[1] = 2.0 * s, numbers[1]

    addresses = np.array([address_of(doubled, "the function"), 0])
    assert called(addresses, 3.0, NUMBERS_GIVEN) == 6.25
    assert address_of(int(addresses[0]), "the function") == addresses[0]


def test_functions_of_cffi_and_numba() -> None:
    cffi, numba = pytest.importorskip("cffi"), pytest.importorskip("numba")
    ffi = cffi.FFI()

    def halved(s: float, numbers: Any, out: Any) -> None:
        out[0], out[1] = 0.5 * s, numbers[1]

    of_cffi = ffi.callback("void(double, const double *, double *)", halved)
    memory = numba.types.CPointer(numba.types.float64)
    of_numba = numba.cfunc(numba.types.void(numba.types.float64, memory, memory))(halved)
    for given in (of_cffi, of_numba):
        addresses = np.array([address_of(given, "the function"), 0])
        assert called(addresses, 3.0, NUMBERS_GIVEN) == 1.75


@pytest.mark.parametrize("given", [None, 0, True, "f", scaled, np.sin])
def test_what_is_no_function_of_c_is_refused(given: object) -> None:
    with pytest.raises(kf.errors.ModelError, match=r"the kernel must be a compiled function.*Remedy: a numba\.cfunc"):
        address_of(given, "the kernel")
