"""Makes the steppers of compiled methods, importing what is compiled only when it is used."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from kanefe.equations.model import Model
    from kanefe.integrate.dynamics import Dynamics
    from kanefe.integrate.methods.kernel_set import Kernels
    from kanefe.integrate.methods.kernel_stepper import KernelStepper
    from kanefe.integrate.stepper import StepControl


@dataclass(frozen=True)
class Compiled:
    """Makes the steppers of a method that is compiled.

    Attributes
    ----------
    load : function
        Returns its kernels, which it imports: those of methods that are not used cost nothing.
    """

    load: Callable[[], Kernels]

    def kernels_for(self, model: Model) -> Kernels:
        """Return the kernels that run a scene."""
        return self.load()

    def __call__(
        self, dynamics: Dynamics, start: float, stop: float, control: StepControl, *, name: str
    ) -> KernelStepper:
        """Return a stepper at the start; times in s."""
        from kanefe.integrate.methods.kernel_stepper import KernelStepper

        kernels = self.kernels_for(dynamics.model)
        return KernelStepper(dynamics, start, stop, control, name=name, kernels=kernels)
