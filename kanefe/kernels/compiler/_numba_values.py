"""Instructions that need not be written: what is known of values while a kernel is translated.

numba writes down each step by which it packs and unpacks tuples and arrays, tests a call for errors in five ways and
looks through variables of a function a dozen times. Here what is taken out of what was just put together is that value,
arithmetic with known numbers is done at once, and what nothing uses is left out before a compiler reads it.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from llvmlite.ir import instructions
from numba.core import callconv, codegen
from numba.core import ir as numba_ir

from kanefe.kernels.compiler._numba_change import Change

COMPARED = {
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}

BARE = str, int, float, complex, bool, type(None), bytes, numba_ir.Loc
"""Classes of parts of numba's instructions that have no variables in them."""

UNUSED = (
    instructions.InsertValue,
    instructions.ExtractValue,
    instructions.GEPInstr,
    instructions.LoadInstr,
    instructions.CompareInstr,
    instructions.SelectInstr,
    instructions.CastInstr,
)
"""Classes of instructions that do nothing but give a value."""


def value_changes() -> tuple[Change, ...]:
    """Return what takes the place of functions of numba and llvmlite."""
    builder = ir.IRBuilder
    return (
        Change(builder, "extract_value", _looked_through, "ExtractValue"),
        Change(builder, "mul", _known_product),
        Change(builder, "add", _known_sum),
        Change(builder, "icmp_signed", _known_comparison),
        Change(builder, "select", _known_choice),
        Change(callconv.CPUCallConv, "_get_return_status", lambda original: _status_of, "icmp_signed or_ not_ select"),
        Change(codegen.CPUCodeLibrary, "add_ir_module", _without_unused, "add_llvm_module"),
        Change(numba_ir.Inst, "_rec_list_vars", lambda original: variables_in, "list_vars _rec_list_vars"),
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


def _number(value: Any) -> int | None:
    """Return a whole number that is known, None of any other value."""
    known = isinstance(value, ir.Constant) and isinstance(value.constant, int) and isinstance(value.type, ir.IntType)
    return value.constant if known else None


def _known_product(original: Callable[..., Any]) -> Callable[..., Any]:
    def mul(builder: Any, a: Any, b: Any, *rest: Any, **named: Any) -> Any:
        for x, other in ((_number(a), b), (_number(b), a)):
            if x == 1:
                return other
            if x == 0:
                return other.type(0)
        return original(builder, a, b, *rest, **named)

    return mul


def _known_sum(original: Callable[..., Any]) -> Callable[..., Any]:
    def add(builder: Any, a: Any, b: Any, *rest: Any, **named: Any) -> Any:
        for x, other in ((_number(a), b), (_number(b), a)):
            if x == 0:
                return other
        return original(builder, a, b, *rest, **named)

    return add


def _known_comparison(original: Callable[..., Any]) -> Callable[..., Any]:
    def compare(builder: Any, how: str, a: Any, b: Any, *rest: Any, **named: Any) -> Any:
        x, y = _number(a), _number(b)
        if x is not None and y is not None:
            return ir.IntType(1)(int(COMPARED[how](x, y)))
        return original(builder, how, a, b, *rest, **named)

    return compare


def _known_choice(original: Callable[..., Any]) -> Callable[..., Any]:
    def select(builder: Any, condition: Any, a: Any, b: Any, *rest: Any, **named: Any) -> Any:
        known = _number(condition)
        return original(builder, condition, a, b, *rest, **named) if known is None else a if known else b

    return select


class CallStatus:
    """How a call ended, as numba's `Status`: each question is put into code where it is asked.

    Parameters
    ----------
    builder : IRBuilder
    code : value
        What the function returned.
    error : value
        Where it says more of an error.
    """

    def __init__(self, builder: Any, code: Any, error: Any) -> None:
        self._builder, self.code, self._error = builder, code, error

    def _is(self, code: Any, how: str = "==") -> Any:
        return self._builder.icmp_signed(how, self.code, code)

    @property
    def is_ok(self) -> Any:
        """Whether there is a result."""
        return self._builder.or_(self._is(callconv.RETCODE_OK), self.is_none)

    @property
    def is_error(self) -> Any:
        """Whether there is none."""
        return self._builder.not_(self.is_ok)

    @property
    def is_none(self) -> Any:
        """Whether it is None."""
        return self._is(callconv.RETCODE_NONE)

    @property
    def is_python_exc(self) -> Any:
        """Whether Python knows the error."""
        return self._is(callconv.RETCODE_EXC)

    @property
    def is_stop_iteration(self) -> Any:
        """Whether an iterator has ended."""
        return self._is(callconv.RETCODE_STOPIT)

    @property
    def is_user_exc(self) -> Any:
        """Whether the function raised."""
        return self._is(callconv.RETCODE_USEREXC, ">=")

    @property
    def excinfoptr(self) -> Any:
        """Where it says what it raised."""
        return self._builder.select(self.is_user_exc, self._error, ir.Constant(self._error.type, ir.Undefined))


def _status_of(convention: Any, builder: Any, code: Any, error: Any) -> CallStatus:
    return CallStatus(builder, code, error)


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
    waiting = [one for block in function.blocks for one in block.instructions if not isinstance(one, UNUSED)]
    while waiting:
        one = waiting.pop()
        ways = one.incomings if isinstance(one, instructions.PhiInstr) else ()
        for operand in (*one.operands, *(value for value, _ in ways)):
            if id(operand) not in used:
                used.add(id(operand))
                if isinstance(operand, UNUSED):
                    waiting.append(operand)
    for block in function.blocks:
        block.instructions[:] = [one for one in block.instructions if not isinstance(one, UNUSED) or id(one) in used]


def variables_in(instruction: Any, part: Any) -> list[Any]:
    """Return the variables in a part of an instruction, as numba's `_rec_list_vars`, in the same order."""
    found, waiting = [], [part]
    while waiting:
        one = waiting.pop()
        kind = one.__class__
        if kind is numba_ir.Var:
            found.append(one)
        elif kind in BARE:
            continue
        elif kind is list or kind is tuple:
            waiting.extend(one[::-1])
        elif kind is dict:
            waiting.extend([*one.values()][::-1])
        elif isinstance(one, numba_ir.Inst):
            found += one.list_vars()
        elif isinstance(one, (list, tuple)):
            waiting.extend([*one][::-1])
        elif isinstance(one, dict):
            waiting.extend([*one.values()][::-1])
    return found
