"""Section forces of beams: the forces and moments of the part of a beam beyond a section on the part before it.

With the kept modes (mode displacement) the end forces of an element are ``K_e u_e``. With ``inertia=True`` the static
problem ``K u = f`` is solved at each instant with all loads on the free body: gravity and inertia of every mass point
(d'Alembert) and the forces at the interfaces. This includes the quasi-static part of the dropped modes (mode
acceleration, Craig & Kurdila, "Fundamentals of structural dynamics", 2006, section 11.5), and the load along each
element curves the diagrams inside it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from kanefe.errors import ModelError
from kanefe.fe_model.model import COMPONENTS, Cells, Elasticity, rigid_motion
from kanefe.results.reader import Reader
from kanefe_fem.beams import elements as be
from kanefe_fem.beams.mass import AXIAL_STATIONS
from kanefe_fem.beams.properties import properties_of
from kanefe_fem.recovery.exact_balance import exact_beam_balance
from kanefe_fem.recovery.free_body_loads import SpreadLoads, free_body_loads

if TYPE_CHECKING:
    from kanefe.bodies.exact.beam_line import BeamLine

PLANAR_FORCES = (0, 1, 5)
"""Section forces in the x-y plane: N, Vy, Mz."""

NAMES = ("N", "Vy", "Vz", "T", "My", "Mz")


@dataclass(frozen=True, eq=False)
class SectionForces:
    """Section forces of m beam elements at s stations each, at T times.

    The force (N, Vy, Vz) and the moment (T, My, Mz) act from the part beyond the section on the part before it, in the
    axes of the element: x from its first node to its second, y and z across. So N is positive in tension.

    Attributes
    ----------
    times : ndarray, shape (T,)
        Times in s.
    stations : ndarray, shape (s,)
        Stations x/l in [0, 1].
    positions : ndarray, shape (m, s, 3)
        Undeformed positions of the stations, in G, m.
    forces : ndarray, shape (T, m, s, 6)
        N, Vy, Vz in N, T, My, Mz in N m.
    groups : tuple of str
        The stiffener of a shell to which each element belongs; none of other beams.
    """

    times: np.ndarray
    stations: np.ndarray
    positions: np.ndarray
    forces: np.ndarray
    groups: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> np.ndarray:
        """Return one of N, Vy, Vz, T, My, Mz, shape (T, m, s)."""
        if name not in NAMES:
            raise ModelError(f"there is no section force {name!r}. There are: {', '.join(NAMES)}")
        return self.forces[..., NAMES.index(name)]


def section_forces(
    result: Reader, name: str, frames: np.ndarray, eta: np.ndarray, stations: int, inertia: bool
) -> SectionForces:
    """Return the section forces that `Recovery.section_forces` describes, at frames (T,) with coordinates (T, k)."""
    times = result.times[frames]
    shape = result.body(name)
    if shape.line is not None:
        return exact_section_forces(result, name, shape.line, frames, eta, stations, inertia)
    frame = BeamFrame.of_body(name, shape.nodes, shape.components, shape.elasticity, shape.cells)
    xi = stations_of(stations)
    if not inertia:
        motion = np.asarray(eta @ shape.basis.T)  # (T, N)
        forces = frame.along(frame.end_forces(motion), xi, None)
        return SectionForces(times, xi, frame.positions(xi), forces)
    acting = free_body_loads(result, name, frames)
    spread = frame.spread_count(name, acting.points)
    loads = frame.spread_loads(acting.points[:spread], acting.point_forces[:, :spread])
    lumped = frame.lumped_forces(acting.points[spread:], acting.point_forces[:, spread:])
    motion = frame.static_deflection(frame.nodal_forces(loads) + lumped + acting.nodal_forces)
    forces = frame.along(frame.end_forces(motion) - loads.fixed_ends, xi, loads)
    return SectionForces(times, xi, frame.positions(xi), forces)


def exact_section_forces(
    result: Reader, name: str, line: BeamLine, frames: np.ndarray, eta: np.ndarray, stations: int, inertia: bool
) -> SectionForces:
    """Return those of an exact beam, whose elements are the cells of its line, in the axes of the turned sections."""
    times, xi = result.times[frames], stations_of(stations)
    forces = line.through(xi) @ np.squeeze(line.stiffness @ line.strains(eta)[..., None], -1)  # (T, C, s, 6)
    missing = [i for i in range(6) if inertia or i not in line.strain_of]
    if result.body(name).provenance.get("planar"):
        missing = [i for i in missing if i in PLANAR_FORCES]
    if missing and (inertia or result.run is not None):
        forces[..., missing] = exact_beam_balance(result, name, frames, xi)[..., missing]
    else:
        forces[..., missing] = np.nan
    places = line.through(xi) @ line.at_rest[1][line.gauss_nodes]
    return SectionForces(times, xi, places, forces)


def stations_of(count: int) -> np.ndarray:
    """Return equally spaced stations of each element, both ends included."""
    if not isinstance(count, (int, np.integer)) or count < 2:
        raise ModelError(f"stations={count!r} of each element. Remedy: at least 2, its ends")
    return np.linspace(0.0, 1.0, count)


class BeamFrame:
    """The elements of a body of beams.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
    components : tuple of str
    elasticity : Elasticity
        With axes.
    table : ndarray of int, shape (m, 2)
        Nodes of the elements.
    """

    def __init__(
        self, nodes: np.ndarray, components: tuple[str, ...], elasticity: Elasticity, table: np.ndarray
    ) -> None:
        self.nodes = nodes
        self.components = components
        self.table = table
        self.axes = np.asarray(elasticity.axes)
        self.lengths = np.linalg.norm(nodes[table[:, 1]] - nodes[table[:, 0]], axis=1)
        self.properties = properties_of(elasticity, self.lengths)
        width = len(components)
        rows = [COMPONENTS.index(c) for c in components]
        self.element_dofs = np.array([*rows, *(row + 6 for row in rows)])  # of the spatial element
        self.dofs = (table[:, :, None] * width + np.arange(width)).reshape(len(table), -1)
        self.size = len(nodes) * width

    @classmethod
    def of_body(
        cls,
        name: str,
        nodes: np.ndarray,
        components: tuple[str, ...],
        elasticity: Elasticity | None,
        cells: tuple[Cells, ...],
    ) -> BeamFrame:
        """Return the elements of a body; raise a ModelError if it is not made of beams."""
        if elasticity is None or elasticity.axes is None:
            raise ModelError(
                f"body {name!r} is not made of beams, so it has no section forces. Remedy: kanefe_fem.beam_body, or "
                "the stresses of recover(...)"
            )
        return cls(nodes, components, elasticity, np.concatenate([block.nodes for block in cells]))

    @property
    def element_count(self) -> int:
        """Number m of elements."""
        return len(self.table)

    def positions(self, xi: np.ndarray) -> np.ndarray:
        """Return the undeformed positions of stations, shape (m, s, 3), m."""
        start, end = self.nodes[self.table[:, 0]], self.nodes[self.table[:, 1]]
        return start[:, None] + xi[None, :, None] * (end - start)[:, None]

    def end_forces(self, motion: np.ndarray) -> np.ndarray:
        """Return ``K_e u_e`` in L, shape (T, m, 12), from motions (T, N)."""
        u = np.zeros((len(motion), self.element_count, 12))
        u[:, :, self.element_dofs] = motion[:, self.dofs]
        u_L = np.einsum("mij,tmj->tmi", be.spatial_transformation(self.axes), u)
        return np.einsum("mij,tmj->tmi", be.spatial_stiffness(self.properties), u_L)

    def along(self, ends: np.ndarray, xi: np.ndarray, loads: SpreadLoads | None) -> np.ndarray:
        """Return the section forces at stations, shape (T, m, s, 6), from the forces on the ends (T, m, 12).

        They follow from the equilibrium of the piece between the first end and the section.
        """
        x = xi[None, :] * self.lengths[:, None]  # (m, s)
        forces = np.repeat(-ends[:, :, None, :6], len(xi), axis=2)
        # moment about the section of the force on the first end, with the arm -x along the axis
        forces[..., 4] -= x * ends[:, :, 2, None]
        forces[..., 5] += x * ends[:, :, 1, None]
        return forces if loads is None else forces - loads.before(xi)

    def spread_count(self, name: str, places: np.ndarray) -> int:
        """Return how many of the mass points (P, 3) belong to the elements; lumped masses come after them."""
        xi = be.gauss_stations(AXIAL_STATIONS)[0]
        m = self.element_count
        for in_section in (4, 2, 1):
            count = m * AXIAL_STATIONS * in_section
            if count > len(places):
                continue
            local = np.einsum(
                "ma,mgpa->mgp",
                self.axes[:, :, 0],
                places[:count].reshape(m, AXIAL_STATIONS, in_section, 3) - self.nodes[self.table[:, 0]][:, None, None],
            )
            if np.allclose(local / self.lengths[:, None, None], xi[:, None], atol=1e-9):
                return count
        raise ModelError(f"the mass points of {name!r} are not those of beam elements. Remedy: inertia=False")

    def lumped_forces(self, places: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """Return forces (T, L, 3) at lumped masses (L, 3) on the degrees of freedom of the nearest nodes, (T, N)."""
        total = np.zeros((len(forces), self.size))
        width = len(self.components)
        for place, force in zip(places, np.swapaxes(forces, 0, 1), strict=True):
            node = int(np.linalg.norm(self.nodes - place, axis=1).argmin())
            motion = rigid_motion(place[None], self.nodes[node])[:, [COMPONENTS.index(c) for c in self.components]]
            total[:, node * width : (node + 1) * width] += force @ motion
        return total

    def spread_loads(self, places: np.ndarray, forces: np.ndarray) -> SpreadLoads:
        """Return the loads of forces (T, P, 3) on the mass points (P, 3) of the elements, in L.

        Every element has the same number of points, grouped by its Gauss stations.
        """
        m = self.element_count
        start = self.nodes[self.table[:, 0]]
        local = np.einsum("mba,mpb->mpa", self.axes, places.reshape(m, -1, 3) - start[:, None])
        force = np.einsum("mba,tmpb->tmpa", self.axes, forces.reshape(len(forces), m, -1, 3))
        offset = np.broadcast_to(local * np.array([0.0, 1.0, 1.0]), force.shape)
        wrenches = np.concatenate((force, np.cross(offset, force)), axis=-1)
        by_station = wrenches.reshape(len(forces), m, AXIAL_STATIONS, -1, 6).sum(axis=3)
        return SpreadLoads.of_station_forces(self.properties, by_station)

    def nodal_forces(self, loads: SpreadLoads) -> np.ndarray:
        """Return the forces on the degrees of freedom that are equivalent to the loads, shape (T, N)."""
        f = np.einsum("mji,tmj->tmi", be.spatial_transformation(self.axes), loads.fixed_ends)[:, :, self.element_dofs]
        total = np.zeros((len(f), self.size))
        for row, element_forces in zip(total, f, strict=True):
            np.add.at(row, self.dofs, element_forces)
        return total

    def static_deflection(self, forces: np.ndarray) -> np.ndarray:
        """Return a deflection of the free frame under balanced forces, (T, N), up to a rigid motion."""
        K = be.rotate_element_matrix(be.spatial_stiffness(self.properties), be.spatial_transformation(self.axes))
        K = K[:, self.element_dofs][:, :, self.element_dofs]
        width = self.dofs.shape[1]
        rows, columns = np.repeat(self.dofs, width, axis=1).ravel(), np.tile(self.dofs, width).ravel()
        full = sp.coo_matrix((K.ravel(), (rows, columns)), shape=(self.size, self.size)).tocsc()
        kept = np.arange(len(self.components), self.size)  # fixing the first node prevents all rigid motions
        u = np.zeros_like(forces)
        u[:, kept] = spla.splu(full[kept][:, kept]).solve(np.ascontiguousarray(forces[:, kept].T)).T
        return u
