"""The table of methods, and the choice of one for a scene."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.integrate.choice import suited
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.generalised_alpha import SPECTRAL_RADIUS, GeneralisedAlphaStepper
from kanefe.integrate.methods.generalised_alpha_formula import GeneralisedAlpha
from kanefe.integrate.methods.generalised_alpha_unreduced import UnreducedStepper
from kanefe.integrate.stepper import StepControl, Stepper

DEFAULT_RTOL = 1e-6


ATOL_SHARE = 0.1
"""Of rtol: the absolute tolerance where none is given."""


@dataclass(frozen=True)
class Method:
    """A row of the table.

    Attributes
    ----------
    name : str
    make : callable
        (dynamics, start, stop, control) -> stepper.
    has_error_control, has_fixed_steps : bool
        Whether it can choose its steps, and whether it can take given ones.
    takes_atol : bool
        Whether errors are measured component by component; else by the size of the bodies.
    least_rtol : float
        Below which round-off is all that it controls.
    is_plugged : bool
        Whether it is a solver of another package, which keeps its memory to itself: no checkpoints.
    """

    name: str
    make: Callable[[Dynamics, float, float, StepControl], Stepper]
    has_error_control: bool = True
    has_fixed_steps: bool = False
    takes_atol: bool = False
    least_rtol: float = 0.0
    is_plugged: bool = False


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
    """

    name: str
    reason: str
    make: Callable[[Dynamics], Stepper]
    control: dict[str, float]


def _kernel(name: str) -> Callable[[Dynamics, float, float, StepControl], Stepper]:
    def make(dynamics: Dynamics, start: float, stop: float, control: StepControl) -> Stepper:
        # these import numba, which takes a quarter of a second
        from kanefe.integrate.methods.compiled import kernel_method
        from kanefe.integrate.methods.kernel_stepper import KernelStepper

        return KernelStepper(dynamics, start, stop, control, method=kernel_method(name))

    return make


def _scipy(name: str) -> Method:
    def make(dynamics: Dynamics, start: float, stop: float, control: StepControl) -> Stepper:
        from kanefe.integrate.methods.external import ScipyStepper

        return ScipyStepper(dynamics, start, stop, control, name=name)

    return Method(name, make, takes_atol=True, least_rtol=1e-12, is_plugged=True)


def _sundials(dynamics: Dynamics, start: float, stop: float, control: StepControl) -> Stepper:
    from kanefe.integrate.methods._sundials import CvodeStepper

    return CvodeStepper(dynamics, start, stop, control)


HHT = GeneralisedAlpha(SPECTRAL_RADIUS, is_hht=True)


METHODS: dict[str, Method] = {
    method.name: method
    for method in (
        Method("dopri5", _kernel("dopri5"), has_fixed_steps=True, takes_atol=True),
        Method("dop853", _kernel("dop853"), has_fixed_steps=True, takes_atol=True),
        Method("rk4", _kernel("rk4"), has_error_control=False, has_fixed_steps=True),
        Method("extrapolation", _kernel("extrapolation"), has_fixed_steps=True, takes_atol=True, least_rtol=1e-9),
        Method("radau5", _kernel("radau5"), has_fixed_steps=True, takes_atol=True, least_rtol=1e-12),
        Method("energy-momentum", _kernel("energy-momentum"), has_error_control=False, has_fixed_steps=True),
        Method(GeneralisedAlphaStepper.name, GeneralisedAlphaStepper, has_fixed_steps=True),
        Method("hht", partial(GeneralisedAlphaStepper, formula=HHT), has_fixed_steps=True),
        _scipy("scipy-bdf"),
        _scipy("scipy-radau"),
        _scipy("scipy-lsoda"),
        Method("sundials-cvode", _sundials, takes_atol=True, least_rtol=1e-12, is_plugged=True),
    )
}


def own_methods() -> tuple[str, ...]:
    """Return the names of the methods that are not solvers of other packages."""
    return tuple(name for name, method in METHODS.items() if not method.is_plugged)


def choose(
    model: Model,
    method: str,
    start: float,
    stop: float,
    rtol: float | None = None,
    step: float | None = None,
    atol: float | None = None,
) -> Choice:
    """Return the method of a run with its options.

    Parameters
    ----------
    model : Model
    method : str
        One of `METHODS`, or "auto".
    start, stop : float
        s.
    rtol, atol, step : float, optional
        As the user gave them.

    Raises
    ------
    ModelError
        If there is no such method, it does not suit the scene, or an option makes no sense for it.
    """
    if method != "auto" and method not in METHODS:
        raise ModelError(f"there is no method {method!r}. Remedy: auto, {', '.join(sorted(METHODS))}")
    for name, value, top in (("rtol", rtol, 1.0), ("atol", atol, math.inf)):
        if value is not None and not (math.isfinite(value) and 0 < value < top):
            bounds = "lie between 0 and 1" if name == "rtol" else "be above zero"
            raise ModelError(f"{name} must {bounds}, not {value!r}")
    if step is not None and not (math.isfinite(step) and 0 < step <= stop - start):
        raise ModelError(f"step must be above zero s and within the span, not {step!r}")
    allowed = DEFAULT_RTOL if rtol is None else rtol
    control = StepControl(allowed, ATOL_SHARE * allowed if atol is None else atol, step)
    name, reason = _chosen(model, method, start, stop, control)
    _check_options(METHODS[name], rtol, atol, step)
    if model.has_unreduced and step is not None:
        raise ModelError("step has no meaning for unreduced bodies, whose run chooses its own. Remedy: rtol")
    make = UnreducedStepper if model.has_unreduced else METHODS[name].make
    followed = {"rtol": allowed} if step is None else {"step": step}
    return Choice(name, reason, partial(_made, make, start, stop, control), followed)


def _made(
    make: Callable[[Dynamics, float, float, StepControl], Stepper],
    start: float,
    stop: float,
    control: StepControl,
    dynamics: Dynamics,
) -> Stepper:
    return make(dynamics, start, stop, control)


def _chosen(model: Model, method: str, start: float, stop: float, control: StepControl) -> tuple[str, str]:
    if method != "auto":
        if model.has_unreduced and method != UnreducedStepper.name:
            raise ModelError(
                f"method {method!r} would need a step for the highest mode of the mesh: an unreduced body is run by "
                "'generalised-alpha'. Remedy: that method, or reduction=CraigBampton(modes=20)"
            )
        if method == "extrapolation" and not model.route.has_sweeps:
            raise ModelError(
                "method 'extrapolation' needs the order-n route, which bodies in the nodal form (matrices of nodes "
                "that rotate) do not have. Remedy: method='generalised-alpha'"
            )
        if method == "energy-momentum":
            _check_energy_momentum(model)
        return method, "asked for"
    return suited(model, start, stop, control.rtol if control.step is None else None, control.atol)


def _check_energy_momentum(model: Model) -> None:
    cannot = {
        "does not close loops": bool(model.constraints),
        "keeps the energy of joints that move freely, and does not drive them": model.driven_count > 0,
        "needs the order-n route, which bodies in the nodal form do not have": not model.route.has_sweeps,
    }
    for what, is_so in cannot.items():
        if is_so:
            raise ModelError(f"method 'energy-momentum' {what}. Remedy: method='auto'")


def _check_options(method: Method, rtol: float | None, atol: float | None, step: float | None) -> None:
    if rtol is not None and rtol < method.least_rtol:
        raise ModelError(
            f"rtol={rtol:g} is below the round-off of {method.name}. Remedy: {method.least_rtol:g} or more, or 'dop853'"
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
