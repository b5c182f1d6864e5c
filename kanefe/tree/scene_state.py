"""The state of a scene as callbacks see it: where frames are and how they move, computed when asked for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, cross
from kanefe.loads.functions import Moving

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame
    from kanefe.bodies.marker import Marker
    from kanefe.tree.model_data import FlexibleTerms, ModelData


class SceneState:
    """What a function ``f(t, state)`` can ask of the scene. It is valid during the call only.

    Parameters
    ----------
    model : ModelData
    time : float
        s.
    coordinates : ndarray, shape (coordinates,)
        q.
    speeds : ndarray, shape (all speeds,)
        Free, driven and fixed.
    motions : sequence of Moving
        Motion of every body's frame.

    Examples
    --------
    >>> import kanefe as kf
    >>> scene = kf.System()
    >>> cart = scene.add_rigid_body("cart", 2.0, joint=kf.Prismatic("x", position=0.1))
    >>> scene.add_motor(cart, lambda t, state: -50.0 * state.joint_coordinates("cart")[0])
    >>> result = scene.simulate((0.0, 1.0))
    """

    def __init__(
        self, model: ModelData, time: float, coordinates: Vector, speeds: Vector, motions: Sequence[Moving]
    ) -> None:
        self._model, self._q, self._u, self._motions = model, coordinates, speeds, motions
        self.time = time

    @property
    def vector(self) -> Vector:
        """The state ``y = (q, u)`` of the equations, named by `Model.state_names`."""
        for body in self._model.bodies:
            if body.flexible is not None:
                self._modes_of(body.name)
        return np.concatenate((self._q, self._u[: self._model.free_count]))

    def position(self, name: str, interface: str = "", point: Sequence[float] = (0.0, 0.0, 0.0)) -> Vector:
        """Return the position of a point of a body or of one of its interfaces, in N, shape (3,), m.

        Parameters
        ----------
        name : str
            The body.
        interface : str
            Of a flexible body; "": the frame of the body itself.
        point : array_like, shape (3,)
            From the frame's origin in its axes, m.
        """
        p, A, _, _ = self._frame(name, interface)
        return np.asarray(p + A @ np.asarray(point, dtype=float))

    def velocity(self, name: str, interface: str = "", point: Sequence[float] = (0.0, 0.0, 0.0)) -> Vector:
        """Return the velocity of such a point, in components of N, shape (3,), m/s."""
        _, A, v, w = self._frame(name, interface)
        return np.asarray(A @ (v + cross(w, np.asarray(point, dtype=float))))

    def rotation(self, name: str, interface: str = "") -> Matrix:
        """Return A_NF, which maps components in the frame's axes to those in N, shape (3, 3)."""
        return self._frame(name, interface)[1].copy()

    def angular_velocity(self, name: str, interface: str = "") -> Vector:
        """Return the angular velocity of a frame seen from N, in its own axes, shape (3,), rad/s."""
        return self._frame(name, interface)[3].copy()

    def joint_coordinates(self, name: str) -> Vector:
        """Return the coordinates of a body's joint, driven ones included, m and rad."""
        return self._model.bodies[self._model.index(name)].joint_coordinates(self.time, self._q).copy()

    def joint_speeds(self, name: str) -> Vector:
        """Return the speeds of a body's joint, driven ones included, m/s and rad/s."""
        return np.array(self._u[self._model.bodies[self._model.index(name)].speeds])

    def modal_coordinates(self, name: str) -> Vector:
        """Return eta of a flexible body, shape (k,)."""
        return np.array(self._q[self._modes_of(name).eta])

    def modal_speeds(self, name: str) -> Vector:
        """Return deta of a flexible body, shape (k,)."""
        return np.array(self._u[self._modes_of(name).speeds])

    def _modes_of(self, name: str) -> FlexibleTerms:
        terms = self._model.flexible_terms(name)
        if not terms.body.components:  # the condensed twin, with other coordinates: see kanefe.unreduced.condensed
            raise ModelError(
                f"the coordinates of the unreduced body {name!r} are not offered to functions of the state. Remedy: "
                "state.position(body, interface) and the like, or reduction=CraigBampton(modes=20)"
            )
        return terms

    def marker(self, marker: Marker) -> tuple[Vector, Matrix, Vector, Vector]:
        """Return position (m), axes, velocity (m/s) and angular velocity (rad/s) of a marker, all in N.

        Markers may also be on the nodes of a mesh and on the ground.
        """
        if marker.body < 0:
            return marker.point, marker.axes, np.zeros(3), np.zeros(3)
        p, A, v, w = self._frame_of(marker.body, marker.interface)
        return p + A @ marker.point, A @ marker.axes, A @ (v + cross(w, marker.point)), A @ w

    def _frame(self, name: str, interface: str) -> tuple[Vector, Matrix, Vector, Vector]:
        """Return position in N, A_NF, and velocity and angular velocity in F."""
        number = self._model.index(name)
        if not interface:
            return self._frame_of(number, None)
        frame = self._model.flexible_terms(name).body.interface(interface)
        p, A, v, w = self._frame_of(number, frame)
        return p, A @ frame.axes, frame.axes.T @ v, frame.axes.T @ w

    def _frame_of(self, number: int, frame: InterfaceFrame | None) -> tuple[Vector, Matrix, Vector, Vector]:
        G = self._motions[number]
        terms, slopes = self._model.bodies[number].flexible, self._model.slopes
        if frame is None or terms is None:
            return G.p_NoFo_N, G.A_NF, G.v, G.w
        moved, motion = frame.moved(self._q[terms.eta])
        rates = motion @ self._u[terms.speeds]
        r, A = frame.position + moved[:3], slopes.rotation(moved[3:])
        v = G.v + cross(G.w, r) + rates[:3]
        w = G.w + slopes.tangent(moved[3:]) @ rates[3:]
        return G.p_NoFo_N + G.A_NF @ r, G.A_NF @ A, A.T @ v, A.T @ w
