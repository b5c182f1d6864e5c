"""The method of a run and its options, checked: the given method, or the choice of method="auto" with its reason."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, cast

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.integrate.auto.suited_method import Candidates, candidates
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.compiled import Compiled
from kanefe.integrate.methods.method import LEAST_RTOL, Method
from kanefe.integrate.methods.table import ROWS, row_for
from kanefe.integrate.options import AUTO, RunOptions
from kanefe.integrate.stepper import ATOL_SHARE, StepControl, Stepper
from kanefe.kernels.compiler.compiled_functions import CompiledFunction
from kanefe.kernels.compiler.signatures import COMPLEX
from kanefe.kernels.evaluation.evaluation import evaluate

if TYPE_CHECKING:
    from kanefe.integrate.methods.kernel_stepper import KernelStepper

DEFAULT_RTOL = 1e-6


@dataclass(frozen=True)
class Choice:
    """The method of a run.

    Attributes
    ----------
    name, reason : str
    make : callable
        (dynamics) -> stepper at the start of the run.
    control : dict of str to float
        The options that it follows, with their defaults.
    is_plugged : bool
        See `Method`.
    is_compiled : bool
        Whether its steps are kernels.
    keeps_steps : bool
        Whether its steps are given, and events of loads that would only end one do not.
    rivals : dict of str to callable
        By name: (dynamics) -> stepper of another method, which the run tries.
    left_out : dict of str to str, or None
        Why "auto" does not try others, by their names.
    """

    name: str
    reason: str
    make: Callable[[Dynamics], Stepper]
    control: dict[str, float]
    is_plugged: bool = False
    is_compiled: bool = False
    keeps_steps: bool = False
    rivals: Mapping[str, Callable[[Dynamics], Stepper]] = field(default_factory=dict)
    left_out: dict[str, str] | None = None

    def maker_of(self, name: str) -> Callable[[Dynamics], Stepper] | None:
        """Return what makes the steppers of a method of this name, if it may be the one of the run."""
        return self.make if name == self.name else self.rivals.get(name)


def choose(model: Model, options: RunOptions) -> Choice:
    """Return the method of a run.

    Raises
    ------
    ModelError
        If the method does not serve the scene, or an option makes no sense for it.
    """
    step, (start, stop), control = options.step, options.span, _control(options)
    name, reason, allowed = options.method, "asked for", control.rtol
    if name == AUTO:
        found = _candidates(model, options).choose()
        name, reason = found.name, found.reason
        control = replace(control, changes=found.changes)
        if options.atol is None and step is None:
            control = replace(control, atol=control.atol * found.share)
        if step is None and found.step is not None:
            step = _dividing(options.times, found.step)
            control = replace(control, step=step)
    row = row_for(model, name)
    _check_options(row, options, step)
    make = partial(_stepper, row, start, stop, control)
    if options.method == AUTO and found.then:
        make = partial(
            _handing_over, make, partial(_stepper, row_for(model, found.then), start, stop, control), found.least
        )
    follows, is_compiled = {"rtol": allowed} if step is None else {"step": step}, isinstance(row.stepper, Compiled)
    keeps_steps = step is not None and row.keeps_fixed_steps
    rivals: dict[str, Callable[[Dynamics], Stepper]] = {}
    left_out = None
    if options.method == AUTO and step is None:
        rivals = {one: partial(_stepper, row_for(model, one), start, stop, control) for one in found.rivals}
        left_out = found.left_out
    return Choice(name, reason, make, follows, row.is_plugged, is_compiled, keeps_steps, rivals, left_out)


def method_names(model: Model, options: RunOptions) -> tuple[str, ...]:
    """Return the methods of which `choose` takes one, known before anything is evaluated."""
    return _candidates(model, options).names if options.method == AUTO else (options.method,)


def functions_of_methods(model: Model, options: RunOptions) -> list[CompiledFunction]:
    """Return what is built for the methods of which `choose` takes one."""
    found: list[CompiledFunction] = []
    names = method_names(model, options)
    for row in ROWS:
        if row.name in names and isinstance(row.stepper, Compiled):
            kernels = row.stepper.kernels_for(model)
            found += [kernels.advance.unit, kernels.interpolate.unit]
            if kernels.has_jacobian and not kernels.takes_directions:
                found.append(evaluate.unit(COMPLEX))
    return found


def _candidates(model: Model, options: RunOptions) -> Candidates:
    control = _control(options)
    rtol = control.rtol if options.step is None else None
    return candidates(model, *options.span, rtol, control.atol)


def _control(options: RunOptions) -> StepControl:
    rtol = DEFAULT_RTOL if options.rtol is None else options.rtol
    return StepControl(rtol, ATOL_SHARE * rtol if options.atol is None else options.atol, options.step)


def _dividing(times: np.ndarray, step: float) -> float:
    """Return a step (s) no longer than the one given, of which a whole number leads from output to output."""
    every = float(times[1] - times[0]) if len(times) > 1 else step
    return every / math.ceil(every / step) if np.allclose(np.diff(times), every, rtol=1e-9) else step


def _stepper(row: Method, start: float, stop: float, control: StepControl, dynamics: Dynamics) -> Stepper:
    return row.make(dynamics, start, stop, control)


def _handing_over(
    first: Callable[[Dynamics], Stepper], second: Callable[[Dynamics], Stepper], least: float, dynamics: Dynamics
) -> Stepper:
    from kanefe.integrate.auto.handing_over import HandingOver

    return HandingOver(dynamics, cast("KernelStepper", first(dynamics)), least, partial(second, dynamics))


def _check_options(method: Method, options: RunOptions, step: float | None) -> None:
    """Refuse what a method with a step does not follow, rather than ignore it."""
    rtol, atol = options.rtol, options.atol
    if rtol is not None and rtol < method.least_rtol:
        other = "" if method.least_rtol <= LEAST_RTOL else ", or 'dop853'"
        raise ModelError(
            f"rtol={rtol:g} is below the round-off of {method.name}. Remedy: {method.least_rtol:g} or more{other}"
        )
    if step is None and not method.has_error_control:
        raise ModelError(f"{method.name} needs a step in s")
    if step is not None and not method.has_fixed_steps:
        raise ModelError(f"step has no meaning for {method.name}, which chooses its own")
    if step is not None and rtol is not None:
        raise ModelError(f"rtol has no meaning for {method.name}, whose steps are fixed. Remedy: leave it out")
    if atol is not None and (step is not None or not method.takes_atol):
        raise ModelError(
            f"atol has no meaning for {method.name}, which "
            f"{'has no error control' if step is not None else 'scales errors by the size of the bodies'}. "
            "Remedy: leave it out"
        )
