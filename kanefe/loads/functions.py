"""Functions of loads: constants, and functions of the user of time, or of time and state."""

from __future__ import annotations

import inspect
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector
from kanefe.kernels.compiler._numba_functions import checked

if TYPE_CHECKING:
    from kanefe.loads.controller import Reading


class Spent(threading.local):
    """Time spent in functions of the user called from Python, in a thread, s."""

    seconds = 0.0

    @contextmanager
    def counted(self) -> Iterator[None]:
        """Count the time of the block."""
        began = time.perf_counter()
        try:
            yield
        finally:
            self.seconds += time.perf_counter() - began


SPENT = Spent()


class Moving(Protocol):
    """Motion of a frame F seen from N: position (m) in N, velocity (m/s) and angular velocity (rad/s) in F."""

    A_NF: Matrix
    p_NoFo_N: Vector
    v: Vector
    w: Vector


class SceneView(Protocol):
    """The state passed to a function ``f(t, state)`` of the user: see `kanefe.tree.scene_state.SceneState`."""

    @property
    def vector(self) -> Vector:
        """The state ``y = (q, u)``."""
        ...


@dataclass(frozen=True, eq=False)
class Constant:
    """A constant function of time."""

    value: Any

    def __call__(self, t: float) -> Any:
        """Return the value."""
        return self.value


@dataclass(frozen=True, eq=False)
class Turned:
    """A function of three components, multiplied by a matrix (3, 3)."""

    function: Callable[..., Any]
    axes: Matrix

    def __call__(self, *arguments: Any) -> Any:
        """Return the components; a wrong shape is returned unchanged, for the error of the load."""
        value = np.asarray(self.function(*arguments), dtype=float)
        return self.axes @ value if value.shape == (3,) else value


@dataclass(frozen=True, eq=False)
class CompiledCallback:
    """A function compiled by numba, of time, or of time and the state ``y = (q, u, z)`` as an array.

    Attributes
    ----------
    function : callable
        f(t) or f(t, y), y in the order of `Model.state_names`. It returns a number, or the components of the load.
    takes_state : bool
    label : str
        Name of the load, for messages.
    reads : tuple of Reading
        What f(t, reads) reads in place of y.
    axes : ndarray, shape (3, 3), or None
        By which three components are multiplied: see `Turned`.
    """

    function: Callable[..., Any]
    takes_state: bool
    label: str
    reads: tuple[Reading, ...] = ()
    axes: Matrix | None = None

    def __call__(self, t: float, state: SceneView | None = None) -> Any:
        """Return the value; a ModelError names the load if the function raises, or reads beyond the state."""
        function = checked(self.function) if hasattr(self.function, "py_func") else self.function
        arguments: tuple[Any, ...] = (t,) if not self.takes_state or state is None else (t, state.vector)
        if self.reads and state is not None:
            arguments = t, np.array([reading.of(state) for reading in self.reads])
        try:
            return function(*arguments) if self.axes is None else Turned(function, self.axes)(*arguments)
        except Exception as error:
            text = " ".join(str(error).split()) or "without a message"
            raise ModelError(
                f"the compiled function of {self.label} raised {type(error).__name__} at t = {t:.6g} s: {text[:300]}"
                f"{self._advice(error, arguments)}"
            ) from error

    def _advice(self, error: Exception, arguments: tuple[Any, ...]) -> str:
        if isinstance(error, IndexError) and self.reads:
            return f". Remedy: it reads {len(self.reads)} numbers: {', '.join(read.label for read in self.reads)}"
        if isinstance(error, IndexError) and len(arguments) == 2:
            return (
                f". Remedy: the state y has {len(arguments[1])} entries, named by scene.freeze().state_names: all "
                "coordinates, and then all speeds"
            )
        return ". Remedy: test it in Python, function.py_func"


def multiplied(function: Callable[..., Any], axes: Matrix) -> Callable[..., Any]:
    """Return a function of three components that are multiplied by a matrix (3, 3)."""
    if isinstance(function, Constant):
        return Constant(axes @ function.value)
    if isinstance(function, CompiledCallback):
        return replace(function, axes=axes if function.axes is None else axes @ function.axes)
    return Turned(function, axes)


def callback(function: Callable[..., Any], label: str) -> tuple[Callable[..., Any], bool]:
    """Return a function of the user in the form stored in loads, and whether it takes the state: see `takes_state`."""
    if isinstance(function, CompiledCallback):
        return function, function.takes_state
    plain = getattr(function, "py_func", None)
    if plain is None:
        return function, takes_state(function, label)
    asks = takes_state(plain, label)
    return CompiledCallback(function, asks, label), asks


def takes_state(function: Callable[..., Any], label: str) -> bool:
    """Return whether a function takes (t, state) and not (t); a ModelError names `label` if it takes neither.

    Parameters with defaults are ignored.
    """
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):  # some C functions have no signature; they take the time only
        return False
    positional = [p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    required = [p.name for p in positional if p.default is p.empty]
    named = [p.name for p in parameters if p.kind is p.KEYWORD_ONLY and p.default is p.empty]
    takes_any = any(p.kind is p.VAR_POSITIONAL for p in parameters)
    if named or len(required) > 2 or not (positional or takes_any):
        raise ModelError(
            f"{label} must be a function of time, f(t), or of time and state, f(t, state); "
            f"its parameters are ({', '.join(p.name for p in parameters)})"
        )
    return len(required) == 2
