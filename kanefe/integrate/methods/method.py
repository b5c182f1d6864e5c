"""A method of integration as a record: its name, what it can, which scenes it serves, and what makes its steppers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from kanefe.equations.model import Model
from kanefe.tree.route import Form

if TYPE_CHECKING:
    from collections.abc import Callable

    from kanefe.integrate.dynamics import Dynamics
    from kanefe.integrate.stepper import StepControl, Stepper


LEAST_RTOL = 3e-14
"""Smallest relative tolerance: below it methods control nothing but round-off, which may be larger still."""


def serves_all(model: Model) -> str:
    """Return nothing: no scene that is in its form is refused."""
    return ""


def kept_states(model: Model) -> str:
    """Return why a method that keeps internal states of loads as they are between events cannot run a model."""
    if not model.states_move:
        return ""
    names = ", ".join(repr(load.name) for load in model.loads if load.has_rates)
    return (
        f"does not integrate the internal states of the load {names}. Remedy: 'radau5', 'generalised-alpha' or 'auto'"
    )


def without_rigid_contacts(model: Model) -> str:
    """Return why a method whose equations hold what is closed by themselves cannot run a model with rigid contacts."""
    if not model.rigid_contacts:
        return ""
    name = model.loads[model.rigid_contacts[0]].name
    return f"does not handle the rigid contact {name!r}. Remedy: 'auto', 'dop853' or 'radau5'"


def no_reactions(model: Model) -> str:
    """Return why a method that knows no reactions of joints, or those of other inertias, cannot run a model."""
    if not model.bearings:
        return ""
    names = ", ".join(repr(model.loads[number].name) for number in model.bearings)
    return f"does not know the load of the joint that the {names} follows. Remedy: 'radau5', 'dop853' or 'auto'"


class MakesSteppers(Protocol):
    """The class of a method's steppers, or a function in its place."""

    def __call__(self, dynamics: Dynamics, start: float, stop: float, control: StepControl, *, name: str) -> Stepper:
        """Return a stepper at the start; times in s."""
        ...


@dataclass(frozen=True, kw_only=True)
class Method:
    """A row of the table of methods.

    Attributes
    ----------
    name : str
    about : str
        What it is and what it is for, in a line.
    stepper : class or function
        (dynamics, start, stop, control, name=...) -> stepper at the start.
    order : int
        Of convergence; where it varies, of the highest, or with fixed steps.
    is_explicit : bool
        Whether its steps follow every mode, however stiff.
    has_error_control, has_fixed_steps : bool
        Whether it can choose its steps, and whether it can take given ones.
    keeps_fixed_steps : bool
        Whether given steps go on over events of loads that would only end them, so that a step costs what it costs.
    takes_atol : bool
        Whether errors are measured component by component; else by the size of the bodies.
    least_rtol : float
        Below which round-off is all that it controls.
    is_plugged : bool
        Whether it is a solver of another package, which keeps its memory to itself: no checkpoints.
    steps_over_impacts : bool
        Whether rigid contacts meet and part within its steps.
    form : Form
        Of the equations, upon which it builds.
    serves : function
        (model) -> str: empty, or why it cannot run a model in that form, with a remedy, as a sentence goes on after its
        name.
    """

    name: str
    about: str
    stepper: MakesSteppers
    order: int
    is_explicit: bool = False
    has_error_control: bool = True
    has_fixed_steps: bool = False
    keeps_fixed_steps: bool = False
    takes_atol: bool = False
    least_rtol: float = LEAST_RTOL
    is_plugged: bool = False
    steps_over_impacts: bool = False
    form: Form = Form.DENSE
    serves: Callable[[Model], str] = serves_all

    def refuses(self, model: Model) -> str:
        """Return why it cannot run a model, as `serves` does; empty if it can."""
        if model.granular is not None and not self.steps_over_impacts:
            return f"ends its steps at impacts, of which {model.granular.name!r} are too many. Remedy: 'moreau-jean'"
        return model.route.lacks(self.form) or self.serves(model)

    def make(self, dynamics: Dynamics, start: float, stop: float, control: StepControl) -> Stepper:
        """Return a stepper at the start; times in s."""
        return self.stepper(dynamics, start, stop, control, name=self.name)
