"""Generalised-alpha on the rotation group, order 2: see `kanefe.kernels.steppers.generalised_alpha`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from typing import TYPE_CHECKING

from kanefe.equations.routes import directions_of_loads, swept_arms
from kanefe.integrate.methods.compiled import Compiled
from kanefe.integrate.methods.generalised_alpha_formula import GeneralisedAlpha
from kanefe.integrate.methods.method import Method, without_rigid_contacts
from kanefe.integrate.stepper import Unconverged
from kanefe.tree.model_data import QUADRATURES, ModelData
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
        if len(model.loads) > len(swept_arms(model)):
            return self.with_jacobian(directions_of_loads(model))
        return self.with_jacobian(0) if model.route.lacks(Form.SWEEPS) else self.load()


def compiled_alpha(formula: GeneralisedAlpha) -> CompiledAlpha:
    """Return what makes the steppers of a formula."""
    return CompiledAlpha(partial(_kernels, formula, False, 0), partial(_kernels, formula, True))


@cache
def _kernels(formula: GeneralisedAlpha, takes_jacobian: bool, directions: int) -> Kernels:
    from kanefe.integrate.methods.kernel_set import Kernels
    from kanefe.kernels.steppers import generalised_alpha, generalised_alpha_state

    return Kernels(
        advance=generalised_alpha.advance_generalised_alpha,
        interpolate=generalised_alpha_state.interpolate_generalised_alpha,
        record=generalised_alpha_state.AlphaStep,
        whole=partial(_whole, takes_jacobian, directions),
        has_jacobian=takes_jacobian,
        is_implicit=not takes_jacobian or directions > 0,
        takes_directions=directions > 0,
        prepare=partial(_prepare, formula),
        unconverged=_unconverged,
        restart_share=1.0,
    )


def _whole(takes_jacobian: bool, directions: int, model: ModelData) -> dict[str, int]:
    """Return what a scene has of the method, and the lengths of its matrices."""
    m, followed = model.free_count, model.state_count if model.states_move else 0
    rows = size = 0
    if directions > 0:
        rows, size = 2 * directions + followed, directions
    elif takes_jacobian:
        rows, size = m + model.state_count + QUADRATURES, m + followed
    has_stiffness = any(body.flexible or body.has_coordinate_forces for body in model.bodies)
    own = {"takes_jacobian": takes_jacobian, "most_directions": directions, "has_stiffness": has_stiffness}
    return {"followed": followed, "jacobian_rows": rows, "factor_size": size, **own}


def _prepare(formula: GeneralisedAlpha, memory: Memory) -> None:
    """Write the formula, what is allowed of displacements and of internal states, and which of these are of arms."""
    from kanefe.tree.scales import displacement_scales, state_scales

    model, step = memory.dynamics.model, memory.step
    step.alpha_m, step.alpha_f = formula.alpha_m, formula.alpha_f
    step.gamma, step.beta = formula.gamma, formula.beta
    n, m = model.coordinate_count, model.free_count
    rtol = FIXED_RTOL if step.is_fixed else step.relative
    step.allowed[:] = rtol * state_scales(model)
    step.allowed[n : n + m] = rtol * displacement_scales(model)
    for number, arms in swept_arms(model).items():
        terms = model.bodies[model.loads[number].ends[0].body].flexible
        if terms is not None:
            modes, states = arms[:, 0].astype(int), n + m + arms[:, 1].astype(int)
            step.arm_eta[states], step.arm_deta[states] = terms.eta.start + modes, n + terms.speeds.start + modes
            step.arm_pull[states], step.arm_rate[states] = arms[:, 2], arms[:, 3]


def _unconverged(memory: Memory) -> Unconverged | None:
    """Return which steps were left before their iteration had converged."""
    step = memory.step
    if step.unconverged == 0:
        return None
    first, last, largest = map(float, (step.first_unconverged, step.last_unconverged, step.largest_left))
    return Unconverged(step.unconverged, first, last, FIXED_RTOL * largest)


METHOD = Method(
    name="generalised-alpha",
    about="damps vibrations that steps do not resolve: stiff scenes, real time",
    stepper=compiled_alpha(GeneralisedAlpha(SPECTRAL_RADIUS)),
    order=2,
    has_fixed_steps=True,
    serves=without_rigid_contacts,
    keeps_fixed_steps=True,
)
