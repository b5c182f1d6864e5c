"""Linearised sampled controllers: derivatives of their drives and memory by their readings and memory."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector
from kanefe.loads.controller import Controller

STEP = 6e-6
"""Step of central differences, relative to a number or to one: the cube root of the precision."""

CALLS = 2000
"""Largest number of calls of a controller with constant inputs until its memory is constant."""

SETTLED = 1e-12
"""Change of the memory from one call to the next, relative to its size, that counts as zero."""

ALIKE = 1e-9
"""Difference of two calls with the same arguments, relative to their size, that counts as zero."""

NOTHING = 1e-9
"""Derivative relative to the largest that is round-off of differences."""


@dataclass(frozen=True, eq=False)
class LinearLaw:
    """A controller about a rest: ``drives = K y + L m, m next = N y + P m`` in deviations from the rest.

    Attributes
    ----------
    controller : Controller
    drives : ndarray, shape (d,)
        At rest.
    K, L : ndarray, shape (d, r) and (d, m)
    N, P : ndarray, shape (m, r) and (m, m)
        For those numbers in its memory that readings change and that change drives.
    names : tuple of str
        Names of these numbers.
    """

    controller: Controller
    drives: Vector
    K: Matrix
    L: Matrix
    N: Matrix
    P: Matrix
    names: tuple[str, ...]


def linear_law(controller: Controller, t: float, reads: Vector) -> LinearLaw:
    """Linearise a controller about its readings at rest, at a fixed time (s).

    Raises
    ------
    ModelError
        If its memory contains anything but numbers, or it keeps data elsewhere.
    """
    label = f"controller {controller.name!r}"
    memory = _settled(controller, t, reads)
    names, m = _numbers_in(memory, label)

    def called(y: Vector, numbers_of: Vector) -> tuple[Vector, Vector]:
        kept = _with_numbers(memory, list(numbers_of))
        drives = _drives(controller, t, y, kept)
        after, values = _numbers_in(kept, label)
        if after != names:
            raise ModelError(
                f"the memory of {label} changes its shape from call to call ({', '.join(set(after) ^ set(names))}). "
                "Remedy: numbers and arrays of fixed shape in its memory"
            )
        return drives, values

    drives, _ = called(reads, m)
    again, _ = called(reads, m)
    if np.any(np.abs(again - drives) > ALIKE * (1.0 + np.abs(drives))):
        raise ModelError(
            f"{label} gives two different results for the same inputs: it keeps something outside of its memory, or "
            "draws random numbers, and has no poles. Remedy: keep it in the third argument, memory"
        )
    r = len(reads)
    of_reads = _differences(lambda y: np.concatenate(called(y, m)), reads)
    of_memory = _differences(lambda kept: np.concatenate(called(reads, kept)), m)
    d = len(drives)
    K, N, L, P = of_reads[:d], of_reads[d:], of_memory[:d], of_memory[d:]
    kept = _reached(P, N.reshape(len(m), r)) & _reached(P.T, L.T)
    return LinearLaw(
        controller,
        drives,
        K,
        L[:, kept],
        N[kept],
        P[np.ix_(kept, kept)],
        tuple(f"{controller.name}: {name}" for name, is_kept in zip(names, kept, strict=True) if is_kept),
    )


def _settled(controller: Controller, t: float, reads: Vector) -> dict[str, Any]:
    """Return the memory of a controller after many samples at rest, at a fixed time."""
    label = f"controller {controller.name!r}"
    memory = controller.new_memory()
    before = np.zeros(0)
    for _ in range(CALLS):
        _drives(controller, t, reads, memory)
        _, values = _numbers_in(memory, label)
        if values.shape == before.shape:
            change = np.abs(values - before).max(initial=0.0)
            if change <= SETTLED * max(1.0, np.abs(values).max(initial=0.0)):
                break
        before = values
    return memory


def _drives(controller: Controller, t: float, reads: Vector, memory: Any) -> Vector:
    values = np.atleast_1d(np.asarray(controller.function(t, reads.copy(), memory), dtype=float))
    if values.shape != (controller.drive_count,) or not np.all(np.isfinite(values)):
        raise ModelError(
            f"controller {controller.name!r} must give {controller.drive_count} finite numbers about the rest at "
            f"t = {t:.6g} s, not {values!r}"
        )
    return values


def _differences(function: Callable[[Vector], Vector], at: Vector) -> Matrix:
    """Return derivatives by central differences, (values, arguments), without round-off."""
    columns = []
    for i, value in enumerate(at):
        step = np.zeros(len(at))
        step[i] = STEP * max(abs(value), 1.0)
        columns.append((function(at + step) - function(at - step)) / (2.0 * step[i]))
    if not columns:
        return np.zeros((len(function(at)), 0))
    found = np.column_stack(columns)
    return np.where(np.abs(found) > NOTHING * np.abs(found).max(axis=1, keepdims=True, initial=0.0), found, 0.0)


def _reached(P: Matrix, start: Matrix) -> np.ndarray:
    """Return which numbers change eventually if those with nonzero rows in `start` change."""
    found = np.any(start != 0.0, axis=1)
    for _ in range(len(P)):
        found = found | np.any(P[:, found] != 0.0, axis=1)
    return found


def _numbers_in(memory: object, label: str, name: str = "") -> tuple[tuple[str, ...], Vector]:
    """Return names and values of all numbers in a memory, in a fixed order."""
    if isinstance(memory, dict):
        parts = [_numbers_in(value, label, f"{name}.{key}" if name else str(key)) for key, value in memory.items()]
    elif isinstance(memory, (list, tuple, deque)):
        parts = [_numbers_in(value, label, f"{name}[{i}]") for i, value in enumerate(memory)]
    elif isinstance(memory, np.ndarray) and memory.dtype.kind in "fiu":
        parts = [((f"{name}[{i}]",), np.array((value,), dtype=float)) for i, value in enumerate(memory.ravel())]
    elif isinstance(memory, (bool, np.bool_, str, type(None))):
        parts = []
    elif isinstance(memory, (int, float, np.number)):
        return (name,), np.array((float(memory),))
    else:
        raise ModelError(
            f"{label} remembers {name!r}, a {type(memory).__name__}, which cannot be linearised. Remedy: "
            "numbers and arrays in its memory"
        )
    names = tuple(one for part, _ in parts for one in part)
    return names, np.concatenate([values for _, values in parts]) if parts else np.zeros(0)


def _with_numbers(memory: Any, values: list[float]) -> Any:
    """Return a copy of a memory with its numbers replaced, in the order of `_numbers_in`; `values` is used up."""
    if isinstance(memory, dict):
        return {key: _with_numbers(value, values) for key, value in memory.items()}
    if isinstance(memory, (list, tuple)):
        return type(memory)([_with_numbers(value, values) for value in memory])
    if isinstance(memory, deque):
        return deque([_with_numbers(value, values) for value in memory], memory.maxlen)
    if isinstance(memory, np.ndarray) and memory.dtype.kind in "fiu":
        return np.array([values.pop(0) for _ in range(memory.size)]).reshape(memory.shape)
    if isinstance(memory, (int, float, np.number)) and not isinstance(memory, bool):
        return cast(Any, values.pop(0))
    return deepcopy(memory)
