"""The call of a C function by its address, for kernels."""

from __future__ import annotations

from kanefe.kernels._numba import by_address
from kanefe.kernels.addresses import call_in_python

call_address = by_address(call_in_python)
"""Call the C function at an address (int64) with a tuple of arguments: see `kanefe.kernels.addresses`."""
