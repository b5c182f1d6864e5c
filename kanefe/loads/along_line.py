"""Loads along a line over points: its path, and a tension that depends on length and rate."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from kanefe.errors import SimulationError
from kanefe.frames import Matrix, Vector
from kanefe.kernels.force_elements.places import WRENCH, WRENCHES, Done
from kanefe.kernels.force_elements.rope import put_gradient
from kanefe.loads.action import Action, End, Tangent
from kanefe.loads.base import Load
from kanefe.loads.by_kernel import numbers_of, slopes


class Path(NamedTuple):
    """A path over points: length (m), rate (m/s), and the derivative of the length with respect to each end's position.

    The derivatives, (ends, 3), are in components of N.
    """

    length: float
    rate: float
    gradient: Matrix


class AlongLine(Load):
    """A load with one tension along a line over its ends, which depends on length, rate and states."""

    @abstractmethod
    def pull(self, t: float, length: Any, rate: Any, states: Vector) -> Any:
        """Return the tension at a length (m) and rate (m/s), of real or complex numbers, N."""

    def path(self, t: float, ends: Sequence[End]) -> Path:
        """Return the path over the ends.

        Raises
        ------
        SimulationError
            If two consecutive points coincide, or one is not finite.
        """
        count = len(ends)
        out: list[Any] = [0.0] * (WRENCHES + WRENCH * count)
        with np.errstate(all="ignore"):
            length, rate = put_gradient(count, numbers_of(ends), Done(out))
        if not math.isfinite(rate):
            gaps = [ends[i + 1].p - ends[i].p for i in range(count - 1)]
            i = next((i for i, gap in enumerate(gaps) if not np.any(gap)), None)
            if i is None:
                raise SimulationError(f"the points of {self.kind} {self.name!r} are nowhere at t = {t:.6g} s")
            raise SimulationError(
                f"points {i} and {i + 1} of {self.kind} {self.name!r} coincide at t = {t:.6g} s, and it has "
                "no direction there. Remedy: keep them apart, or leave one of several out"
            )
        return Path(float(length), float(rate), np.array(out[WRENCHES:]).reshape(count, WRENCH)[:, :3])

    def action(self, t: float, ends: Sequence[End], states: Vector) -> Action:
        """Return its pull on all points (Eq. 11)."""
        done = super().action(t, ends, states)
        if not math.isfinite(done.wrenches.sum()):
            self.check_at(t)
            self.path(t, ends)  # raises an error if points coincide
        return done

    def tangent(self, t: float, ends: Sequence[End], states: Vector) -> Tangent:
        """Return the slopes of its tension along the line, without the geometric stiffness of rotation under load."""
        path = self.path(t, ends)
        rows = np.zeros((len(ends), 6))
        rows[:, :3] = path.gradient
        k, c = slopes(lambda length, rate: self.pull(t, length, rate, states), path.length, path.rate)
        return Tangent(rows.reshape(1, -1), np.array((k,)), np.array((c,)))
