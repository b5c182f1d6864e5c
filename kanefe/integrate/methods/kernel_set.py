"""A compiled method: its functions, memory, coefficients and hooks (see `kanefe.kernels.steppers.step_commands`)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kernels.compiler.entries import Pointer

if TYPE_CHECKING:
    from kanefe.integrate.dynamics import Dynamics
    from kanefe.integrate.stepper import Unconverged
    from kanefe.kernels.steppers.step_commands import Step
    from kanefe.tree.model_data import ModelData


class Memory(Protocol):
    """What the hooks of a method see of its stepper.

    Attributes
    ----------
    dynamics : Dynamics
    step : Step
        Of the method's own kind; hooks write to it.
    """

    dynamics: Dynamics
    step: Any


@dataclass(frozen=True, eq=False, kw_only=True)
class Kernels:
    """What a stepper of kernels runs.

    Attributes
    ----------
    advance, interpolate : Pointer
    record : type
        Its kind of `Step`.
    whole : function (model) -> dict of str to int
        Its own whole numbers at the start, by name; lengths of its arrays among them.
    table : ndarray
        Its coefficients, where they are a table.
    has_jacobian : bool
        Whether it solves with a Jacobian, or with directions in its place.
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
    differentiate : function (memory) -> function (t, y), optional
        Returns what writes derivatives at a state where and as the method keeps them; else they are a Jacobian.
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
    record: type[Step]
    whole: Callable[[ModelData], dict[str, int]] = lambda model: {}
    has_jacobian: bool = False
    table: Matrix = field(default_factory=lambda: np.zeros((1, 1)))
    is_implicit: bool = False
    takes_directions: bool = False
    keeps_balance: bool = False
    settles_outputs: bool = False
    scales_with_forces: bool = False
    of_tolerance: Callable[[float], float] = float
    differentiate: Callable[[Memory], Callable[[float, Vector], None]] | None = None
    prepare: Callable[[Memory], None] | None = None
    restart_share: float = 0.1
    reach: float = 1e-5
    unconverged: Callable[[Memory], Unconverged | None] | None = None
    first_step: Callable[[Memory], float] | None = None
