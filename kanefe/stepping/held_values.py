"""The values of a simulation's inputs, held over each step: loads in the state, accelerations of driven coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from kanefe.errors import ModelError, did_you_mean
from kanefe.frames import Vector
from kanefe.integrate.trajectory import is_finite_number
from kanefe.loads.controller import INPUTS
from kanefe.order_n.route import OrderN

if TYPE_CHECKING:
    from kanefe.equations.model import Model
    from kanefe.joints.held_motion import Course
    from kanefe.scene.held_inputs import HeldInput


class HeldValues:
    """The inputs of a simulation.

    Parameters
    ----------
    model : Model
    held : sequence of HeldInput
        Those of loads first.

    Attributes
    ----------
    units : dict of str to str
        By name.
    values : ndarray
        The present ones.
    courses : list of Course
        Of driven coordinates that are inputs.
    """

    def __init__(self, model: Model, held: Sequence[HeldInput]) -> None:
        self._model = model
        self.units = {one.name: one.unit for one in held}
        self.values = np.array([one.start for one in held])
        self.courses = [one.course for one in held if one.course is not None]
        first = model.coordinate_count + model.free_count
        where = model.held.get(INPUTS, slice(0, 0))
        self._in_state = slice(first + where.start, first + where.stop)

    def with_changes(self, inputs: Mapping[str, float]) -> Vector:
        """Return the values with some of them changed.

        Raises
        ------
        ModelError
            If there is no such input (the message names the nearest), or a number is not valid.
        """
        values, names = self.values.copy(), list(self.units)
        if not isinstance(inputs, Mapping):
            raise ModelError(f"inputs of a step must be a mapping of names to numbers, not {inputs!r}")
        for name, value in inputs.items():
            if name not in self.units:
                did = did_you_mean(str(name), names, 0.0)
                listed = ", ".join(map(repr, names)) or "none: start(inputs=...) names them"
                raise ModelError(f"the simulation has no input {name!r}. {did}It has: {listed}")
            if not is_finite_number(value):
                raise ModelError(f"input {name!r} must be a finite number, in {self.units[name]}, not {value!r}")
            values[names.index(name)] = float(value)
        return values

    def put(self, values: Vector, t: float, y: Vector) -> None:
        """Write values to the state y and, from t (s) on, to the courses of driven coordinates."""
        loads = self._in_state.stop - self._in_state.start
        y[self._in_state] = values[:loads]
        for course, acceleration in zip(self.courses, values[loads:].tolist(), strict=True):
            course.go_on(t, acceleration)
        self._write_courses()

    def resume(self, values: Vector, pieces: Sequence[Vector]) -> None:
        """Return to values and pieces of the courses of before."""
        self.values = values.copy()
        for course, piece in zip(self.courses, pieces, strict=True):
            course.piece[:] = piece
        self._write_courses()

    def drive_of(self, course: Course) -> int:
        """Return the number of a course among all driven coordinates."""
        return next(i for i, (motion, _) in enumerate(self._model.drives) if motion.pieces is course.piece)

    def _write_courses(self) -> None:
        """Write the courses of driven coordinates to the tables of compiled code."""
        route = self._model.route
        if self.courses and isinstance(route, OrderN) and route.motion_tables is not None:
            for course in self.courses:
                first = int(route.motion_tables.motions[self.drive_of(course), 0])
                route.motion_tables.pieces[first, : course.piece.shape[1]] = course.piece[0]
