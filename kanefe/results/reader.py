"""Reader: motions, energies and forces of a run, by name of body and interface, in SI units."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import rotation_matrices, rotation_matrix
from kanefe.results.body_shape import BodyShape
from kanefe.results.force_reader import ForceReader
from kanefe.results.load_forces import turned_into
from kanefe.results.quantities import ENERGIES, MOMENTA, Energy, Momentum
from kanefe.results.selection import Frames, frame_index, node_numbers
from kanefe.results.wholes import numbers_of_parts

LARGEST_TABLE = 2**31
"""Size of nodal values above which a call requires a choice of output times, bytes."""


class Reader(ForceReader):
    """Outputs of a run; `kanefe.Result` adds plots and files."""

    @checked
    def position(self, name: str, interface: str | None = None) -> np.ndarray:
        """Return the position of a frame in N, shape (T, 3), in m."""
        return self.read("position", name, interface)

    @checked
    def rotation(self, name: str, interface: str | None = None) -> np.ndarray:
        """Return the Euler parameters of a frame seen from N (Eq. 5), scalar first, without jumps of sign, (T, 4)."""
        return self.read("rotation", name, interface)

    @checked
    def velocity(self, name: str, interface: str | None = None) -> np.ndarray:
        """Return the velocity of a frame's origin in components of N, shape (T, 3), in m/s."""
        return self.read("velocity", name, interface)

    @checked
    def angular_velocity(self, name: str, interface: str | None = None) -> np.ndarray:
        """Return the angular velocity of a frame in its own components, shape (T, 3), in rad/s."""
        return self.read("angular_velocity", name, interface)

    @checked
    def acceleration(self, name: str, interface: str | None = None) -> np.ndarray:
        """Return the acceleration of a frame's origin in components of N (Eq. 15), shape (T, 3), in m/s2."""
        return self.read("acceleration", name, interface)

    @checked
    def angular_acceleration(self, name: str, interface: str | None = None) -> np.ndarray:
        """Return the angular acceleration of a frame in its own components (Eq. 16), shape (T, 3), in rad/s2."""
        return self.read("angular_acceleration", name, interface)

    @checked
    def center_of_mass(self, name: str = "") -> np.ndarray:
        """Return the centre of mass of a deformed body, or of the whole scene, in N, shape (T, 3), in m."""
        return self.read("center_of_mass", name)

    @checked
    def joint_coordinates(self, name: str) -> np.ndarray:
        """Return the coordinates of a body's joint, (T, coordinates); including driven ones. Units: `units`."""
        return self.read("joint_coordinates", name)

    @checked
    def joint_speeds(self, name: str) -> np.ndarray:
        """Return the speeds of a body's joint, (T, speeds); including driven ones. Units: `units`."""
        return self.read("joint_speeds", name)

    @checked
    def modal_coordinates(self, name: str) -> np.ndarray:
        """Return eta of a flexible body, shape (T, k)."""
        return self.read("modal_coordinates", name)

    @checked
    def modal_speeds(self, name: str) -> np.ndarray:
        """Return deta/dt of a flexible body, shape (T, k)."""
        return self.read("modal_speeds", name)

    @checked
    def deflection(self, name: str, interface: str) -> np.ndarray:
        """Return translation (m) and slopes (rad) of an interface from its undeformed position in G, shape (T, 6)."""
        return self.read("deflection", name, interface)

    @checked
    def in_axes_of(self, name: str, vectors: np.ndarray, interface: str | None = None) -> np.ndarray:
        """Convert vectors from components of N to those of a body or interface at the same times.

        Parameters
        ----------
        name : str
            The body.
        vectors : ndarray, shape (T, 3) or (T, 6)
            Such as ``result.contact(...).force``, or force and moment of ``result.load_force(...)``.
        interface : str, optional
            One of the body.

        Raises
        ------
        ModelError
            If there is no such body or interface, or the vectors are not one for each time.

        Examples
        --------
        ``result.in_axes_of("airframe", result.load_force("port lashing"))``
        """
        what = repr(name) if interface is None else f"{interface!r} of {name!r}"
        return turned_into(vectors, self.rotation(name, interface), what)

    @checked
    def nodal_displacements(
        self, name: str, frames: Frames | None = None, nodes: Sequence[int] | np.ndarray | None = None
    ) -> np.ndarray:
        """Return the displacements of the mesh's nodes in G, shape (T, n, 3), in m.

        Parameters
        ----------
        name : str
            A flexible body. Of a segmented one, G is that of the whole.
        frames : int, slice or sequence of int, optional
            Output times by number; with a single number the first axis is left out. Default: all.
        nodes : sequence of int, optional
            Nodes by number. Default: all.

        Raises
        ------
        ModelError
            If the body is rigid, a number is out of range, or the table would take more than 2 GiB.

        Examples
        --------
        Every tenth output time: ``result.nodal_displacements("arm", frames=slice(None, None, 10))``.
        """
        shape, chosen = self._flexible(name), frame_index(frames, len(self.times))
        if name in self._wholes:
            rows = self._nodes_of_whole(shape, nodes)
            local = self.nodal_positions(name, frames, rows) - self.position(name)[chosen][..., None, :]
            A_NG = rotation_matrices(np.atleast_2d(self.rotation(name)[chosen]))
            return np.asarray(local @ (A_NG if local.ndim == 3 else A_NG[0])) - shape.nodes[rows]
        eta = self.modal_coordinates(name)[chosen]
        rows = node_numbers(shape, nodes)
        size = 24 * len(np.atleast_2d(eta)) * len(rows)
        if size > LARGEST_TABLE:
            raise ModelError(
                f"the displacements of {len(rows)} nodes of {name!r} at {len(eta)} times take {size / 2**30:.1f} GiB. "
                "Remedy: choose output times with frames=, or nodes with nodes="
            )
        return shape.displacements(eta, rows)

    @checked
    def nodal_positions(
        self, name: str, frames: Frames | None = None, nodes: Sequence[int] | np.ndarray | None = None
    ) -> np.ndarray:
        """Return the positions of the mesh's nodes in N, shape (T, n, 3), in m. Arguments: `nodal_displacements`."""
        chosen, shape = frame_index(frames, len(self.times)), self._flexible(name)
        if name in self._wholes:
            rows = self._nodes_of_whole(shape, nodes)
            found = [self.nodal_positions(part, frames) for part in self._wholes[name]]
            order = np.argsort(numbers_of_parts(self._shapes, self._wholes[name]))
            return np.concatenate(found, axis=-2)[..., order[rows], :]
        local = self.nodal_displacements(name, frames, nodes) + shape.nodes[node_numbers(shape, nodes)]
        origin, e = self.position(name)[chosen], self.rotation(name)[chosen]
        if e.ndim == 1:
            return np.asarray(local @ rotation_matrix(e).T + origin)
        A_NG = rotation_matrices(e)
        return np.asarray(local @ A_NG.transpose(0, 2, 1) + origin[:, None])

    def _nodes_of_whole(self, shape: BodyShape, nodes: Sequence[int] | np.ndarray | None) -> np.ndarray:
        """Return numbers of nodes of a segmented body; by default of all, without the second nodes of cuts."""
        return np.arange(shape.provenance["whole_nodes"]) if nodes is None else node_numbers(shape, nodes)

    @property
    def energy(self) -> Energy:
        """Energies of the scene."""
        return Energy(*(self.read(name) for name in ENERGIES))

    @property
    def momentum(self) -> Momentum:
        """Linear and angular momentum of the scene."""
        return Momentum(*(self.read(name) for name in MOMENTA))
