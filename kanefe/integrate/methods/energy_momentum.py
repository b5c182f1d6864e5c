"""The symmetric method that keeps energy and momenta: see `kanefe.kernels.steppers.energy_momentum`."""

from __future__ import annotations

from functools import cache

import numpy as np

from kanefe.equations.model import Model
from kanefe.integrate.methods.compiled import Compiled
from kanefe.integrate.methods.kernel_set import Kernels, Memory
from kanefe.integrate.methods.method import Method, kept_states, without_rigid_contacts
from kanefe.tree.route import Form


@cache
def _kernels() -> Kernels:
    from kanefe.kernels.steppers import energy_momentum, kept_quantities

    return Kernels(
        advance=energy_momentum.advance_keeping,
        interpolate=energy_momentum.interpolate_keeping,
        record=kept_quantities.KeepingStep,
        is_implicit=True,
        keeps_balance=True,
        prepare=_prepare,
    )


def _prepare(memory: Memory) -> None:
    """Write which frequencies the iteration has to know, and whether momenta are kept."""
    from kanefe.tree.scales import modal_frequencies

    step, model = memory.step, memory.dynamics.model
    n, m = model.coordinate_count, model.free_count
    step.frequencies[n : n + m] = modal_frequencies(model)
    step.keeps_momenta = flies_freely(model)


def flies_freely(model: Model) -> bool:
    """Return whether nothing acts on the scene from without, so that it keeps its momenta."""
    from kanefe.bodies.wet_moments import WetMoments

    bodies = model.bodies
    if any(body.flexible and isinstance(body.flexible.free_moments, WetMoments) for body in bodies):
        return False  # of a body with its fluid, not the same in all directions
    roots = [body for body in bodies if body.parent < 0]
    return (
        all(body.joint.is_free and not (body.is_driven or body.joint_loads or body.joint.armature) for body in roots)
        and not any(body.loads or body.field_loads for body in bodies)
        and not (np.any(model.gravity) and any(body.has_gravity for body in bodies))
        and all(marker.body >= 0 for load in model.loads for marker in load.ends)
        and all(marker.body >= 0 for held in model.constraints for marker in held.ends)
    )


def _serves(model: Model) -> str:
    driven = [body.name for body in model.bodies if body.is_driven]
    if driven:
        return (
            f"conserves the energy of freely moving joints, and does not drive that of {driven[0]!r}. Remedy: 'radau5' "
            "or 'auto', whose energy balance the result tells"
        )
    return kept_states(model) or without_rigid_contacts(model)


METHOD = Method(
    name="energy-momentum",
    about="conserves energy, and momenta in free flight: for long runs",
    stepper=Compiled(_kernels),
    order=2,
    has_error_control=False,
    has_fixed_steps=True,
    form=Form.SWEEPS,
    serves=_serves,
)
