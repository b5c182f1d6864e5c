"""What is built for a scene in order n: its evaluation, its loads and joints, and the reading of its results."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from kanefe.kernels.compiler.addresses import compiled_functions_of
from kanefe.kernels.compiler.compiled_functions import CompiledFunction
from kanefe.kernels.compiler.filling import fill_nothing
from kanefe.kernels.compiler.signatures import Variant
from kanefe.kernels.constraints.closing import close_state
from kanefe.kernels.constraints.contact_margins import watch_contacts
from kanefe.kernels.evaluation.derivatives import derivatives
from kanefe.kernels.evaluation.evaluation import evaluate
from kanefe.kernels.evaluation.masses import put_masses
from kanefe.kernels.evaluation.momenta import balances_of_states
from kanefe.kernels.evaluation.replay import between_states, revisit
from kanefe.kernels.evaluation.stiff_directions import put_directions
from kanefe.kernels.events.lookout import look_at
from kanefe.kernels.events.steps_with_events import pass_steps
from kanefe.kernels.force_elements import places as of_loads
from kanefe.kernels.force_elements.given import given
from kanefe.kernels.impacts.cones import solve_one
from kanefe.kernels.impacts.contact_changes import change_contacts
from kanefe.kernels.impacts.moments import look_at_points
from kanefe.kernels.links import places as of_links
from kanefe.kernels.loads.telling import tell_states
from kanefe.kernels.loads.watching import watch_states
from kanefe.kernels.planar.evaluation import evaluate_planar
from kanefe.kernels.steppers.integration import integrate
from kanefe.kernels.steppers.sampling import pass_samples, sample_at
from kanefe.kernels.steppers.step_commands import next_command
from kanefe.kernels.sweeps.outward import motions_of_rows
from kanefe.order_n.tables.drive_tables import drive_tables
from kanefe.order_n.tables.inputs import InputLayout
from kanefe.order_n.tables.planar_tables import planar_tables
from kanefe.order_n.tables.scene_tables import TableBuilder
from kanefe.tree.model_data import ModelData

COMPLEX = Variant(has_flexible=True, is_complex=True)
"""Kernel variant that all scenes need."""


def functions_of_scene(
    model: ModelData, has_jacobian: bool, has_directions: bool, has_masses: bool, for_analyses: bool
) -> list[CompiledFunction]:
    """Return the units of a run and of the reading of its results, but for those of the method.

    `has_jacobian`: whether the method takes derivatives; `has_directions`: directions in which loads are stiff;
    `has_masses`: the mass matrix; `for_analyses`: what loads do. Nothing is built or loaded for the answer.
    """
    own = Variant(has_flexible=any(body.flexible is not None for body in model.bodies))
    functions = list(_functions(model))
    is_planar = not (functions or own.has_flexible or model.constraints) and (
        planar_tables(model, TableBuilder(model).tables()[0]) is not None
    )
    found = [evaluate_planar.unit(Variant()) if is_planar else evaluate.unit(own)]
    found += [unit for units in functions for unit in units]
    found += [balances_of_states.unit(Variant(has_flexible=True)), motions_of_rows.unit(own)]
    if model.is_constrained:
        found.append(close_state.unit(Variant(has_flexible=True)))
    if has_masses:
        found.append(put_masses.unit(Variant(has_flexible=True)))
    if for_analyses and model.loads:
        found.append(tell_states.unit(Variant(has_flexible=True)))
    if has_directions:
        found.append(put_directions.unit(own))
    if has_jacobian:
        found += [evaluate.unit(COMPLEX), derivatives.unit(Variant(is_complex=True))]
    if InputLayout(model).calls_python or drive_tables(model) is None:
        found.append(next_command.unit(Variant()))
    else:
        found += [integrate.unit(Variant()), fill_nothing.unit, revisit.unit, between_states.unit]
    if any(one.is_sampled for one in model.controllers):
        found += [sample_at.unit(Variant()), pass_samples.unit(Variant())]
    if any(load.kernel is not None and load.kernel.watch is not None for load in model.loads):
        found.append(watch_states.unit(own))
    if model.rigid_contacts:
        found += [watch_contacts.unit(Variant()), change_contacts.unit(Variant()), solve_one.unit(Variant())]
        found.append(look_at_points.unit(Variant(has_flexible=True)))
    if model.rigid_contacts or any(load.kernel is not None and load.kernel.watch is not None for load in model.loads):
        found += [look_at.unit(Variant()), pass_steps.unit(Variant())]
    return found


def _functions(model: ModelData) -> Iterator[list[CompiledFunction]]:
    """Yield what is built for each function of a load or a joint."""
    for number, load in enumerate(model.loads):
        kernel = load.kernel
        if number in model.rigid_contacts:
            continue
        if kernel is None:
            yield compiled_functions_of(given, of_loads.SIGNATURE)
            continue
        yield _both(kernel.real, kernel.complex_, of_loads.SIGNATURE)
        yield _both(kernel.watch, None, of_loads.WATCH_SIGNATURE) + _both(kernel.change, None, of_loads.WATCH_SIGNATURE)
    for body in model.bodies:
        for link in body.joint.links() or ():
            if link.kernel is not None:
                yield _both(link.kernel.real, link.kernel.complex_, of_links.SIGNATURE)


def _both(
    real: Callable[..., None] | int | None, complex_: Callable[..., None] | int | None, signature: tuple[str, ...]
) -> list[CompiledFunction]:
    """Return what is built for a function of real and of complex numbers; nothing for those that have an address."""
    found = compiled_functions_of(real, signature)[:1] if callable(real) else []
    return found + (compiled_functions_of(complex_, signature)[1:] if callable(complex_) else [])
