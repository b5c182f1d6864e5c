"""Reactions, driving forces and loop forces at a state, for functions of the user."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

from kanefe.equations.state_forces import forces_of
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.tree.scene_state import SceneState

if TYPE_CHECKING:
    from kanefe.equations.model import Model
    from kanefe.tree.run_sweeps import RunForces


class ForcesAt:
    """Reactions, driving forces and loop forces at a state, computed at the first request.

    Parameters
    ----------
    model : Model
    t : float
        s.
    y : ndarray
        (q, u, z).
    """

    def __init__(self, model: Model, t: float, y: Vector) -> None:
        self._model, self._t, self._y = model, t, y

    @cached_property
    def _forces(self) -> RunForces:
        return forces_of(self._model.route, self._t, self._y)

    def joint_reaction(self, name: str) -> Vector:
        """Return force and moment of a body's joint on it, (6,)."""
        return self._forces.reactions[0, self._model.index(name)].copy()

    def driving_force(self, name: str) -> Vector:
        """Return the forces on the driven coordinates of a body's joint, (driven,)."""
        body = self._model.bodies[self._model.index(name)]
        if not body.is_driven:
            raise ModelError(f"nothing drives the joint of {name!r}: it has no driving force")
        return self._forces.driving[0, body.speeds[list(body.driven)] - self._model.free_count]

    def loop_force(self, name: str) -> Vector:
        """Return force and moment of a loop joint on its end b, (6,)."""
        names = [constraint.name for constraint in self._model.constraints if constraint.b is not None]
        if name not in names:
            raise ModelError(f"the scene has no loop joint {name!r}. It has: {', '.join(names) or 'none'}")
        return self._forces.loops[0, names.index(name)].copy()

    def gear_force(self, name: str) -> Vector:
        """Return the forces of a gear on the coordinates that it couples, (n,)."""
        names = [constraint.name for constraint in self._model.constraints for _ in constraint.terms]
        if name not in names:
            there = ", ".join(dict.fromkeys(names)) or "none"
            raise ModelError(f"the scene has no gear or rack {name!r}. It has: {there}")
        return self._forces.gears[0, [other == name for other in names]].copy()

    def rigid_contact(self, number: int) -> Vector:
        """Return the outputs of a rigid contact, by its number among the rigid contacts."""
        return self._forces.contact(number)[0]


def seen(model: Model, t: float, y: Vector) -> SceneState:
    """Return the state (q, u, z, ...) passed to functions of events, with access to forces.

    Loads get a state without them, since the forces depend on the loads.
    """
    size = model.coordinate_count + model.free_count + model.state_count
    return model.route.state(t, y).with_forces(ForcesAt(model, t, y[:size]))
