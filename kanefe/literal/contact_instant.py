"""What events of rigid contacts ask of the equations at a state, by the equations in dense matrices."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kane.assemble import accelerations
from kanefe.literal.contact_forces import margins, probe_jacobian
from kanefe.literal.impulses import unit_responses
from kanefe.states.constraints import meetings
from kanefe.states.state import State
from kanefe.tree.contact_changes import Responses
from kanefe.tree.model_data import ModelData
from kanefe.tree.rigid_points import points_of_contacts


class LiteralInstant:
    """See `kanefe.tree.contact_changes.ContactInstant`.

    Parameters
    ----------
    model : ModelData
    t : float
        s.
    y : ndarray
        State (q, u, z).
    """

    def __init__(self, model: ModelData, t: float, y: Vector) -> None:
        self._state = State(model, t, *(part.copy() for part in model.parts(y)))
        self._keys = points_of_contacts(model)

    def _open(self) -> State:
        """Return the state with all contacts open."""
        state, z = self._state, self._state.z.copy()
        for number, load in enumerate(state.model.rigid_contacts):
            state.model.rigid_contact(number).open_all(z[state.model.load_states[load]])
        return State(state.model, state.t, state.q, state.u, z)

    def statuses(self) -> list[int]:
        """Return the status of each point."""
        model = self._state.model
        contacts = ((model.rigid_contact(number), load) for number, load in enumerate(model.rigid_contacts))
        return [status for contact, load in contacts for status in contact.status(self._state.load_states(load))]

    def margins(self) -> Matrix:
        """Return how far points are from their next events, (points, 4)."""
        found = margins(self._state)
        return np.array([[kind.get(key, np.inf) for kind in found] for key in self._keys])

    def meetings(self) -> Matrix:
        """Return where points meet their surfaces, and the axes of these in N, (points, 31)."""
        state = self._state
        found = [(meetings(state)[c][i], state.marker(state.model.rigid_contact(c).ends[0])) for c, i in self._keys]
        return np.array(
            [(m.gap, *m.place, *m.point, *m.axes.flat, *m.rates, *m.remainder, *a.A_NF.flat) for m, a in found]
        )

    def accelerations(self) -> Vector:
        """Return du with all contacts open."""
        return accelerations(self._open())

    def responses(self, points: Sequence[int]) -> Responses:
        """Return what unit forces at some points do with all contacts open, and how these move."""
        state, n, keys = self._open(), self._state.model.free_count, [self._keys[p] for p in points]
        du, driven = accelerations(state), state.driven_rates
        J = np.vstack([probe_jacobian(state, *key) for key in keys])
        X, remainder = unit_responses(state, J[:, :n].T), [meetings(state)[c][i].remainder for c, i in keys]
        moved = np.abs(J).reshape(len(keys), 3, -1).max(axis=1)
        return Responses(
            G=J[:, :n] @ X,
            b=J[:, :n] @ du + J[:, n:] @ driven + np.concatenate(remainder),
            speeds=X.T,
            sizes=moved @ np.abs(state.full[: J.shape[1]]),
            accelerated=moved @ np.abs(np.append(du, driven)),
        )
