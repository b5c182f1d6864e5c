"""Forces that hold a scene at a state: what its accelerations take, for functions of the user that ask for them."""

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
        """Return what the joint of a body exerts on it, (6,)."""
        return self._reactions[self._model.index(name)].copy()

    def driving_force(self, name: str) -> Vector:
        """Return what the driven coordinates of a body's joint need, (driven,)."""
        body = self._model.bodies[self._model.index(name)]
        if not body.is_driven:
            raise ModelError(f"nothing drives the joint of {name!r}: it has no driving force")
        return self._driving[body.speeds[list(body.driven)] - self._model.free_count]

    def loop_force(self, name: str) -> Vector:
        """Return what a loop joint exerts on its end b, (6,)."""
        if name not in self._loops:
            raise ModelError(f"the scene has no loop joint {name!r}. It has: {', '.join(self._loops) or 'none'}")
        return self._loops[name].copy()

    def rigid_contact(self, number: int) -> Vector:
        """Return the outputs of a rigid contact, by its number among them."""
        from kanefe.kane.rigid_contacts.contact_forces import told

        return told(self._model.route.view(self._t, self._y), number)


def seen(model: Model, t: float, y: Vector) -> SceneState:
    """Return what functions of the user see of a state (q, u, z, ...), forces included: events, which act on nothing.

    Loads are given a state without: the forces depend on what they give.
    """
    size = model.coordinate_count + model.free_count + model.state_count
    return model.route.state(t, y).with_forces(ForcesAt(model, t, y[:size]))
