"""Instant: a scene at one time, with all outputs of a run."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path

import numpy as np

from kanefe.arguments import checked
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.integrate.trajectory import Trajectory
from kanefe.results.channels import RunChannels
from kanefe.results.load_lines import LoadLine
from kanefe.results.reader import Reader
from kanefe.results.selection import Frames
from kanefe.scene.scene import three


class Instant(Reader):
    """A state of a scene at one time: all outputs of a `Result`, without the axis of times.

    Returned by ``result.at(t)`` and `kanefe.equilibrium`. A run can start from it: ``scene.simulate((0, 1),
    start=instant)``.

    Parameters
    ----------
    model : Model
    time : float
        s.
    state : ndarray
        y = (q, u, z) of the model, named by `Model.state_names`.

    Examples
    --------
    >>> import kanefe as kf
    >>> scene = kf.System(gravity=(0, -9.81, 0))
    >>> rod = scene.add_rigid_body("rod", mass=1.0, inertia=1 / 12, com=(0.5, 0, 0), joint=kf.Revolute("z"))
    >>> fallen = scene.simulate((0.0, 1.0), rtol=1e-8).at(0.5)
    >>> fallen.position("rod").shape
    (3,)
    >>> result = scene.simulate((0.5, 1.0), start=fallen)
    """

    def __init__(self, model: Model, time: float, state: Vector) -> None:
        self.model, self.time = model, float(time)
        self.state = np.array(state, dtype=float)
        self.state.flags.writeable = False
        self.q, self.u, self.z = model.parts(self.state)
        none = np.zeros(1)
        trajectory = Trajectory(none + self.time, self.q[None], self.u[None], none, none, {}, internal=self.z[None])
        super().__init__(RunChannels(model, trajectory))

    @cached_property
    def history(self) -> Reader:
        """Outputs as those of a run with one time: arrays have a first axis of one, as views and recovery need."""
        return Reader(self._channels)

    @property
    def coordinates(self) -> dict[str, float]:
        """Coordinates q by name."""
        return dict(zip(self.model.coordinate_names(), self.q.tolist(), strict=True))

    def read(self, quantity: str, name: str = "", interface: str | None = None, of: str | None = None) -> np.ndarray:
        """Return any quantity by its name, without the axis of times: see `Reader.read`."""
        found: np.ndarray = self.history.read(quantity, name, interface, of)[0]
        return found

    @checked
    def load_force(self, name: str, end: int = -1) -> np.ndarray:
        """Return force and moment of a load on one of its ends, shape (6,): see `Reader.load_force`."""
        found: np.ndarray = self.history.load_force(name, end)[0]
        return found

    @checked
    def load_lines(self, frames: Frames | None = None) -> tuple[LoadLine, ...]:
        """Return the lines of springs, ropes and similar loads, ``points`` (ends, 3), m; leave `frames` out."""
        return tuple(line.at(0) for line in self.history.load_lines(_only(frames)))

    @checked
    def nodal_displacements(
        self, name: str, frames: Frames | None = None, nodes: Sequence[int] | np.ndarray | None = None
    ) -> np.ndarray:
        """Return the displacements of the mesh's nodes in G, shape (n, 3), m; leave `frames` out."""
        return self.history.nodal_displacements(name, _only(frames), nodes)

    @checked
    def nodal_positions(
        self, name: str, frames: Frames | None = None, nodes: Sequence[int] | np.ndarray | None = None
    ) -> np.ndarray:
        """Return the positions of the mesh's nodes in N, shape (n, 3), m; leave `frames` out."""
        return self.history.nodal_positions(name, _only(frames), nodes)

    @checked
    def to_vtk(self, path: str | Path, *, scale: float = 1.0) -> Path:
        """Write the scene for ParaView: see `Result.to_vtk`.

        Parameters
        ----------
        path : path
            Of the .pvd file; its folder is created.
        scale : float
            Factor on the elastic displacements.

        Raises
        ------
        ModelError, FileError, MissingDependency
            If the scale is not valid, the files cannot be written, or pyevtk is not installed.
        """
        from kanefe.views.vtk import write_series

        return write_series(self.history, path, frames=np.zeros(1, dtype=int), scale=scale)

    @checked
    def struck(
        self,
        body: str,
        impulse: Sequence[float] = (0.0, 0.0, 0.0),
        *,
        interface: str = "",
        point: Sequence[float] = (0.0, 0.0, 0.0),
        moment: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> Instant:
        """Return the instant just after an impulse: positions are unchanged, speeds have jumped, loops stay closed.

        Parameters
        ----------
        body : str
        impulse : array_like, shape (3,)
            Time integral of the force, in components of N, N s.
        interface : str
            Of a flexible body, for which it is required; "": the frame of a rigid body.
        point : array_like, shape (3,)
            Where the impulse acts, from the origin of that frame in its axes, m.
        moment : array_like, shape (3,)
            Impulse of a moment, in components of N, N m s.

        Raises
        ------
        ModelError
            If there is no such body or interface, a number is not finite, or bodies are unreduced.

        Examples
        --------
        A ball of 2 kg is hit:

        >>> import kanefe as kf
        >>> scene = kf.System()
        >>> ball = scene.add_point("ball", 2.0)
        >>> hit = kf.equilibrium(scene).struck("ball", (0.0, 0.0, 3.0))
        >>> hit.velocity("ball")
        array([0. , 0. , 1.5])
        """
        model = self.model
        model.route.check_dense("an impulse")
        number = model.index(body)
        terms = model.bodies[number].flexible
        if terms is not None and not interface:
            known = ", ".join(frame.name for frame in terms.body.interfaces) or "none"
            raise ModelError(
                f"an impulse on the flexible body {body!r} acts on one of its interfaces. Remedy: interface=..., of "
                f"{known}"
            )
        frame = model.flexible_terms(body).body.interface(interface) if interface else None
        from kanefe.literal.impulses import struck_speeds

        given = ("impulse", impulse), ("point", point), ("moment", moment)
        hit, where, about = (three(value, f"the {what} of an impulse on {body!r}") for what, value in given)
        state = model.literal.at(self.time, self.q, self.u, self.z)
        point_F = where if frame is None else frame.axes @ where
        u = struck_speeds(state, number, frame, point_F, hit, about)
        return Instant(model, self.time, np.concatenate((self.q, u, self.z)))


def _only(frames: Frames | None) -> int:
    if frames is not None:
        raise ModelError("frames= chooses times of a run; an instant has one. Remedy: leave it out")
    return 0
