"""Machine code of kernels from numba, linked to files by `kanefe.kernels.compiler.compiled_functions`.

numba makes machine code of each kernel that another calls, for calls from Python, and optimises it with all that it
calls, once more in each of its callers. A process that does nothing but build (`build_alone`) leaves both to the whole
unit, which takes a third of the time.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple
from warnings import catch_warnings, simplefilter

from kanefe.kernels.compiler._numba import INNER, RELAXED, dispatcher, numba_for, seeing_compiled, timed

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
        _optimise_whole(library, symbol)
    codegen = library._codegen
    # numba's own code is for its process alone: that of a library may be put anywhere
    target = binding.Target.from_triple(binding.get_process_triple()).create_target_machine(
        cpu=codegen._get_host_cpu_name(), features=codegen._tm_features, opt=3, reloc="pic", codemodel="default"
    )
    with timed():
        code = target.emit_object(library._final_module)
    return ObjectCode(code, symbol, lambda: int(library.get_pointer_to_function(symbol)))


def _optimise_whole(library: Any, symbol: str) -> None:
    """Optimise a unit where `build_alone` has kept numba from it; else it is done."""


def build_alone() -> None:
    """Have this process build kernels with less work. None that it compiles from now on can be called in it.

    What it takes out of numba is looked for by name: a version that has another inside builds as numba does.
    """
    global _optimise_whole
    gc.disable()  # what is made is needed to the end
    from numba import _dynfunc
    from numba.core import analysis, codegen, cpu, ir_utils

    def entry_point(context: Any, library: Any, description: Any, environment: Any) -> Any:
        """Return what stands for a kernel among those that numba knows, each by its own."""
        return _dynfunc.make_function(description.lookup_module(), description.qualname, "", 1, environment, (library,))

    changes = (
        (codegen.CPUCodeLibrary, "_optimize_final_module", lambda library: None),
        (codegen.JITCodeLibrary, "_finalize_specific", lambda library: None),
        (codegen.JITCPUCodegen, "_add_module", lambda codegen, module: None),
        (cpu.CPUContext, "get_executable", entry_point),
        (analysis, "compute_live_map", live_variables),
        (ir_utils, "compute_live_map", live_variables),
    )
    if all(hasattr(owner, name) for owner, name, _ in changes):
        optimise = codegen.CPUCodeLibrary._optimize_final_module

        def optimise_whole(library: Any, symbol: str) -> None:
            # each function that stays apart is handed every array of the scene's tables, by up to ten numbers an array:
            # what only the unit can call is laid in where it is called once
            for function in library._final_module.functions:
                if not function.is_declaration and function.name != symbol:
                    function.linkage = "internal"
            optimise(library)

        _optimise_whole = optimise_whole
        for owner, name, instead in changes:
            setattr(owner, name, instead)


Names = Mapping[int, set[str]]
"""Names of variables, for each block of a function."""


def live_variables(graph: Any, blocks: Mapping[int, Any], used: Names, defined: Names) -> dict[int, set[str]]:
    """Return the variables that are alive at the entry of each block of a function, as numba's `compute_live_map`.

    A variable is alive in a block if it, or one that follows it, uses it before it is defined anew. Sets are the bits
    of integers: numba's own sets of names grow with the square of the size of a function.
    """
    bit_of: dict[str, int] = {}

    def bits(names: Iterable[str]) -> int:
        return sum(1 << bit_of.setdefault(name, len(bit_of)) for name in names)

    order = list(graph.topo_order())
    followers, leaders = (
        {at: [other for other, _ in near(at)] for at in order} for near in (graph.successors, graph.predecessors)
    )
    alive, own = {at: bits(used[at]) for at in blocks}, {at: bits(defined[at]) for at in blocks}
    reached = {at: alive[at] | own[at] for at in blocks}

    def spread(
        found: dict[int, int], places: Iterable[int], near: dict[int, list[int]], handed: Callable[[int, int], int]
    ) -> None:
        """Hand what is found on to neighbours until nothing changes."""
        is_changed = True
        while is_changed:
            is_changed = False
            for at in places:
                for other in near[at]:
                    more = found[other] | handed(at, other)
                    is_changed |= more != found[other]
                    found[other] = more

    spread(reached, order, followers, lambda at, other: reached[at])
    spread(alive, order[::-1], leaders, lambda at, other: alive[at] & reached[other] & ~own[other])
    names = list(bit_of)
    return {at: {names[i] for i in _ones(found)} for at, found in alive.items()}


def _ones(bits: int) -> Iterator[int]:
    """Return the places of the ones among bits."""
    while bits:
        least = bits & -bits
        yield least.bit_length() - 1
        bits ^= least


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
