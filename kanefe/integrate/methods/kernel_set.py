"""A compiled method: its functions, memory, coefficients and hooks (see `kanefe.kernels.steppers.step_commands`)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

import numpy as np

from kanefe.frames import Matrix
from kanefe.kernels.compiler.entries import Pointer

if TYPE_CHECKING:
    from kanefe.integrate.dynamics import Dynamics
    from kanefe.integrate.stepper import Unconverged


class Memory(Protocol):
    """What the hooks of a method see of its stepper.

    Attributes
    ----------
    dynamics : Dynamics
    integers, reals, vectors : ndarray
        As `kanefe.kernels.steppers.step_commands` names their places; hooks write to them.
    """

    dynamics: Dynamics
    integers: np.ndarray
    reals: np.ndarray
    vectors: np.ndarray

    @property
    def t(self) -> float:
        """Time reached in s."""
        ...


@dataclass(frozen=True, eq=False, kw_only=True)
class Kernels:
    """What a stepper of kernels runs.

    Attributes
    ----------
    advance, interpolate : Pointer
    rows, rows_per_speed, rows_per_state, reals : int
        Rows of vectors that it takes, further ones for every speed and every internal state, and reals.
    integers : dict of int to int
        Its own integers at the start.
    table : ndarray
        Its coefficients.
    is_implicit : bool
        Whether it wants linearly implicit evaluations.
    takes_directions : bool
        Whether it wants the directions in which loads between frames are stiff, and no Jacobian.
    keeps_balance : bool
        Whether it wants energy and momenta.
    settles_outputs : bool
        Whether stiff modes are settled in outputs: see `kanefe.kernels.steppers.settled_outputs`. Its steps may be long
        beside their periods, and its polynomial has the accelerations.
    scales_with_forces : bool
        Whether errors of modes are measured against the forces of their bodies, beside positions: see
        `kanefe.kernels.steppers.force_scales`.
    of_tolerance : function
        The estimate that a step may have, for a relative tolerance.
    prepare : function (memory), optional
        Writes what it has to know of the scene to the memory of a new stepper.
    restart_share : float
        Of the step before, with which the method goes on after an event; with 0 it finds a first step itself.
    reach : float
        How far behind the end of a step its polynomial is as good as within, in steps. By default what is lost in
        that is nothing even if the polynomial is of a lower order than the step: it meets the state at its end.
    unconverged : function (memory) -> Unconverged or None, optional
        Of a method that may leave the iteration of a fixed step early: which it has left.
    first_step : function (memory) -> float, optional
        The longest first step in s; else the method itself finds one.
    """

    advance: Pointer
    interpolate: Pointer
    rows: int
    reals: int
    rows_per_speed: int = 0
    rows_per_state: int = 0
    integers: dict[int, int]
    table: Matrix = field(default_factory=lambda: np.zeros((1, 1)))
    is_implicit: bool = False
    takes_directions: bool = False
    keeps_balance: bool = False
    settles_outputs: bool = False
    scales_with_forces: bool = False
    of_tolerance: Callable[[float], float] = float
    prepare: Callable[[Memory], None] | None = None
    restart_share: float = 0.1
    reach: float = 1e-5
    unconverged: Callable[[Memory], Unconverged | None] | None = None
    first_step: Callable[[Memory], float] | None = None
