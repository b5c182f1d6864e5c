"""The first-order form of a model: what the integrators see."""

from __future__ import annotations

import numpy as np

from kanefe.frames import Vector
from kanefe.kane.assemble import accelerations
from kanefe.kane.energy import dissipated_power, drive_power, load_power
from kanefe.model import Model

WORKS = 2
"""Quadratures at the end of the state: dissipated energy and work of loads and drives, in J."""


class Dynamics:
    """State ``y = (q, u, dissipated energy, work of loads and drives)`` and its rate.

    Attributes
    ----------
    model : Model
    evaluations : int
        How often the equations of motion were evaluated.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.evaluations = 0

    def initial_state(self) -> Vector:
        """Return y at the start."""
        return np.concatenate((self.model.initial_coordinates, self.model.initial_speeds, np.zeros(WORKS)))

    def parts(self, y: Vector) -> tuple[Vector, Vector]:
        """Return q and u of a state."""
        n = self.model.coordinate_count
        return y[:n], y[n : n + self.model.free_count]

    def rate(self, t: float, y: Vector) -> Vector:
        """Return dy/dt."""
        self.evaluations += 1
        q, u = self.parts(y)
        du = accelerations(self.model, t, q, u)
        return np.concatenate((self.model.coordinate_rates(q, u), du, self.powers(t, q, u, du)))

    def powers(self, t: float, q: Vector, u: Vector, du: Vector) -> Vector:
        """Return the rates of the quadratures, in W; nothing is computed where nothing exchanges energy."""
        if not self.model.has_power:
            return np.zeros(WORKS)
        work = load_power(self.model, t, q, u) + drive_power(self.model, t, q, u, du)
        return np.array((dissipated_power(self.model, t, u), work))
