"""The calls of C functions by their addresses, for kernels."""

from kanefe.kernels.compiler._numba import by_address, law_by_address
from kanefe.kernels.compiler.addresses import call_in_python, law_in_python

call_address = by_address(call_in_python)
"""Call of the C function at an address (int64) with a tuple of arguments: see `kanefe.kernels.compiler.addresses`."""

call_law = law_by_address(law_in_python)
"""Call of the law at an address (int64) with a depth, its rate, and constants from a position on; it returns what the
law writes."""
