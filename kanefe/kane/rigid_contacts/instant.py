"""What the events of rigid contacts ask of the equations at one moment, and what the literal route answers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kane.assemble import accelerations
from kanefe.kane.constraints import meetings
from kanefe.kane.rigid_contacts.contact_forces import ContactMargins, margins, probe_jacobian
from kanefe.kane.rigid_contacts.impulses import unit_responses
from kanefe.kane.state import State
from kanefe.kernels.impacts.tolerances import (
    ACCEPTED,
    DEEPER,
    ROUND_OFF_OF_ACCELERATIONS,
    ROUND_OFF_OF_FORCES,
    ROUND_OFF_OF_GAPS,
    STOPPED,
)
from kanefe.tree.model_data import ModelData

if TYPE_CHECKING:
    from kanefe.contact.rigid.meeting import Meeting


Key = tuple[int, int]
"""Number of a contact among the rigid contacts, and number of its contact point."""


class ContactInstant(Protocol):
    """The scene at a state (q, u, z); but for `margins`, as if all rigid contacts were open.

    Attributes
    ----------
    t : float
        s.
    """

    t: float

    def meeting(self, key: Key) -> Meeting:
        """Return where a contact point meets its surface."""
        ...

    def surface(self, number: int) -> Matrix:
        """Return the axes of the surface of a contact, from them to N, (3, 3)."""
        ...

    def problem(self, keys: Sequence[Key]) -> tuple[Matrix, Vector]:
        """Return what unit forces at contact points do to their rates (3 k, 3 k), and the accelerations without."""
        ...

    def respond(self, keys: Sequence[Key], forces: Vector) -> Vector:
        """Return the accelerations that forces at contact points (3 k,) add, (free,); loops hold."""
        ...

    def accelerations(self) -> Vector:
        """Return du, (free,)."""
        ...

    def speed(self, key: Key) -> float:
        """Return the sum of the speeds with which a contact point moves by each of the speeds of the scene, m/s."""
        ...

    def acceleration(self, key: Key) -> float:
        """Return the sum of the accelerations that a contact point has by each of the speeds of the scene, m/s2."""
        ...

    def margins(self) -> ContactMargins:
        """Return how far what touches is from its next event."""
        ...


InstantAt = Callable[[float, Vector], ContactInstant]
"""Function of time and state (q, u, z)."""


def blurs(instant: ContactInstant, length: float) -> ContactMargins:
    """Return how far each margin of an instant may be below zero by round-off, by the numbers of `ContactMargins`.

    Parameters
    ----------
    instant : ContactInstant
    length : float
        Of what moves in the scene, m.
    """
    found = instant.margins()
    largest, no_gap = max(map(abs, found.normals.values()), default=0.0), ROUND_OFF_OF_GAPS * length
    return ContactMargins(
        {key: max(no_gap, blur_of_place(instant.meeting(key))) for key in found.gaps},
        {key: _blur_of_force(margin, largest) for key, margin in found.normals.items()},
        {key: _blur_of_force(margin, largest) for key, margin in found.slip_margins.items()},
        {key: _blur_of_slip(STOPPED * instant.speed(key), instant.meeting(key)) for key in found.slips},
    )


def noise_of_forces(instant: ContactInstant, keys: Sequence[Key]) -> float:
    """Return below what normal forces at some contact points are round-off of accelerations, N."""
    if not keys:
        return 0.0
    moved = instant.problem(keys)[0].diagonal()[::3]
    noise = [ROUND_OFF_OF_ACCELERATIONS * instant.acceleration(key) for key in keys]
    return max((one / by for one, by in zip(noise, moved, strict=True) if by > 0.0), default=0.0)


def blur_of_place(met: Meeting) -> float:
    """Return the round-off of a gap by the distance of its point from the origin, m."""
    return ROUND_OFF_OF_GAPS * float(np.linalg.norm(met.point))


def _blur_of_force(margin: float, largest: float) -> float:
    """Return how far below zero a margin is round-off, or what has been decided with it does not see, N."""
    is_accepted = -ACCEPTED * largest <= margin < 0.0
    return max(ROUND_OFF_OF_FORCES * largest, DEEPER * -margin if is_accepted else 0.0)


def _blur_of_slip(rest: float, met: Meeting) -> float:
    """Return how far below zero is round-off for a point at rest; for a slipping point the sign is known, m/s."""
    # of a speed v against the slip, 3/2 v is left: see `RigidContact.left_of_slip`
    return 1.5 * rest if float(np.hypot(*met.rates[1:])) <= rest else 0.0


class LiteralInstant:
    """The same by the equations in dense matrices.

    Parameters
    ----------
    model : ModelData
    t : float
        s.
    y : ndarray
        State (q, u, z).
    """

    def __init__(self, model: ModelData, t: float, y: Vector) -> None:
        self.t, self._state = t, State(model, t, *model.parts(y))
        z = self._state.z.copy()
        for number, load in enumerate(model.rigid_contacts):
            model.rigid_contact(number).open_all(z[model.load_states[load]])
        self._free = State(model, t, self._state.q, self._state.u, z)

    def meeting(self, key: Key) -> Meeting:
        """Return where a contact point meets its surface."""
        return meetings(self._free)[key[0]][key[1]]

    def surface(self, number: int) -> Matrix:
        """Return the axes of the surface of a contact."""
        return self._free.marker(self._free.model.rigid_contact(number).ends[0]).A_NF

    def _rows(self, keys: Sequence[Key]) -> Matrix:
        return np.vstack([probe_jacobian(self._free, *key) for key in keys])

    def problem(self, keys: Sequence[Key]) -> tuple[Matrix, Vector]:
        """Return what unit forces at contact points do to their rates, and the accelerations without."""
        rows, n = self._rows(keys), self._free.model.free_count
        left = np.concatenate([self.meeting(key).remainder for key in keys]) + rows[:, n:] @ self._free.driven_rates
        J = rows[:, :n]
        return J @ unit_responses(self._free, J.T), J @ self.accelerations() + left

    def respond(self, keys: Sequence[Key], forces: Vector) -> Vector:
        """Return the accelerations that forces at contact points add."""
        J = self._rows(keys)[:, : self._free.model.free_count]
        return unit_responses(self._free, (J.T @ forces)[:, None])[:, 0]

    def accelerations(self) -> Vector:
        """Return du."""
        return accelerations(self._free)

    def speed(self, key: Key) -> float:
        """Return the sum of the speeds with which a contact point moves."""
        moved = np.abs(probe_jacobian(self._free, *key)).max(axis=0)
        return float(moved @ np.abs(self._free.full[: len(moved)]))

    def acceleration(self, key: Key) -> float:
        """Return the sum of the accelerations of a contact point."""
        moved = np.abs(probe_jacobian(self._free, *key)).max(axis=0)
        rates = np.concatenate((self.accelerations(), self._free.driven_rates))
        return float(moved @ np.abs(rates))

    def margins(self) -> ContactMargins:
        """Return how far what touches is from its next event."""
        return margins(self._state)
