"""Passes over a kernel before it is translated, with less work than numba's own.

numba notes its passes as events, computes after each of them where each variable is alive, and marks where it ends, for
counts of references: kernels count none. At each pass it looks whether loops have more than one way back, which is
known by then, and for each type whether a class was registered for it, which none is.
"""

from functools import cache
from typing import Any

from numba.core import base, compiler_machinery, inline_closurecall, ir, postproc, transforms
from numba.core.types import abstract

from kanefe.kernels.compiler._numba_change import Change

BARE = str, int, float, complex, bool, type(None), bytes, ir.Loc
"""Classes of parts of numba's instructions that have no variables in them."""


def pass_changes() -> tuple[Change, ...]:
    """Return what takes the place of functions of numba."""
    return (
        Change(compiler_machinery.PassManager, "_runPass", _without_events),
        Change(postproc.PostProcessor, "run", _without_ends, "canonicalize_cfg VariableLifetime _insert_var_dels"),
        Change(inline_closurecall.InlineClosureCallPass, "run", _where_there_is_one, "_inline_closure"),
        Change(base, "_has_loc", cache, "pysignature"),
        Change(abstract.Type, "__hash__", _hashed_once, "hash key"),
        Change(abstract._TypeMetaclass, "__instancecheck__", lambda original: type.__instancecheck__),
        Change(ir.Inst, "_rec_list_vars", lambda original: variables_in, "list_vars _rec_list_vars"),
    )


def _without_events(original: Any) -> Any:
    """Return numba's run of a pass without its events."""

    def run(manager: Any, index: int, step: Any, state: Any) -> None:
        step.analysis = manager._analysis
        is_changed = step.run_initialization(state)
        is_changed |= step.run_pass(state)
        is_changed |= step.run_finalizer(state)
        if compiler_machinery._pass_registry.get(type(step)).mutates_CFG:
            if is_changed:
                postproc.PostProcessor(state.func_ir).run()
            else:
                state.func_ir.blocks = _with_single_ways_back(state.func_ir.blocks)

    return run


def _without_ends(original: Any) -> Any:
    """Return numba's look at a function after a pass without the ends of variables."""

    def run(processor: Any, emit_dels: bool = False, extend_lifetimes: bool = False) -> None:
        function = processor.func_ir
        if function.is_generator:
            original(processor, emit_dels, extend_lifetimes)
            return
        function.blocks = _with_single_ways_back(function.blocks)
        function.variable_lifetime = postproc.VariableLifetime(function.blocks)
        function.generator_info = None

    return run


_single: set[tuple[Any, ...]] = set()


def _with_single_ways_back(blocks: dict[int, Any]) -> dict[int, Any]:
    """Return blocks of which one at most leads back to the head of each loop: numba sees that from their ways alone."""
    if _ways_of(blocks) in _single:
        return blocks.copy()
    found: dict[int, Any] = transforms.canonicalize_cfg(blocks)
    _single.add(_ways_of(found))
    return found


def _ways_of(blocks: dict[int, Any]) -> tuple[Any, ...]:
    """Return the number of each block, and those that it leads to."""
    return tuple((label, *block.terminator.get_targets()) for label, block in blocks.items())


def _where_there_is_one(original: Any) -> Any:
    """Return numba's search for functions inside a function and comprehensions, for functions that have some."""

    def run(search: Any) -> None:
        blocks = search.func_ir.blocks.values()
        if any(True for block in blocks for _ in block.find_exprs(op="make_function")):
            original(search)

    return run


def _hashed_once(original: Any) -> Any:
    def value(kind: Any) -> int:
        own = kind.__dict__
        if "own_hash" not in own:
            own["own_hash"] = original(kind)
        return own["own_hash"]  # type: ignore[no-any-return]

    return value


def variables_in(instruction: Any, part: Any) -> list[Any]:
    """Return the variables in a part of an instruction, as numba's `_rec_list_vars`, in the same order."""
    found, waiting = [], [part]
    while waiting:
        one = waiting.pop()
        kind = one.__class__
        if kind is ir.Var:
            found.append(one)
        elif kind in BARE:
            continue
        elif kind is list or kind is tuple:
            waiting.extend(one[::-1])
        elif kind is dict:
            waiting.extend([*one.values()][::-1])
        elif isinstance(one, ir.Inst):
            found += one.list_vars()
        elif isinstance(one, (list, tuple)):
            waiting.extend([*one][::-1])
        elif isinstance(one, dict):
            waiting.extend([*one.values()][::-1])
    return found
