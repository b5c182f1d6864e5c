"""Instructions that need not be written: what is known of values while a kernel is translated.

numba writes down each step by which it packs and unpacks tuples and arrays. Here what is taken out of what was just put
together is that value, arithmetic with known numbers is done at once, what a block has calculated is not calculated in
it again, and what nothing uses is left out before a compiler reads it.
"""

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from llvmlite.ir import instructions
from numba.core import codegen

from kanefe.kernels.compiler._numba_change import Change

COMPARED = {
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}

VALUES = {
    instructions.InsertValue,
    instructions.ExtractValue,
    instructions.GEPInstr,
    instructions.LoadInstr,
    instructions.ICMPInstr,
    instructions.FCMPInstr,
    instructions.SelectInstr,
    instructions.CastInstr,
    instructions.Instruction,  # arithmetic
}
"""Classes of instructions that do nothing but give a value."""


def value_changes() -> tuple[Change, ...]:
    """Return what takes the place of functions of numba and llvmlite."""
    builder = ir.IRBuilder
    return (
        Change(builder, "extract_value", _looked_through, "ExtractValue"),
        Change(builder, "mul", _known_product),
        Change(builder, "add", _known_sum),
        Change(builder, "sub", _known_difference),
        Change(builder, "icmp_signed", _known_comparison),
        Change(builder, "select", _known_choice),
        Change(codegen.CPUCodeLibrary, "add_ir_module", _without_unused, "add_llvm_module"),
    )


def _looked_through(original: Callable[..., Any]) -> Callable[..., Any]:
    """Return llvmlite's extraction with what was put into a structure taken from where it comes from."""

    def extract(builder: Any, structure: Any, where: Any, name: str = "") -> Any:
        at = tuple(where) if isinstance(where, (tuple, list)) else (where,)
        while isinstance(structure, instructions.InsertValue):
            put = tuple(structure.indices)
            if at[: len(put)] == put:
                structure, at = structure.operands[1], at[len(put) :]
                if not at:
                    return structure
            elif put[: len(at)] == at:
                break  # a part of what is asked for was put in
            else:
                structure = structure.operands[0]
        return original(builder, structure, at, name)

    return extract


def known_number(value: Any) -> int | None:
    """Return a whole number that is known, None of any other value."""
    known = isinstance(value, ir.Constant) and isinstance(value.constant, int) and isinstance(value.type, ir.IntType)
    return value.constant if known else None


def _known_product(original: Callable[..., Any]) -> Callable[..., Any]:
    def mul(builder: Any, a: Any, b: Any, *rest: Any, **named: Any) -> Any:
        for x, other in ((known_number(a), b), (known_number(b), a)):
            if x == 1:
                return other
            if x == 0:
                return other.type(0)
        return _once(original, builder, "mul", a, b, *rest, **named)

    return mul


def _known_sum(original: Callable[..., Any]) -> Callable[..., Any]:
    def add(builder: Any, a: Any, b: Any, *rest: Any, **named: Any) -> Any:
        for x, other in ((known_number(a), b), (known_number(b), a)):
            if x == 0:
                return other
        return _once(original, builder, "add", a, b, *rest, **named)

    return add


def _known_difference(original: Callable[..., Any]) -> Callable[..., Any]:
    def sub(builder: Any, a: Any, b: Any, *rest: Any, **named: Any) -> Any:
        return a if known_number(b) == 0 else _once(original, builder, "sub", a, b, *rest, **named)

    return sub


def _known_comparison(original: Callable[..., Any]) -> Callable[..., Any]:
    def compare(builder: Any, how: str, a: Any, b: Any, *rest: Any, **named: Any) -> Any:
        x, y = known_number(a), known_number(b)
        if x is not None and y is not None:
            return ir.IntType(1)(int(COMPARED[how](x, y)))
        return _once(original, builder, how, how, a, b, *rest, **named)

    return compare


def _known_choice(original: Callable[..., Any]) -> Callable[..., Any]:
    def select(builder: Any, condition: Any, a: Any, b: Any, *rest: Any, **named: Any) -> Any:
        known = known_number(condition)
        if known is None:
            return _once(original, builder, "select", condition, a, b, *rest, **named)
        return a if known else b

    return select


def _once(original: Callable[..., Any], builder: Any, code: str, /, *operands: Any, **named: Any) -> Any:
    """Return an instruction, or the same one where its block has it already."""
    if named:
        return original(builder, *operands, **named)
    known = builder.block.__dict__.setdefault("known", {})
    key = code, *(one if isinstance(one, (str, ir.Constant)) else id(one) for one in operands)
    if key not in known:
        known[key] = original(builder, *operands)
    return known[key]


def _without_unused(original: Callable[..., Any]) -> Callable[..., Any]:
    """Return numba's handing over of a module, without instructions whose values nothing uses."""

    def add(library: Any, module: Any) -> None:
        for function in module.functions:
            if not function.is_declaration:
                leave_out_unused(function)
        original(library, module)

    return add


def leave_out_unused(function: Any) -> None:
    """Take instructions out of a function whose values nothing uses."""
    used: set[int] = set()
    waiting = [one for block in function.blocks for one in block.instructions if type(one) not in VALUES]
    while waiting:
        one = waiting.pop()
        ways = one.incomings if isinstance(one, instructions.PhiInstr) else ()
        for operand in (*one.operands, *(value for value, _ in ways)):
            if id(operand) not in used:
                used.add(id(operand))
                if type(operand) in VALUES:
                    waiting.append(operand)
    for block in function.blocks:
        block.instructions[:] = [one for one in block.instructions if type(one) not in VALUES or id(one) in used]
