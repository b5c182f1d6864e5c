"""Machine code of kernels from numba, linked to files by `kanefe.kernels.compiler.compiled_functions`."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any
from warnings import catch_warnings, simplefilter

from kanefe.kernels.compiler._numba import INNER, RELAXED, dispatcher, numba_for, seeing_compiled, timed
from kanefe.kernels.compiler._numba_pointers import c_function, c_signature, function_at
from kanefe.kernels.compiler.arrays import ADVANCE, FILLER, INTERPOLATE

if TYPE_CHECKING:
    from kanefe.kernels.compiler._numba_module import Translated

SUPPORT = """
#include <stddef.h>
/* What numba's code calls of its own library where an error is raised or an array reshaped: the error is told by the
   function's own number, arrays are contiguous. */
int numba_gil_ensure(void *state) { return 0; }
void numba_gil_release(void *state) {}
int numba_do_raise(void *error) { return 0; }
void *numba_runtime_build_excinfo_struct(void *a, void *b) { return 0; }
void *numba_unpickle(void *data, int size, void *digest) { return 0; }
void NRT_Free(void *memory) {}
void NRT_MemInfo_call_dtor(void *memory) {}
int numba_attempt_nocopy_reshape(ptrdiff_t axes, const ptrdiff_t *lengths, const ptrdiff_t *strides, ptrdiff_t new_axes,
                                 const ptrdiff_t *new_lengths, ptrdiff_t *new_strides, ptrdiff_t size, int order)
{
    for (ptrdiff_t axis = new_axes - 1; axis >= 0; --axis) {
        new_strides[axis] = size;
        size *= new_lengths[axis];
    }
    return 1;
}
"""
"""C code that is linked to functions that numba builds in its own way."""


def compiled_entry(function: Callable[..., Any], source: str, names: dict[str, Any]) -> Translated:
    """Compile a kernel with a C function around it, whose source is given; in it the kernel is `function`."""
    numba = _numba()
    types = numba.types
    from kanefe.kernels.compiler._numba_in_place import reader

    names = {name: reader(one) if name.endswith("_in") else one for name, one in names.items()}
    names |= {"function": dispatcher(function), "array_of": numba.carray}
    names |= {f"{kind}_at": function_at(kind) for kind in (FILLER, ADVANCE, INTERPOLATE)}
    names |= {"pointer_to": _pointer_to()}
    names |= {kind: getattr(numba, kind) for kind in ("int64", "float64", "complex128")}
    exec(source, names)
    signature = types.void(types.CPointer(types.int64), types.CPointer(types.float64))
    return _translated(names["wrapper"], signature)


def compiled_pointer(function: Callable[..., Any], kind: str) -> Translated:
    """Compile a kernel to a function of one of the shared types of `kanefe.kernels.compiler.arrays`."""
    numba = _numba()
    inner = numba.njit(**{**INNER, "fastmath": RELAXED})(seeing_compiled(function))
    return _translated(c_function(inner, kind), c_signature(kind))


def compiled_function(function: Callable[..., Any], kinds: tuple[str, ...]) -> Translated:
    """Compile a function without a result to a C function; see `kanefe.kernels.compiler.addresses` for the kinds."""
    types = _numba().types

    def of(kind: str) -> Any:
        value = getattr(types, kind.rstrip("*"))
        return types.CPointer(value) if kind.endswith("*") else value

    return _translated(seeing_compiled(function), types.void(*map(of, kinds)))


def _numba() -> Any:
    """Return numba; a MissingDependency says what needs it."""
    return numba_for("building the solver")


def _translated(function: Callable[..., Any], signature: Any) -> Translated:
    from numba.core.ccallback import CFunc
    from numba.core.compiler_lock import global_compiler_lock
    from numba.core.errors import NumbaExperimentalFeatureWarning
    from numba.core.sigutils import normalize_signature

    from kanefe.kernels.compiler._numba_module import Translated

    made = CFunc(function, normalize_signature(signature), {}, {"error_model": "numpy", "fastmath": RELAXED})
    with timed(), global_compiler_lock, catch_warnings():
        simplefilter("ignore", NumbaExperimentalFeatureWarning)  # kernels that are arguments of others are known here
        result = made._compile_uncached()  # type: ignore[attr-defined]
        result.library._ensure_finalized()
    return Translated(result.library, result.fndesc.llvm_cfunc_wrapper_name)


@cache
def _pointer_to() -> Any:
    """Return what makes a pointer of an address, for carray."""
    from numba import types
    from numba.core import cgutils
    from numba.extending import intrinsic

    @intrinsic
    def pointer_to(typing: Any, address: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            return builder.inttoptr(values[0], cgutils.voidptr_t)

        return types.voidptr(types.int64), build

    return pointer_to
