"""Checks of loads: of what they are given, of those of users when they are added, and at the start."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import numbers, shaped_numbers
from kanefe.kernels.compiler.foreign import check_functions
from kanefe.loads.action import Action, End, LoadKernel, Tangent
from kanefe.loads.base import Load, LoadEvent

ROUND_OFF = 1e-9
"""Power that a load exchanges, relative to that of its forces, below which it counts as zero."""


def check_load(load: object) -> None:
    """Raise a ModelError that names a missing or invalid part of a load."""
    if not isinstance(load, Load):
        what = f"the class {load.__name__}" if isinstance(load, type) else repr(load)
        raise ModelError(
            f"{what} is not a load between frames. Remedy: an object of a subclass of kanefe.Load that "
            "has `name`, `ends` and `action(t, ends, states)`; bodies have add_rigid_body and the like"
        )
    kind = type(load).__name__
    name = getattr(load, "name", None)
    if not isinstance(name, str) or not name:
        raise ModelError(f"a load of {kind} needs a name, a text that is unique in the scene, not {name!r}")
    label = f"{load.kind} {name!r}"
    ends = getattr(load, "ends", None)
    if not isinstance(ends, (tuple, list)) or not ends:
        raise ModelError(f"{label} needs ends, a tuple of the frames that it acts on, not {ends!r}")
    states = numbers(load.initial_states)
    if states.ndim != 1 or not np.all(np.isfinite(states)):
        raise ModelError(f"initial_states of {label} must be finite numbers, shape (states,), not {states!r}")
    kernel: object = load.kernel
    if kernel is not None:
        _check_kernel(kernel, label)
    elif type(load).action is Load.action:
        raise ModelError(f"{label} defines no forces. Remedy: action(t, ends, states), or a kernel")
    names = [getattr(event, "name", None) for event in load.events]
    if not all(isinstance(event, LoadEvent) for event in load.events) or len(set(names)) < len(names):
        raise ModelError(
            f"events of {label} must be kanefe.LoadEvent, each with a name of its own, not {load.events!r}"
        )
    units = [column.partition(" [")[2] for column in load.columns]
    if len([unit for unit, _ in groupby(units)]) > len(set(units)):
        raise ModelError(f"columns of {label} must have those of one unit adjacent: {load.columns!r}")
    if type(load).tell is Load.tell and load.columns:
        raise ModelError(f"{label} has columns {load.columns!r} but does not give their values. Remedy: tell()")


def check_number(value: object, what: str, *, may_be_zero: bool) -> None:
    """Raise a ModelError if a value is not one finite number above zero, or zero where it may be."""
    number = numbers(value)
    if not (number.shape == () and np.isfinite(number) and (number > 0 or (may_be_zero and number == 0))):
        raise ModelError(f"{what} must be one number, finite and {'>=' if may_be_zero else '>'} 0, not {value!r}")


def check_start(load: Load, t: float, ends: Sequence[End]) -> None:
    """Raise a ModelError if a value of a load at the start of a scene (t in s) has a wrong type or shape."""
    label, z = f"{load.kind} {load.name!r}", load.initial_states
    done: object = load.action(t, ends, z)
    if not isinstance(done, Action):
        raise ModelError(f"the action of {label} must be a kanefe.Action, not {done!r}")
    for what, value, shape in (
        ("wrenches", done.wrenches, (len(ends), 6)),
        ("potential", done.potential, ()),
        ("taken", done.taken, ()),
        ("given", done.given, ()),
        ("rates", done.rates, z.shape),
    ):
        shaped_numbers(value, shape, f"{what} of the action of {label}")
    twists = np.array([np.append(end.v, end.w) for end in ends])
    round_off = ROUND_OFF * float(np.abs(done.wrenches * twists).sum())
    if max(abs(done.taken), abs(done.given)) > round_off and not load.exchanges_energy:
        raise ModelError(
            f"{label} dissipates or supplies power, but its exchanges_energy is False. Remedy: exchanges_energy"
        )
    if load.kernel is not None:
        shaped_numbers(load.kernel.numbers, np.shape(load.kernel.numbers)[:1], f"numbers of the kernel of {label}")
    if load.input_count:
        shaped_numbers(load.inputs(t, ends, z), (load.input_count,), f"inputs of {label}")
    if load.columns:
        shaped_numbers(load.tell(t, ends, z), (len(load.columns),), f"values of tell() of {label}", is_finite=False)
    tangent: object = load.tangent(t, ends, z)
    if tangent is not None:
        if not isinstance(tangent, Tangent):
            raise ModelError(f"the tangent of {label} must be a kanefe.Tangent or None, not {tangent!r}")
        count = len(np.atleast_1d(tangent.stiffness))
        shaped_numbers(tangent.rows, (count, 6 * len(ends)), f"rows of the tangent of {label}")
        shaped_numbers(tangent.stiffness, (count,), f"stiffness of the tangent of {label}")
        shaped_numbers(tangent.damping, (count,), f"damping of the tangent of {label}")
    for event in load.events:
        shaped_numbers(event.function(t, ends, z), (), f"event {event.name!r} of {label}")


def _check_kernel(kernel: Any, label: str) -> None:
    if not isinstance(kernel, LoadKernel):
        raise ModelError(f"the kernel of {label} must be a kanefe.LoadKernel or None, not {kernel!r}")
    check_functions((kernel.real, kernel.complex_, kernel.watch, kernel.change), f"the kernel of {label}")
