"""Relaxation of viscoelastic bodies, as loads along their modal coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np

from kanefe.bodies.marker import ModalMarker
from kanefe.bodies.relaxation import Relaxation
from kanefe.frames import Vector
from kanefe.kernels.force_elements.relaxation import RelaxationNumbers, relaxation, relaxation_told
from kanefe.kernels.values.filled import filled
from kanefe.loads.action import End, LoadKernel
from kanefe.loads.base import Load


@dataclass(frozen=True, eq=False)
class BodyRelaxation(Load):
    """The arms of a viscoelastic body: see `Relaxation`.

    Attributes
    ----------
    name : str
    ends : tuple of ModalMarker
        All coordinates of the body.
    of : Relaxation
    scales : ndarray, shape (m,)
        A large value of each state, sqrt(J).
    first : ndarray, shape (m,)
        States at the start.
    is_relaxed : bool
        Whether the arms follow at once and pull with nothing, as in slow motions and at rest.
    """

    name: str
    ends: tuple[ModalMarker, ...]
    of: Relaxation = field(kw_only=True)
    scales: Vector = field(kw_only=True)
    first: Vector = field(kw_only=True)
    is_relaxed: bool = field(default=False, kw_only=True)

    kind = "relaxation"
    columns = ("stored [J]", "dissipated [W]")

    @property
    def initial_states(self) -> Vector:
        """The states z at the start."""
        return self.first

    @property
    def has_rates(self) -> bool:
        """Whether the arms relax in time."""
        return not self.is_relaxed

    def state_scales(self, acceleration: float) -> Vector:
        """Return the states of a body that is deformed by its size."""
        return self.scales

    def followed(self, ends: Sequence[End]) -> Vector:
        """Return the states for which all arms have relaxed, L^T eta."""
        return np.asarray(self.of.factors.T @ [end.p[0] for end in ends])

    def started(self, t: float, ends: Sequence[End]) -> Self:
        """Return the load with relaxed arms."""
        return replace(self, first=self.followed(ends))

    def resting(self, ends: Sequence[End], softness: float = 0.0) -> Self:
        """Return the load with arms that follow at once."""
        return replace(self, is_relaxed=True)

    def rested(self, ends: Sequence[End], states: Vector) -> Vector:
        """Return the states of relaxed arms."""
        return self.followed(ends)

    @cached_property
    def kernel(self) -> LoadKernel:
        """Its compiled functions and numbers."""
        k, m = self.of.factors.shape
        each = []
        for column, time in zip(self.of.factors.T, self.of.times, strict=True):
            pulled = np.flatnonzero(column)
            first, last = (int(pulled[0]), int(pulled[-1]) + 1) if len(pulled) else (0, 0)
            each += [first, last, 1.0 / time, *column[first:last]]
        numbers = filled(RelaxationNumbers, coordinates=k, arms=m, is_relaxed=self.is_relaxed, each=each)
        return LoadKernel(relaxation, numbers, relaxation, tell=relaxation_told)

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return the energy that the arms store, J, and the power that they dissipate, W."""
        if self.is_relaxed:
            return np.zeros(2)
        stretch = self.followed(ends) - states
        return np.array((0.5 * stretch @ stretch, stretch @ (stretch / self.of.times)))
