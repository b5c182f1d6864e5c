"""What kernels are marked as is what they are compiled as, whoever calls them first."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import re
from collections.abc import Callable, Iterator
from typing import Any

import pytest

import kanefe.kernels
from kanefe.kernels.compiler._numba import IS_COMPILED, dispatcher, exact, inlined, kernel

INHERITED = {"_nrt", "fastmath", "error_model", "forceinline"}
"""Options that numba takes from the first caller of a kernel, where it is not told."""


@kernel
def tripled(x: float) -> float:
    """Return a multiple of a number."""
    return 3.0 * x


@exact
def rounded(a: float, b: float) -> float:
    """Return a sum after a product."""
    return a * b + a


@inlined
def calling(a: float, b: float) -> float:
    """Return what both give."""
    return tripled(a) + rounded(a, b)


def marked_kernels() -> Iterator[tuple[str, Callable[..., Any]]]:
    for module in pkgutil.walk_packages(kanefe.kernels.__path__, "kanefe.kernels."):
        if ".compiler." in module.name:
            continue
        for name, value in vars(importlib.import_module(module.name)).items():
            if hasattr(value, "kernel_options"):
                yield f"{module.name}.{name}", value


def test_nothing_that_callers_hand_on_is_left_unsaid() -> None:
    options = {name: one.kernel_options for name, one in marked_kernels()}  # type: ignore[attr-defined]
    alone = {name: one for name, one in options.items() if one.get("inline") != "always"}
    assert len(alone) > 500
    assert [name for name, one in alone.items() if not one.keys() >= INHERITED] == []


@pytest.mark.skipif(not IS_COMPILED, reason="nothing is compiled")
def test_numba_hands_on_no_other_options() -> None:
    from numba.core.cpu import CPUTargetOptions

    source = inspect.getsource(CPUTargetOptions.finalize)
    assert set(re.findall(r'inherit_if_not_set\("(\w+)"', source)) <= {one.lstrip("_") for one in INHERITED}


@pytest.mark.skipif(not IS_COMPILED, reason="nothing is compiled")
def test_a_kernel_stays_one_and_an_exact_one_exact_when_an_inlined_one_calls_it_first() -> None:
    from numba import float64

    outer = dispatcher(calling)
    outer.compile((float64, float64))
    (made,) = outer.overloads.values()
    assert made.fndesc.inline
    for function, is_relaxed in ((tripled, True), (rounded, False)):
        inner = dispatcher(function)
        (made,) = inner.overloads.values()
        assert not made.fndesc.inline
        (code,) = inner.inspect_llvm().values()
        assert ("contract" in code) == is_relaxed
