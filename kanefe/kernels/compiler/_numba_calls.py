"""Calls between kernels while a library is built: a kernel returns what it gives, and nothing else.

numba's functions return how they ended, write their result where they are told and, at each call, are asked whether
they raised: twenty instructions in six blocks. Kernels raise nothing. What numba would raise in its own functions, as
for arrays of unlike lengths, is a fault of a kernel: it ends the process, with a signal.
"""

import importlib
import operator
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import callconv, cpu, dispatcher, errors
from numba.core.imputils import lower_builtin
from numba.core.types import misc

from kanefe.kernels.compiler._numba_change import Change
from kanefe.kernels.compiler._numba_values import known_number


def call_changes() -> tuple[Change, ...]:
    """Return what takes the place of functions of numba and llvmlite."""
    return (
        Change(cpu.CPUContext, "call_conv", lambda original: property(ByValue)),
        Change(ir.IRBuilder, "if_then", _where_it_may_be),
        Change(dispatcher.Dispatcher, "get_call_template", _of_any_number, "fold_argument_types compile"),
    )


class NeverFails:
    """How a call ended, as numba's `Status`."""

    code = ir.Constant(ir.IntType(32), 0)
    is_ok = ir.Constant(ir.IntType(1), 1)
    is_none = is_error = is_stop_iteration = is_python_exc = is_user_exc = ir.Constant(ir.IntType(1), 0)
    excinfoptr = None


class ByValue(callconv.CPUCallConv):  # type: ignore[misc]
    """How kernels are called."""

    def get_function_type(self, restype: Any, argtypes: Any) -> Any:
        """Return the type of a function in machine code."""
        if isinstance(restype, misc.Optional):
            raise errors.UnsupportedError("a kernel that returns a value or None")
        return ir.FunctionType(self._returned(restype), [*self._get_arg_packer(argtypes).argument_types])

    def _returned(self, kind: Any) -> Any:
        return ir.VoidType() if kind is types.none else self.context.data_model_manager[kind].get_return_type()

    def decorate_function(self, fn: Any, args: Any, fe_argtypes: Any, noalias: bool = False) -> None:
        """Leave the arguments, dozens of each function that is called, without names."""

    def get_arguments(self, func: Any) -> Any:
        """Return the arguments of a function in machine code."""
        return func.args

    def return_value(self, builder: Any, retval: Any) -> None:
        """End a function with a value."""
        if isinstance(builder.function.function_type.return_type, ir.VoidType):
            builder.ret_void()
        else:
            builder.ret(retval)

    def return_native_none(self, builder: Any) -> None:
        """End a function without a value."""
        builder.ret_void()

    def return_user_exc(self, builder: Any, *args: Any, **kwargs: Any) -> None:
        """End the process."""
        builder.call(builder.module.declare_intrinsic("llvm.trap", (), ir.FunctionType(ir.VoidType(), ())), ())
        builder.unreachable()

    def return_status_propagate(self, builder: Any, status: Any) -> None:
        """Do nothing: no call fails."""

    def raise_error(self, builder: Any, pyapi: Any, status: Any) -> None:
        """Do nothing: no call fails."""

    def call_function(
        self, builder: Any, callee: Any, resty: Any, argtys: Any, args: Any, attrs: Any = None
    ) -> tuple[NeverFails, Any]:
        """Call a function."""
        found = builder.call(callee, self._get_arg_packer(argtys).as_arguments(builder, args))
        if resty is types.none:
            return NeverFails(), self.context.get_dummy_value()
        return NeverFails(), self.context.get_returned_value(builder, resty, found)


def _where_it_may_be(original: Callable[..., Any]) -> Callable[..., Any]:
    """Return llvmlite's branch on a condition that writes nothing where it is known not to hold."""

    @contextmanager
    def if_then(builder: Any, condition: Any, likely: bool | None = None) -> Iterator[Any]:
        if known_number(condition) == 0:
            here, blocks = builder.block, builder.function.blocks
            count, nowhere = len(blocks), ir.Block(parent=builder.function)
            builder.position_at_end(nowhere)
            yield nowhere
            del blocks[count:]
            builder.position_at_end(here)
        else:
            with original(builder, condition, likely) as end:
                yield end

    return if_then


def _of_any_number(original: Callable[..., Any]) -> Callable[..., Any]:
    """Return numba's choice of a compiled kernel without one for each constant that it is called with."""

    def template(kernel: Any, args: Any, kws: Any) -> Any:
        plain = tuple(map(misc.unliteral, args)), {name: misc.unliteral(kind) for name, kind in kws.items()}
        try:
            return original(kernel, *plain)
        except errors.TypingError:  # an index of a tuple of unlike parts must be known
            return original(kernel, args, kws)

    return template


def add_division() -> None:
    """Have numba divide complex numbers as real ones: by zero there are infinite numbers, or none."""
    importlib.import_module("numba.cpython.numbers")  # what is registered last counts
    callconv.PythonErrorModel.raise_on_fp_zero_division = False  # in numba's own functions
    for divide in (operator.truediv, operator.itruediv):
        lower_builtin(divide, types.Complex, types.Complex)(_divide)


def _divide(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    kind = signature.return_type
    a, b = (context.make_complex(builder, kind, value=value) for value in arguments)
    found = context.make_complex(builder, kind)
    found.real, found.imag = quotient(builder, a.real, a.imag, b.real, b.imag)
    return found._getvalue()


def quotient(builder: Any, a: Any, b: Any, c: Any, d: Any) -> tuple[Any, Any]:
    """Return both parts of (a + i b) / (c + i d), by the larger part of c and d (R. L. Smith 1962, Algorithm 116)."""
    size = builder.module.declare_intrinsic("llvm.fabs", (c.type,))
    is_turned = builder.fcmp_ordered("<", builder.call(size, (c,)), builder.call(size, (d,)))
    x, y = (builder.select(is_turned, *pair) for pair in ((b, a), (a, b)))
    large, small = (builder.select(is_turned, *pair) for pair in ((d, c), (c, d)))
    ratio = builder.fdiv(small, large)
    denominator = builder.fadd(large, builder.fmul(small, ratio))
    imaginary = builder.fdiv(builder.fsub(y, builder.fmul(x, ratio)), denominator)
    return (
        builder.fdiv(builder.fadd(x, builder.fmul(y, ratio)), denominator),
        builder.select(is_turned, builder.fneg(imaginary), imaginary),
    )
