"""Values of loads for the kernels: where they are, and how they are found."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from kanefe.frames import Vector
from kanefe.kernels.compiler._numba_functions import Given, Part, guarded
from kanefe.loads.functions import CompiledCallback
from kanefe.loads.valued_load import ValuedLoad
from kanefe.tree.model_data import ModelData
from kanefe.tree.reading_terms import checked_terms


class InputLayout:
    """Where the values of loads are in the kernels' `inputs`, and how they are found.

    Loads that are the same at all times are filled in once. What depends on the time alone is asked for once an
    evaluation; what depends on the state needs the outward sweep first.

    Attributes
    ----------
    constants : ndarray
        `inputs` with what never changes.
    of_time, of_state : list of (slice, load)
    held : list of (int, int, float)
        Of loads that controllers drive: place in `inputs`, number in z, and factor.
    between : list of (slice, int)
        Numbers of the loads between frames that Python has a part in, which look at the state.
    """

    def __init__(self, model: ModelData) -> None:
        self._at: dict[int, int] = {}
        self._model = model
        self._state_size = model.coordinate_count + model.free_count + model.state_count
        self.of_time: list[tuple[slice, ValuedLoad]] = []
        self.of_state: list[tuple[slice, ValuedLoad]] = []
        self.held: list[tuple[int, int, float]] = []
        values: list[float] = []
        for load, count in loads_with_values(model):
            from kanefe.loads.controller import Held

            where = slice(len(values), len(values) + count)
            self._at[id(load)] = where.start
            values += [0.0] * count
            if isinstance(load.function, Held):
                at = model.held[load.function.controller].start + load.function.number
                direction = load.function.direction or (1.0,)
                self.held += [(where.start + i, at, factor) for i, factor in enumerate(direction)]
            elif load.is_constant:
                values[where] = np.atleast_1d(load.value(0.0, None)).tolist()
            else:
                (self.of_state if load.takes_state else self.of_time).append((where, load))
        self.between: list[tuple[slice, int]] = []
        for number, item in enumerate(model.loads):
            if item.input_count:
                where = slice(len(values), len(values) + item.input_count)
                self._at[id(item)] = where.start
                values += [0.0] * item.input_count
                self.between.append((where, number))
        self.constants = np.array(values)

    def begun(self, z: Vector) -> np.ndarray:
        """Return `inputs` while controllers hold what is in z (states,); it is not to be written to."""
        if not self.held:
            return self.constants
        values = self.constants.copy()
        for place, state, factor in self.held:
            values[place] = factor * z[state]
        return values

    def compiled(self) -> list[Part]:
        """Return the functions that numba has compiled, for the kernels; none if there are others besides."""
        parts: list[Part] = []
        for where, number in self.between:
            item = self._model.loads[number]
            if not item.input_functions:
                return []
            for at, one in enumerate(item.input_functions, where.start):
                parts.append((guarded(one, f"{item.kind} {item.name!r}", Given(0, None)), at, 0, False))
        for where, load in (*self.of_time, *self.of_state):
            if not isinstance(load.function, CompiledCallback):
                return []
            count = where.stop - where.start
            count = count if count > 1 else 0
            size = self._state_size if load.takes_state else None
            own = load.function
            terms = tuple(tuple(checked_terms(self._model, read, load.label)) for read in own.reads) or None
            axes = None if own.axes is None else tuple(own.axes.ravel().tolist())
            function = guarded(own.function, load.label, Given(count, size, terms, axes))
            parts.append((function, where.start, count, load.takes_state))
        return parts

    @property
    def needs_state(self) -> bool:
        """Whether functions of the user depend on the state."""
        return bool(self.of_state or self.between)

    @property
    def is_constant(self) -> bool:
        """Whether no function of the user is called in a run."""
        return not (self.of_time or self.of_state or self.between)

    @cached_property
    def calls_python(self) -> bool:
        """Whether functions of the user are called in Python in a run."""
        return not (self.is_constant or self.compiled())

    def of(self, item: object) -> int:
        """Return where the values of a load begin; -1: it has none."""
        return self._at.get(id(item), -1)


def loads_with_values(model: ModelData) -> list[tuple[Any, int]]:
    """Return every load with the number of its values."""
    found: list[tuple[Any, int]] = []
    for body in model.bodies:
        found += [(load, 3) for load, _ in body.loads]
        found += [(load, 1) for load in body.joint_loads]
        found += [(load, 1 if load.is_pressure else 3) for load in body.field_loads]
    return found
