"""Builds of kernels with less work than numba's own, in a process that does nothing but build.

numba makes machine code of each kernel that another calls, for calls from Python, and links and optimises it with all
that it calls, once more in each of its callers. It chooses anew among built-in functions at each call, hands an array
over as seven numbers and more, of which a scene has dozens, and keeps and clears variables for counts of references.
Kernels count none, are called by each other alone, and most arrays are contiguous: here a kernel is translated without
all this and left so until the whole unit is optimised, once. What is computed is the same.
"""

import gc
from collections.abc import Callable
from typing import Any

from kanefe.kernels.compiler._numba_change import Change

_is_alone = False


def build_alone() -> bool:
    """Have this process build kernels with less work. None that it compiles from now on can be called in it.

    Returns
    -------
    done : bool
        False if this version of numba has another inside: it builds as numba does.
    """
    global _is_alone
    gc.disable()  # what is made is needed to the end
    from numba import _dynfunc
    from numba.core import base, codegen, cpu, lowering
    from numba.core.types import functions

    def entry_point(context: Any, library: Any, description: Any, environment: Any) -> Any:
        """Return what stands for a kernel among those that numba knows, each by its own."""
        return _dynfunc.make_function(description.lookup_module(), description.qualname, "", 1, environment, (library,))

    from kanefe.kernels.compiler._numba_arrays import add_views_and_spans, array_changes
    from kanefe.kernels.compiler._numba_calls import add_division, call_changes
    from kanefe.kernels.compiler._numba_loops import add_ranges, loop_changes
    from kanefe.kernels.compiler._numba_passes import pass_changes
    from kanefe.kernels.compiler._numba_values import value_changes

    library, lower = codegen.CPUCodeLibrary, lowering.Lower
    changes = (
        Change(library, "_optimize_functions", lambda original: _leave_as_it_is, "data_layout _data_layout"),
        Change(library, "add_linking_library", lambda original: original, "_linking_libraries"),
        Change(library, "finalize", lambda original: _leave_apart, "_final_module _finalize_final_module"),
        Change(cpu.CPUContext, "get_executable", lambda original: entry_point),
        Change(functions.BaseFunction, "get_call_type", _resolved_once, "templates apply _impl_keys get_impl_key"),
        Change(base.BaseContext, "get_abi_sizeof", _asked_once, "get_abi_size target_data"),
        Change(lower, "_find_singly_assigned_variable", _with_dominating, "_singly_assigned_vars _blk_local_varmap"),
        Change(lower, "storevar", _without_counts_in_store, "_alloca_var _singly_assigned_vars getvar"),
        Change(lower, "delvar", _without_counts, "_alloca_var _singly_assigned_vars decref"),
        *array_changes(),
        *call_changes(),
        *loop_changes(),
        *pass_changes(),
        *value_changes(),
    )
    add_division()
    _is_alone = all(change.fits() for change in changes)
    if _is_alone:
        for change in changes:
            change.make()
        add_views_and_spans()
        add_ranges()
    return _is_alone


def _leave_as_it_is(library: Any, module: Any) -> None:
    """Add a module to a library without optimising it."""
    module.data_layout = library._codegen._data_layout


def _leave_apart(library: Any) -> None:
    """Close a library without what it calls, and without machine code."""
    library._raise_if_finalized()
    library._finalized = True


def is_alone() -> bool:
    """Return whether this process builds and does nothing else."""
    return _is_alone


def _resolved_once(original: Callable[..., Any]) -> Callable[..., Any]:
    """Return numba's choice of a built-in function for types of arguments with what it chose before."""
    found: dict[Any, tuple[Any, Any]] = {}

    def choose(function: Any, context: Any, args: tuple[Any, ...], kws: Any) -> Any:
        if kws:
            return original(function, context, args, kws)
        key = function, context, args
        if key not in found:
            signature = original(function, context, args, kws)
            found[key] = signature, function._impl_keys[signature.args]
        signature, function._impl_keys[signature.args] = found[key]
        return signature

    return choose


def _asked_once(original: Callable[..., int]) -> Callable[..., int]:
    """Return numba's function of the size of a type, which has the compiler read a text, with what it found before."""
    found: dict[str, int] = {}

    def size(context: Any, kind: Any) -> int:
        name = str(kind)
        if name not in found:
            found[name] = original(context, kind)
        return found[name]

    return size


def _with_dominating(original: Callable[..., None]) -> Callable[..., None]:
    """Return numba's search for variables that need no memory, with those that are used beyond their own block.

    They are set once, in a block through which each way to their uses leads: their values are known there.
    """

    def find(lower: Any) -> None:
        original(lower)
        if lower.context.enable_nrt or lower.func_ir.func_id.is_generator:
            return
        from numba.core import analysis, ir

        blocks = lower.func_ir.blocks
        dominators = analysis.compute_cfg_from_blocks(blocks).dominators()
        places: dict[str, list[int]] = {}
        for at, block in blocks.items():
            for statement in block.find_insts(ir.Assign):
                places.setdefault(statement.target.name, []).append(at)
        used, ours = analysis.compute_use_defs(blocks), {name for name, at in places.items() if len(at) == 1}
        ours -= analysis.must_use_alloca(blocks)
        for at, names in used.usemap.items():
            ours -= {name for name in names & ours if not (places[name][0] < at and places[name][0] in dominators[at])}
        lower._singly_assigned_vars |= ours

    return find


def _without_counts(original: Callable[..., None]) -> Callable[..., None]:
    """Return numba's end of a variable without what only counts of references need."""

    def delete(lower: Any, name: str) -> None:
        if lower.context.enable_nrt:
            original(lower, name)

    return delete


def _without_counts_in_store(original: Callable[..., None]) -> Callable[..., None]:
    """Return numba's store of a variable without reading the value before it."""

    def store(lower: Any, value: Any, name: str, argidx: Any = None) -> None:
        is_plain = argidx is None and not lower.context.enable_nrt and name not in lower._singly_assigned_vars
        if not is_plain:
            original(lower, value, name, argidx)
            return
        lower._alloca_var(name, lower.typeof(name))
        lower.builder.store(value, lower.getvar(name))

    return store
