"""What a run of the literal route tells of its states, one by one: as the compiled sweeps do at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from kanefe.equations.model import Model
from kanefe.frames import Matrix, euler_parameters_from_matrices
from kanefe.literal.run_forces import LiteralForces
from kanefe.states.kinematics import FrameMotion
from kanefe.states.state import State
from kanefe.tree.run_sweeps import FrameMotions, OutputFunction

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame

Place = tuple[int, str]
"""Number of a body, and the name of one of its interfaces, "" for its own frame."""


class LiteralSweeps:
    """Quantities of T states by the literal route: see `kanefe.tree.run_sweeps.RunSweeps`.

    Parameters
    ----------
    model : Model
    times : ndarray, shape (T,)
        s.
    states : ndarray, shape (T, state)
    accelerations : callable
        Returns du of the free speeds at all times, (T, free).
    """

    def __init__(
        self, model: Model, times: np.ndarray, states: np.ndarray, accelerations: Callable[[], Matrix]
    ) -> None:
        self._model, self._accelerations = model, accelerations
        self._states = list(zip(times.tolist(), states, strict=True))

    def views(self) -> Iterator[State]:
        """Yield a state at each time, with the motion of all frames."""
        return (self._model.route.view(t, y) for t, y in self._states)

    def acting(self) -> Iterator[tuple[State, np.ndarray]]:
        """Yield a state at each time, also with its loads, and its accelerations."""
        route = self._model.route
        return (route.acting(t, y, du) for (t, y), du in zip(self._states, self._accelerations(), strict=True))

    @property
    def rates(self) -> Matrix:
        """The rates dy/dt of all states."""
        return np.array([self._model.route.evaluate(t, y).rates for t, y in self._states])

    @cached_property
    def balances(self) -> Matrix:
        """Kinetic, elastic and gravity energy (J), linear and angular momentum about N's origin, (T, 9)."""
        route = self._model.route
        return np.array([np.concatenate((route.energy(t, y), *route.momenta(t, y))) for t, y in self._states])

    @cached_property
    def forces(self) -> LiteralForces:
        """All forces, from one pass."""
        return LiteralForces(self._model, self.acting)

    def outputs_of_loads(self, functions: Mapping[int, tuple[OutputFunction, int]]) -> dict[int, Matrix]:
        """Return nothing: loads tell of each state by themselves."""
        return {}

    def frame(self, number: int, interface: InterfaceFrame | None, is_accelerated: bool = False) -> FrameMotions:
        """Return the motion of a frame; those of all bodies and interfaces are found in one pass."""
        kept = self._accelerated if is_accelerated else self._moving
        return kept[number, "" if interface is None else interface.name]

    def rotation(self, number: int, interface: InterfaceFrame | None) -> Matrix:
        """Return the Euler parameters of a frame, without jumps between times."""
        e = euler_parameters_from_matrices(self.frame(number, interface).axes)
        turns = np.where(np.einsum("ti,ti->t", e[1:], e[:-1]) < 0.0, -1.0, 1.0)  # e and -e are the same rotation
        e[1:] *= np.cumprod(turns)[:, None]
        return e

    @cached_property
    def _moving(self) -> dict[Place, FrameMotions]:
        """Motion of all bodies and interfaces."""
        T = len(self._states)
        found: dict[Place, FrameMotions] = {}
        for i, state in enumerate(self.views()):
            for place, motion in _motions(state):
                if i == 0:
                    p, v, w = np.empty((3, T, 3))
                    found[place] = FrameMotions(p, np.empty((T, 3, 3)), v, w, None, None)
                to, A = found[place], motion.A_NF
                to.position[i], to.axes[i] = motion.p_NoFo_N, A
                to.velocity[i], to.angular_velocity[i] = A @ motion.v, A @ motion.w
        return found

    @cached_property
    def _accelerated(self) -> dict[Place, FrameMotions]:
        """The motion with accelerations: a = V du + Z, alpha = W du + Y (Eq. 15, 16)."""
        found = {place: np.empty((2, len(self._states), 3)) for place in self._moving}
        for i, (state, du) in enumerate(self.acting()):
            rates = np.concatenate((du, state.driven_rates))
            for place, motion in _motions(state):
                found[place][0, i] = motion.A_NF @ (motion.V @ rates + motion.Z)
                found[place][1, i] = motion.A_NF @ (motion.W @ rates + motion.Y)
        return {
            place: motion._replace(acceleration=found[place][0], angular_acceleration=found[place][1])
            for place, motion in self._moving.items()
        }


def _motions(state: State) -> Iterator[tuple[Place, FrameMotion]]:
    """Yield the motion of every frame: of each body, and of its interfaces in their own axes."""
    for number, body in enumerate(state.model.bodies):
        yield (number, ""), state.motions[number]
        for frame in () if body.flexible is None else body.flexible.body.interfaces:
            yield (number, frame.name), state.motion(number, frame).turned(frame.axes)
