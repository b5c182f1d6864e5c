"""Reactions, driving forces and loop forces at a state, for functions of the user."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.tree.scene_state import SceneState

if TYPE_CHECKING:
    from kanefe.equations.model import Model


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
    def _acting(self) -> tuple[Any, Vector]:
        model, t, y = self._model, self._t, self._y
        return model.route.acting(t, y, model.parts(model.rhs(t, y))[1])

    @cached_property
    def _reactions(self) -> list[Vector]:
        from kanefe.kane.reactions import joint_reactions

        return joint_reactions(*self._acting)

    @cached_property
    def _driving(self) -> Vector:
        from kanefe.kane.coupling import recovered_forces

        return recovered_forces(*self._acting)[0]

    @cached_property
    def _loops(self) -> dict[str, Vector]:
        from kanefe.kane.reactions import loop_forces

        return loop_forces(self._acting[0])

    def joint_reaction(self, name: str) -> Vector:
        """Return force and moment of a body's joint on it, (6,)."""
        return self._reactions[self._model.index(name)].copy()

    def driving_force(self, name: str) -> Vector:
        """Return the forces on the driven coordinates of a body's joint, (driven,)."""
        body = self._model.bodies[self._model.index(name)]
        if not body.is_driven:
            raise ModelError(f"nothing drives the joint of {name!r}: it has no driving force")
        return self._driving[body.speeds[list(body.driven)] - self._model.free_count]

    def loop_force(self, name: str) -> Vector:
        """Return force and moment of a loop joint on its end b, (6,)."""
        if name not in self._loops:
            raise ModelError(f"the scene has no loop joint {name!r}. It has: {', '.join(self._loops) or 'none'}")
        return self._loops[name].copy()

    def rigid_contact(self, number: int) -> Vector:
        """Return the outputs of a rigid contact, by its number among the rigid contacts."""
        from kanefe.kane.rigid_contacts.contact_forces import told

        return told(self._model.route.view(self._t, self._y), number)


def seen(model: Model, t: float, y: Vector) -> SceneState:
    """Return the state (q, u, z, ...) passed to functions of events, with access to forces.

    Loads get a state without them, since the forces depend on the loads.
    """
    size = model.coordinate_count + model.free_count + model.state_count
    return model.route.state(t, y).with_forces(ForcesAt(model, t, y[:size]))
