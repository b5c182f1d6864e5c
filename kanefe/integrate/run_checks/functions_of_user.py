"""Whether functions of the user are functions of time and state: noise, a memory of their own, jumps and gaps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.loads.controller import Held
from kanefe.loads.functions import CompiledCallback
from kanefe.loads.valued_load import ValuedLoad
from kanefe.tree.load_names import named_loads
from kanefe.tree.scales import state_scales
from kanefe.tree.scene_state import SceneState

SAME = 1e-9
"""Largest difference of two calls with the same arguments, relative to the larger value: some functions iterate."""

NEAR = 1e-8, 1e-6, 1e-4
"""Distances of two states between which a function jumps, relative to `state_scales`."""

JUMP = 0.1
"""Difference of a function between such states, relative to its largest value there, from which on it jumps."""

DIRECTIONS = 8
"""Number of directions from a state in which a jump is looked for."""

AS_SAMPLED = "add_controller(..., every=...) for what keeps a memory, measures or is sampled; a table for noise"
AS_EVENT = "kf.Event for a switch, or a smooth function such as tanh, or add_controller(..., every=...)"


def values_of_functions(model: Model, t: float, y: Vector) -> dict[str, Vector]:
    """Return what loads that are Python functions give at a time (s) and a state (q, u, z, ...), by their labels.

    Raises
    ------
    ModelError
        If one gives another in a second call: it is no function of time and state.
    """
    found, state = {}, model.route.state(t, y)
    for label, load in _called_in_python(model):
        first, second = _value(load, t, state), _value(load, t, state)
        if _differ(first, second):
            raise ModelError(
                f"{label} gave {_shown(first)} and then {_shown(second)} at t = {t:.6g} s in the same state: it is "
                f"noisy or keeps a state of its own, and a method may ask again at any time. Remedy: {AS_SAMPLED}"
            )
        found[label] = first
    return found


def changed_by_run(model: Model, t: float, y: Vector, before: Mapping[str, Vector]) -> str:
    """Return what is told of functions that give another value than before the run at its start; empty: none does."""
    state = model.route.state(t, y)
    for label, load in _called_in_python(model):
        again = _value(load, t, state)
        if _differ(before[label], again):
            return (
                f"{label} gave {_shown(before[label])} before the run and {_shown(again)} after it, at the same t = "
                f"{t:.6g} s in the same state: it keeps a state of its own, so that the result depends on how often it "
                f"was asked. Remedy: {AS_SAMPLED}"
            )
    return ""


def with_jump(model: Model, t: float, y: Vector) -> str:
    """Return what is told of a function that jumps with the state near one where a run comes to a halt; or nothing."""
    rng, scales = np.random.default_rng(0), state_scales(model)
    for label, load in _of_state(model):
        for near in NEAR:
            values = []
            for _ in range(DIRECTIONS):
                step = near * scales * rng.uniform(-1.0, 1.0, len(scales))
                values += [_value(load, t, model.route.state(t, y + way * step)) for way in (-1.0, 1.0)]
            found = np.array(values)
            spread, size = np.ptp(found, axis=0).max(), np.abs(found).max()
            if spread > JUMP * size > 0.0:
                return f"{label} jumps by {spread:.2g} within {near:g} of the size of states. Remedy: {AS_EVENT}"
    return ""


def asks_for_state(model: Model) -> bool:
    """Return whether functions of the user, compiled or not, look at the state."""
    return any(True for _ in _of_state(model))


def across_jump(model: Model, hardest: tuple[float, Vector] | None) -> str:
    """Return what is told of a function that jumps with the state where rejected steps have clustered; or nothing.

    `hardest` is that of `kanefe.integrate.stepper.Stepper`.
    """
    told = ""
    if hardest is not None:
        with suppress(Exception):  # of the user's function, which the run has told of
            told = with_jump(model, *hardest)
    where, _, remedy = told.partition(". Remedy: ")
    if hardest is None or not told:
        return ""
    return (
        f"{where}, at t = {hardest[0]:.6g} s, where steps were rejected until they were short: the error of a step "
        f"across that is not known. Remedy: {remedy}"
    )


def _of_state(model: Model) -> Iterator[tuple[str, ValuedLoad]]:
    for label, load in named_loads(model).items():
        if not (load.is_constant or isinstance(load.function, Held)) and load.takes_state:
            yield label, load


def _called_in_python(model: Model) -> Iterator[tuple[str, ValuedLoad]]:
    for label, load in named_loads(model).items():
        if not (load.is_constant or isinstance(load.function, (CompiledCallback, Held))):
            yield label, load


def _value(load: ValuedLoad, t: float, state: SceneState) -> Vector:
    return np.atleast_1d(load.value(t, state))


def _differ(a: Vector, b: Vector) -> bool:
    return bool(np.any(np.abs(a - b) > SAME * np.maximum(np.abs(a), np.abs(b))))


def _shown(value: Vector) -> str:
    return f"{value[0]:.6g}" if len(value) == 1 else f"({', '.join(f'{x:.6g}' for x in value)})"
