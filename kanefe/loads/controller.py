"""Sampled controllers: a function of the user, called at fixed times, whose drives are held in between."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np


@dataclass(frozen=True, eq=False)
class Controller:
    """Arguments of `kanefe.System.add_controller`.

    Attributes
    ----------
    name : str
    function : callable
        (t, reads, memory) -> drives.
    every, delay : float
        Time between samples, and from a sample until its drives act, s.
    reads : tuple of Reading
    drives : tuple of str
        Names of the drives, with units in brackets.
    """

    name: str
    function: Callable[[float, np.ndarray, dict[str, Any]], Any]
    every: float
    delay: float
    reads: tuple[Reading, ...]
    drives: tuple[str, ...]

    @property
    def label(self) -> str:
        """What messages call it; compiled code of its function is kept under this."""
        return f"controller {self.name!r}"

    @property
    def drive_count(self) -> int:
        """Number of drives."""
        return len(self.drives)

    def new_memory(self) -> Any:
        """Return the memory of its function at the start of a run: a dict, or of a compiled one so many zeros."""
        size = getattr(self.function, "memory", None)  # see `kanefe.compiled`
        return {} if size is None else np.zeros(size)

    @property
    def is_sampled(self) -> bool:
        """Whether a run calls its function."""
        return True

    def __str__(self) -> str:
        late = f", {self.delay:g} s late" if self.delay else ""
        return f"{self.name!r} every {self.every:g} s{late}: {', '.join(self.drives)}"


INPUTS = "inputs of the simulation"
"""Name of the load that holds the inputs."""


class HeldInputs(Controller):
    """Drives without a function: inputs of a `kanefe.Simulation`, held from step to step."""

    @property
    def is_sampled(self) -> bool:
        """False: the simulation that is stepped writes them."""
        return False


class Reading(NamedTuple):
    """One number that a controller reads.

    Attributes
    ----------
    label : str
        Its name, with the unit in brackets.
    what : str
        Such as "joint_coordinates".
    body, interface : str
        "" for the body's own frame.
    component : int
        Number of the coordinate or mode, or of the axis x, y or z.
    is_own : bool
        Whether along the frame's own axes, and not those of N.
    """

    label: str
    what: str
    body: str
    interface: str
    component: int
    is_own: bool

    def of(self, state: Any) -> float:
        """Return the number at a state, of a joint, of modes, or a deflection."""
        if self.what != "deflection":
            return float(getattr(state, self.what)(self.body)[self.component])
        frame = state.model.flexible_terms(self.body).body.interface(self.interface)
        return float(frame.displacements(state.modal_coordinates(self.body)[None])[0, self.component])


@dataclass(frozen=True)
class Held:
    """The function of a load that a controller drives: the held value in the state, along a direction.

    Attributes
    ----------
    controller : str
    number : int
        Number of the drive.
    direction : tuple of three numbers, or None
        None: the value itself.
    """

    controller: str
    number: int
    direction: tuple[float, float, float] | None = None

    def __call__(self, t: float, state: Any) -> Any:
        """Return the value at a state."""
        value = state.z[state.model.held[self.controller]][self.number]
        return value if self.direction is None else value * np.array(self.direction)
