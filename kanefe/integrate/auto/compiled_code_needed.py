"""What is built for a run, where it is not there: known before, so that it is built in one go and told in one count."""

from __future__ import annotations

from kanefe.equations.model import Model
from kanefe.equations.routes import units_of_route
from kanefe.integrate.auto.choice import DEFAULT_RTOL
from kanefe.integrate.auto.suited_method import may_suit
from kanefe.integrate.methods.compiled import Compiled
from kanefe.integrate.methods.table import ROWS
from kanefe.integrate.options import AUTO, RunOptions
from kanefe.kernels.compiler.compiled_functions import Unit
from kanefe.kernels.steppers.step_commands import JACOBIAN_ROW


def units_of_run(model: Model, options: RunOptions) -> list[Unit]:
    """Return the units of a run and of the reading of its results.

    Which method "auto" takes is found by evaluations, for which they are built: all that it may take are in.
    """
    rtol = DEFAULT_RTOL if options.rtol is None else options.rtol
    names: tuple[str, ...] = (options.method,)
    if options.method == AUTO:
        names = may_suit(model, *options.span, rtol if options.step is None else None)
    found: list[Unit] = []
    has_jacobian = False
    for row in ROWS:
        if row.name in names and isinstance(row.stepper, Compiled):
            kernels = row.stepper.load()
            found += [kernels.advance.unit, kernels.interpolate.unit]
            has_jacobian |= JACOBIAN_ROW in kernels.integers
    return found + units_of_route(model, has_jacobian)
