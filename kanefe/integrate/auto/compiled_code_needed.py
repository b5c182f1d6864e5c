"""Functions that a run needs compiled: predicted, so that one build with one progress count suffices."""

from __future__ import annotations

from kanefe.equations.model import Model
from kanefe.equations.routes import functions_of_route
from kanefe.integrate.auto.choice import method_names
from kanefe.integrate.locked_speeds import has_locked_speeds
from kanefe.integrate.methods.compiled import Compiled
from kanefe.integrate.methods.table import ROWS
from kanefe.integrate.options import RunOptions
from kanefe.kernels.compiler.compiled_functions import CompiledFunction
from kanefe.kernels.steppers.step_commands import JACOBIAN_ROW


def functions_of_run(model: Model, options: RunOptions) -> list[CompiledFunction]:
    """Return the units of a run and of the reading of its results.

    Which method "auto" takes is found by evaluations, for which they are built: all that it may take are in.
    """
    names = method_names(model, options)
    found: list[CompiledFunction] = []
    has_jacobian = has_directions = has_masses = False
    for row in ROWS:
        if row.name in names and isinstance(row.stepper, Compiled):
            kernels = row.stepper.kernels_for(model)
            found += [kernels.advance.unit, kernels.interpolate.unit]
            has_directions |= kernels.takes_directions
            is_damping = JACOBIAN_ROW in kernels.integers
            has_jacobian |= is_damping and not kernels.takes_directions
            has_masses |= (kernels.is_implicit or is_damping) and has_locked_speeds(model, is_damping)
    return found + functions_of_route(model, has_jacobian, has_directions, has_masses)
