"""Generalised-alpha on the rotation group, order 2: see `kanefe.kernels.steppers.generalised_alpha`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from typing import TYPE_CHECKING

import numpy as np

from kanefe.equations.routes import directions_of_loads
from kanefe.integrate.methods.compiled import Compiled
from kanefe.integrate.methods.generalised_alpha_formula import GeneralisedAlpha
from kanefe.integrate.methods.method import Method, without_rigid_contacts
from kanefe.integrate.stepper import Unconverged
from kanefe.tree.route import Form

if TYPE_CHECKING:
    from kanefe.equations.model import Model
    from kanefe.integrate.methods.kernel_set import Kernels, Memory

SPECTRAL_RADIUS = 0.8
"""Amplification factor of an unresolved mode per step: 1 keeps it, 0 removes it in one step."""

FIXED_RTOL = 1e-7
"""Relative tolerance with fixed steps: the iteration converges to a thousandth of it."""


@dataclass(frozen=True)
class CompiledAlpha(Compiled):
    """Makes the steppers of generalised-alpha.

    Attributes
    ----------
    with_jacobian : function (directions) -> Kernels
        Returns kernels as `load` does, for scenes in which sweeps alone do not know all that is stiff: with that many
        directions in which loads are stiff, or 0 for a matrix over all unknowns.
    """

    with_jacobian: Callable[[int], Kernels]

    def kernels_for(self, model: Model) -> Kernels:
        """Return the kernels that run a scene."""
        if model.loads:
            return self.with_jacobian(directions_of_loads(model))
        return self.with_jacobian(0) if model.route.lacks(Form.SWEEPS) else self.load()


def compiled_alpha(formula: GeneralisedAlpha) -> CompiledAlpha:
    """Return what makes the steppers of a formula."""
    return CompiledAlpha(partial(_kernels, formula, False, 0), partial(_kernels, formula, True))


@cache
def _kernels(formula: GeneralisedAlpha, takes_jacobian: bool, directions: int) -> Kernels:
    from kanefe.integrate.methods.kernel_set import Kernels
    from kanefe.kernels.steppers import generalised_alpha, generalised_alpha_state
    from kanefe.kernels.steppers.directions_wanted import MOST_DIRECTIONS
    from kanefe.kernels.steppers.step_commands import JACOBIAN_ROW

    rows, rows_per_speed, rows_per_state = generalised_alpha_state.rows_needed(takes_jacobian, directions)
    first = generalised_alpha_state.JACOBIAN_ROWS
    return Kernels(
        advance=generalised_alpha.advance_generalised_alpha,
        interpolate=generalised_alpha_state.interpolate_generalised_alpha,
        rows=rows,
        rows_per_speed=rows_per_speed,
        rows_per_state=rows_per_state,
        reals=generalised_alpha_state.REALS,
        integers={JACOBIAN_ROW: first, MOST_DIRECTIONS: directions} if takes_jacobian else {},
        table=np.array([[formula.alpha_m, formula.alpha_f, formula.gamma, formula.beta]]),
        is_implicit=not takes_jacobian or directions > 0,
        takes_directions=directions > 0,
        prepare=_prepare,
        unconverged=_unconverged,
        restart_share=1.0,
    )


def _prepare(memory: Memory) -> None:
    """Write what a scene has of the method, and what is allowed of displacements and of internal states."""
    from kanefe.kernels.steppers import generalised_alpha_state as places
    from kanefe.kernels.steppers.step_commands import IS_FIXED, JACOBIAN_ROW, RELATIVE
    from kanefe.tree.scales import displacement_scales, state_scales

    model, integers = memory.dynamics.model, memory.integers
    n, m = model.coordinate_count, model.free_count
    integers[places.TAKES_JACOBIAN] = integers[JACOBIAN_ROW] > 0
    integers[places.FOLLOWED] = model.state_count if model.states_move else 0
    integers[places.HAS_STIFFNESS] = any(body.flexible or body.has_coordinate_forces for body in model.bodies)
    rtol = FIXED_RTOL if integers[IS_FIXED] else memory.reals[RELATIVE]
    allowed = memory.vectors[places.ALLOWED]
    allowed[:] = rtol * state_scales(model)
    allowed[n : n + m] = rtol * displacement_scales(model)


def _unconverged(memory: Memory) -> Unconverged | None:
    """Return which steps were left before their iteration had converged."""
    from kanefe.kernels.steppers import generalised_alpha_state as places

    count = int(memory.integers[places.UNCONVERGED])
    if count == 0:
        return None
    first, last, largest = (
        float(memory.reals[place]) for place in (places.FIRST_UNCONVERGED, places.LAST_UNCONVERGED, places.LARGEST_LEFT)
    )
    return Unconverged(count, first, last, FIXED_RTOL * largest)


METHOD = Method(
    name="generalised-alpha",
    about="damps vibrations that steps do not resolve: stiff scenes, real time",
    stepper=compiled_alpha(GeneralisedAlpha(SPECTRAL_RADIUS)),
    order=2,
    has_fixed_steps=True,
    serves=without_rigid_contacts,
    keeps_fixed_steps=True,
)
