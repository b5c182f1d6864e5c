"""Functions of loads: constants, and those of the user, which may ask for the state besides the time."""

from __future__ import annotations

import inspect
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector
from kanefe.kernels.compiler._numba_functions import checked


class Spent(threading.local):
    """How long functions of the user have been called from Python, in a thread, s."""

    seconds = 0.0

    @contextmanager
    def counted(self) -> Iterator[None]:
        """Count the time of what is inside."""
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
    """What a function ``f(t, state)`` of the user is given: see `kanefe.tree.scene_state.SceneState`."""

    @property
    def vector(self) -> Vector:
        """The state ``y = (q, u)``."""
        ...


@dataclass(frozen=True, eq=False)
class Constant:
    """A function of time that is the same at all times, and known to be."""

    value: Any

    def __call__(self, t: float) -> Any:
        """Return the value."""
        return self.value


@dataclass(frozen=True, eq=False)
class Turned:
    """Three components that a function gives, turned by a matrix (3, 3)."""

    function: Callable[..., Any]
    axes: Matrix

    def __call__(self, *arguments: Any) -> Any:
        """Return them; a wrong shape is left alone, and named where the load is read."""
        value = np.asarray(self.function(*arguments), dtype=float)
        return self.axes @ value if value.shape == (3,) else value


@dataclass(frozen=True, eq=False)
class CompiledCallback:
    """A function that numba has compiled: of the time, or of the time and the state ``y = (q, u, z)`` as an array.

    Attributes
    ----------
    function : callable
        f(t) or f(t, y), y in the order of `Model.state_names`. It returns a number, or as many as the load has.
    takes_state : bool
    label : str
        Of the load, for messages.
    """

    function: Callable[..., Any]
    takes_state: bool
    label: str

    def __call__(self, t: float, state: SceneView | None = None) -> Any:
        """Return what the function gives; a ModelError names the load if it raises, or reads beyond the state."""
        function = checked(self.function)
        arguments = (t,) if not self.takes_state or state is None else (t, state.vector)
        try:
            return function(*arguments)
        except Exception as error:
            told = " ".join(str(error).split()) or "without a word"
            raise ModelError(
                f"the compiled function of {self.label} raised {type(error).__name__} at t = {t:.6g} s: {told[:300]}"
                f"{self._advice(error, arguments)}"
            ) from error

    def _advice(self, error: Exception, arguments: tuple[Any, ...]) -> str:
        if isinstance(error, IndexError) and len(arguments) == 2:
            return (
                f". Remedy: the state y has {len(arguments[1])} entries, named by scene.freeze().state_names: all "
                "coordinates, and then all speeds"
            )
        return ". Remedy: test it in Python, function.py_func"


def callback(function: Callable[..., Any], label: str) -> tuple[Callable[..., Any], bool]:
    """Return a function of the user as loads keep it, and whether it takes the state; see `takes_state`."""
    plain = getattr(function, "py_func", None)
    if plain is None:
        return function, takes_state(function, label)
    asks = takes_state(plain, label)
    return CompiledCallback(function, asks, label), asks


def takes_state(function: Callable[..., Any], label: str) -> bool:
    """Return whether a function is one of (t, state), and not of (t); a ModelError names `label` if it is neither.

    Parameters that have defaults are the user's own and do not count.
    """
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):  # some functions in C do not tell; those of numbers take one
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
