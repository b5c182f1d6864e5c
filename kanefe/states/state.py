"""One state of a scene, and quantities of it that are computed on request, each once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, wraps
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.frames import Vector
from kanefe.loads.action import Action
from kanefe.states.kinematics import FrameMotion, inertial_frame, interface_motion, placed, sweep_outward
from kanefe.tree.model_data import ModelData
from kanefe.tree.scene_state import SceneState

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame

Answer = TypeVar("Answer")


class State(SceneState):
    """A state ``(model, t, q, u, z)`` of a scene: the argument of the literal route and of functions of the user.

    Functions such as those of `kanefe.kane` take a state and are computed once for it (see `once`): an energy, say,
    takes the outward sweep that the mass matrix has made. A state never changes.

    Parameters
    ----------
    model : ModelData
    t : float
        s.
    q : ndarray, shape (coordinates,)
    u : ndarray, shape (free speeds,), optional
        Default: at rest.
    z : ndarray, shape (states,), optional
        Internal states of loads and switches of constraints; default: those of the start.
    is_wide : bool
        Whether partial velocities are also over the interface components fixed in G, whose rows give coupling forces.

    Attributes
    ----------
    columns : int
        How many of the speeds the partial velocities span.

    Examples
    --------
    >>> import kanefe as kf
    >>> scene = kf.System()
    >>> cart = scene.add_rigid_body("cart", 2.0, joint=kf.Prismatic("x", speed=3.0))
    >>> model = scene.freeze()
    >>> State(model, 0.0, model.initial_coordinates, model.initial_speeds).motions[0].v
    array([3., 0., 0.])
    """

    def __init__(
        self,
        model: ModelData,
        t: float,
        q: Vector,
        u: Vector | None = None,
        z: Vector | None = None,
        *,
        is_wide: bool = False,
    ) -> None:
        super().__init__(model, t, q, np.zeros(model.free_count) if u is None else u, z)
        self.t, self.is_wide = t, is_wide
        self.columns = model.free_count + model.driven_count + (model.fixed_count if is_wide else 0)
        self.kept: dict[Callable[..., Any], Any] = {}
        self._markers: dict[Marker, FrameMotion] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        return _made, (self.model, self.t, self.q, self.u, self.z, self.is_wide)

    @cached_property
    def motions(self) -> list[FrameMotion]:
        """Motion of every body's frame: the outward sweep."""
        return sweep_outward(self.model, self.t, self.q, self.full, self.columns)

    @property
    def frames(self) -> Sequence[FrameMotion]:
        """Return the frames, for functions of the user."""
        return self.motions

    @cached_property
    def wide(self) -> State:
        """Return this state with partial velocities over the fixed components too."""
        return self if self.is_wide else State(self.model, self.t, self.q, self.u, self.z, is_wide=True)

    @cached_property
    def driven_rates(self) -> Vector:
        """Accelerations of the driven speeds, (driven,)."""
        return self.model.driven_speeds(self.t)[1] if self.model.driven_count else np.zeros(0)

    def motion(self, number: int, interface: InterfaceFrame | None) -> FrameMotion:
        """Return the motion of a body's frame, or of one of its interfaces or nodes in axes of G turned with it."""
        G, terms = self.motions[number], self.model.bodies[number].flexible
        if interface is None or terms is None:
            return G
        return interface_motion(G, interface, terms, self.q, self.full, self.model.slopes)

    def marker(self, marker: Marker) -> FrameMotion:
        """Return the motion of a marker, in its own axes; found once."""
        if marker not in self._markers:
            carrier = inertial_frame(self.columns) if marker.body < 0 else self.motion(marker.body, marker.interface)
            self._markers[marker] = placed(carrier, marker.point, marker.axes)
        return self._markers[marker]

    def placed_marker(self, marker: Marker) -> FrameMotion:
        """Return the same, for loads."""
        return self.marker(marker)

    def action(self, number: int) -> Action:
        """Return what a load between frames does, by its number in the model."""
        return actions(self)[number]


def once(function: Callable[[State], Answer]) -> Callable[[State], Answer]:
    """Let a function of a state be computed once for each state."""

    @wraps(function)
    def kept(state: State) -> Answer:
        if kept not in state.kept:
            state.kept[kept] = function(state)
        answer: Answer = state.kept[kept]
        return answer

    return kept


@once
def actions(state: State) -> list[Action]:
    """Return what each load between frames does."""
    loads = enumerate(state.model.loads)
    return [load.action(state.t, state.load_ends(i), state.load_states(i)) for i, load in loads]


def _made(model: ModelData, t: float, q: Vector, u: Vector, z: Vector, is_wide: bool) -> State:
    return State(model, t, q, u, z, is_wide=is_wide)
