"""Loops over ranges of whole numbers while a library is built: a number that grows until it is at the end.

numba counts down how many numbers are left, which it finds by division, and hands each on through memory.
"""

import importlib
from typing import Any

from numba.core import base, cgutils, types
from numba.core.imputils import lower_builtin

from kanefe.kernels.compiler._numba_change import Change
from kanefe.kernels.compiler._numba_values import known_number


def loop_changes() -> tuple[Change, ...]:
    """Return what takes the place of functions of numba."""
    return (
        Change(base.BaseContext, "pair_first", lambda original: _first, "make_helper first"),
        Change(base.BaseContext, "pair_second", lambda original: _second, "make_helper second"),
    )


def add_ranges() -> None:
    """Have numba loop over ranges as it is done here."""
    importlib.import_module("numba.cpython.rangeobj")  # what is registered last counts
    number = types.int64
    for count in (1, 2, 3):
        lower_builtin(range, *[number] * count)(_range)
    lower_builtin("getiter", types.range_state64_type)(_begin)
    lower_builtin("iternext", types.range_iter64_type)(_next)


def _first(context: Any, builder: Any, pair: Any, kind: Any) -> Any:
    return builder.extract_value(pair, 0)


def _second(context: Any, builder: Any, pair: Any, kind: Any) -> Any:
    return builder.extract_value(pair, 1)


def _range(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    number = context.get_value_type(types.int64)
    start, stop, step = (number(0), *arguments, number(1)) if len(arguments) == 1 else (*arguments, number(1))[:3]
    return cgutils.make_anonymous_struct(builder, (start, stop, step))


def _begin(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    start, stop, step = (builder.extract_value(arguments[0], i) for i in range(3))
    place = cgutils.alloca_once(builder, start.type)
    builder.store(start, place)
    return cgutils.make_anonymous_struct(builder, (place, stop, step), context.get_value_type(signature.return_type))


def _next(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    place, stop, step = (builder.extract_value(arguments[0], i) for i in range(3))
    value, known = builder.load(place), known_number(step)
    up, down = (lambda: builder.icmp_signed("<", value, stop)), (lambda: builder.icmp_signed(">", value, stop))
    if known is None:
        is_inside = builder.select(builder.icmp_signed(">", step, step.type(0)), up(), down())
    else:
        is_inside = up() if known > 0 else down()
    builder.store(builder.add(value, step), place)
    return cgutils.make_anonymous_struct(builder, (value, is_inside))
