"""Machine code of kernels from numba, linked to files by `kanefe.kernels.compiler.compiled_functions`."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple
from warnings import catch_warnings, simplefilter

from kanefe.kernels.compiler._numba import INNER, RELAXED, dispatcher, numba_for, seeing_compiled, timed
from kanefe.kernels.compiler._numba_alone import finish

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
"""C code that is linked to each function."""


class ObjectCode(NamedTuple):
    """A C function as the linker takes it.

    Attributes
    ----------
    code : bytes
        ELF, or what else the system has.
    symbol : str
    address : function () -> int
        Where it is in this process, made when it is asked for.
    """

    code: bytes
    symbol: str
    address: Callable[[], int]


def compiled_entry(function: Callable[..., Any], source: str, names: dict[str, Any]) -> ObjectCode:
    """Compile a kernel with a C function around it, whose source is given; in it the kernel is `function`."""
    numba = _numba()
    types = numba.types
    names = names | {"function": dispatcher(function), "array_of": numba.carray}
    names |= {"pointer_to": _pointer_to()} | {f"{kind}_at": _function_at(kind) for kind in _pointer_types()}
    names |= {kind: getattr(numba, kind) for kind in ("int64", "float64", "complex128")}
    exec(source, names)
    names["call"] = numba.njit(**INNER | {"_nrt": True}, fastmath=RELAXED)(names["call"])
    signature = types.void(types.CPointer(types.int64), types.CPointer(types.float64))
    return _object_code(names["wrapper"], signature)


def compiled_pointer(function: Callable[..., Any], kind: str) -> ObjectCode:
    """Compile a kernel to a function of one of the shared types of `kanefe.kernels.compiler.arrays`."""
    _numba()
    return _object_code(seeing_compiled(function), _pointer_types()[kind])


def compiled_function(function: Callable[..., Any], kinds: tuple[str, ...]) -> ObjectCode:
    """Compile a function without a result to a C function; see `kanefe.kernels.compiler.addresses` for the kinds."""
    types = _numba().types

    def of(kind: str) -> Any:
        value = getattr(types, kind.rstrip("*"))
        return types.CPointer(value) if kind.endswith("*") else value

    return _object_code(seeing_compiled(function), types.void(*map(of, kinds)))


def _numba() -> Any:
    """Return numba; a MissingDependency says what needs it."""
    return numba_for("building the solver")


def _object_code(function: Callable[..., Any], signature: Any) -> ObjectCode:
    from llvmlite import binding
    from numba.core.ccallback import CFunc
    from numba.core.compiler_lock import global_compiler_lock
    from numba.core.errors import NumbaExperimentalFeatureWarning
    from numba.core.sigutils import normalize_signature

    made = CFunc(function, normalize_signature(signature), {}, {"error_model": "numpy", "fastmath": RELAXED})
    with timed(), global_compiler_lock, catch_warnings():
        simplefilter("ignore", NumbaExperimentalFeatureWarning)  # kernels that are arguments of others are known here
        result = made._compile_uncached()  # type: ignore[attr-defined]
        library, symbol = result.library, result.fndesc.llvm_cfunc_wrapper_name
        library._ensure_finalized()
        finish(library, symbol)
    codegen = library._codegen
    # numba's own code is for its process alone: that of a library may be put anywhere
    target = binding.Target.from_triple(binding.get_process_triple()).create_target_machine(
        cpu=codegen._get_host_cpu_name(), features=codegen._tm_features, opt=3, reloc="pic", codemodel="default"
    )
    with timed():
        code = target.emit_object(library._final_module)
    return ObjectCode(code, symbol, lambda: int(library.get_pointer_to_function(symbol)))


@cache
def _pointer_types() -> dict[str, Any]:
    from numba import types

    memory = types.int64[::1], types.float64[::1], types.float64[:, ::1], types.float64[:, ::1]
    return {
        "filler": types.void(types.float64, types.float64[::1], types.float64[::1]),
        "advance": types.int64(*memory),
        "interpolate": types.void(*memory, types.float64, types.float64[::1]),
    }


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


@cache
def _function_at(kind: str) -> Any:
    """Return what makes a function of one of the types of pointers of an address."""
    from numba import types
    from numba.core import cgutils
    from numba.extending import intrinsic

    made = types.FunctionType(_pointer_types()[kind])

    @intrinsic
    def function_at(typing: Any, address: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            function = cgutils.create_struct_proxy(made)(context, builder)
            function.c_addr = builder.inttoptr(values[0], cgutils.voidptr_t)
            return function._getvalue()

        return made(types.int64), build

    return function_at
