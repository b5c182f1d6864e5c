"""What a kernel is written in: marks of functions, values with operators, records on arrays, kinds of arguments.

A file of kernels imports from here what is of no room in particular, in one line. Where that line is full, values come
from `values/tensors.py` itself, and kinds of arrays from `compiler/arrays.py`.
"""

from kanefe.kernels.algebra.lengths import across, beside, largest_in, norm, unit
from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import exact, expanded, in_vectors, inlined, kernel, vector_kernel
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.compiler.arrays import (
    ADVANCE,
    INTERPOLATE,
    IntegerRows,
    Integers,
    Prepared,
    RealBlocks,
    RealRows,
    Reals,
    ValueRows,
)
from kanefe.kernels.compiler.calls import call_address, call_law
from kanefe.kernels.compiler.entries import entry, pointer
from kanefe.kernels.compiler.signatures import COMPLEX, REAL, in_place
from kanefe.kernels.values.numbers import (
    cosine,
    excess,
    held_brake,
    is_above,
    is_complex,
    is_there,
    lane_count,
    lanes_of,
    sine,
)
from kanefe.kernels.values.parts import Array, Behind, Columns, Many, One, Start, Table, Values, vectors
from kanefe.kernels.values.records import Record, Rows, column, numbers_from
from kanefe.kernels.values.tensors import (
    IDENTITY,
    NO_INERTIA,
    NO_MATRIX,
    ZERO,
    Matrix,
    Symmetric,
    Vector,
    congruent,
    contract,
    cross,
    diagonal,
    dot,
    outer,
    rotation,
    skew,
    square,
    symmetric,
    turned_about_z,
)
