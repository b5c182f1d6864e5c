"""FlexibleBody: the contract between finite elements and Kane's equations.

A body is a set of frozen arrays in its mesh frame G: a basis Psi of K coordinates, its stiffness, damping and mass
moments, and the motion of its interfaces. The first k coordinates are free; the last ones are the interface
components that are fixed in G. Their rows of the equations are deleted, and give the coupling forces on request.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe._public import served
from kanefe.arguments import checked
from kanefe.bodies.inner_motion import InnerMotion
from kanefe.bodies.made_from_source import MadeFromSource
from kanefe.bodies.mass_moments import MassMoments
from kanefe.errors import ModelError
from kanefe.fe_model.model import COMPONENTS, ROTATIONS, Cells, Elasticity
from kanefe.frames import shaped_numbers
from kanefe.storage.pickled import PickledByFields
from kanefe.storage.scipy_later import scipy, sp

if TYPE_CHECKING:
    from kanefe.bodies.exact.beam_line import BeamLine
    from kanefe.bodies.nodal_moments import NodalMoments
    from kanefe.bodies.relaxation import Relaxation
    from kanefe.bodies.slopes import SlopeMeasure
    from kanefe.documents.document import Report
    from kanefe.fe_model.load_pattern import LoadPattern
    from kanefe.fe_model.node_shares import NodeShares
    from kanefe.fe_model.place_field import Over
    from kanefe.storage.object_file import FileKind

UNITS = "m, kg, s, N, rad"


@dataclass(frozen=True, eq=False, repr=False)
class InterfaceFrame:
    """A frame n of a flexible body that moves with its interface.

    Attributes
    ----------
    name : str
    position : ndarray, shape (3,)
        p_GoNo_G, undeformed, in m.
    motion : ndarray, shape (6, K)
        Translation (m) and slopes (rad) of the frame from all coordinates, in components of G.
    fixed_components : tuple of int
        Components, along the axes of the interface, that are fixed in G (0..5).
    fixed_columns : tuple of int
        Their coordinates, among the last ones of the body.
    quadratic : ndarray, shape (6, K, K), or None
        Second-order part of the motion, ``1/2 eta^T quadratic eta`` in m and rad (rotation vector): foreshortening and
        the like. None: without stiffening by loads on the interface.
    axes : ndarray, shape (3, 3)
        Rotation matrix from the axes of the undeformed interface to those of G.
    """

    name: str
    position: np.ndarray
    motion: np.ndarray
    fixed_components: tuple[int, ...] = ()
    fixed_columns: tuple[int, ...] = ()
    quadratic: np.ndarray | None = None
    axes: np.ndarray = field(default_factory=lambda: np.eye(3))

    def __repr__(self) -> str:
        return f"InterfaceFrame({self.name!r})"

    @property
    def is_held(self) -> bool:
        """Whether some of its components are fixed in G."""
        return bool(self.fixed_components)

    @property
    def is_linear(self) -> bool:
        """Whether translation and slopes are linear in the coordinates."""
        return self.quadratic is None

    @property
    def turns(self) -> bool:
        """Whether the frame has a rotation, which what it carries can follow."""
        return bool(self.motion[3:].any())

    def moved(self, eta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return translation and slopes of the frame, (6,), and their derivatives by the leading coordinates (6, k).

        Parameters
        ----------
        eta : ndarray, shape (k,)
            The leading coordinates of the body.
        """
        count = len(eta)
        motion = self.motion[:, :count]
        if self.quadratic is None:
            return motion @ eta, motion
        bent = self.quadratic[:, :count, :count] @ eta
        return motion @ eta + 0.5 * (bent @ eta), motion + bent

    def inner_motion(self, eta: np.ndarray, deta: np.ndarray, slopes: SlopeMeasure) -> InnerMotion:
        """Return the motion of the frame seen from G (Eq. 22, 24-26).

        Slopes are read as a finite rotation A_Gn, and their rates mapped to an angular velocity by its tangent, so that
        bodies carried by n see a true rotation and energy is kept.
        """
        displacement, motion = self.moved(eta)
        rates, remainder = motion @ deta, self.remainder(deta)
        theta, dtheta = displacement[3:], rates[3:]
        T = slopes.tangent(theta)
        return InnerMotion(
            self.position + displacement[:3],
            slopes.rotation(theta),
            rates[:3],
            T @ dtheta,
            np.vstack((motion[:3], T @ motion[3:])),
            remainder[:3],
            slopes.remainder(theta, dtheta) + T @ remainder[3:],
        )

    def loose_rotations(self, components: tuple[str, ...]) -> tuple[str, ...]:
        """Return the rotations about the axes of the interface that its nodes, with these components, cannot follow."""
        turns = abs(self.axes.T @ self.motion[3:]).max(axis=1, initial=0.0)
        possible = ROTATIONS if "z" in components else ("rz",)
        return tuple(c for c in possible if turns[ROTATIONS.index(c)] <= 1e-12 * turns.max())

    def displacements(self, eta: np.ndarray) -> np.ndarray:
        """Return translations and slopes of the frame, (T, 6), at many states eta (T, k)."""
        count = eta.shape[1]
        moved = eta @ self.motion[:, :count].T
        if self.quadratic is None:
            return np.asarray(moved)
        bent = np.tensordot(eta, self.quadratic[:, :count, :count], axes=(1, 2))  # (T, 6, k)
        return np.asarray(moved + 0.5 * np.einsum("tci,ti->tc", bent, eta))

    def remainder(self, deta: np.ndarray) -> np.ndarray:
        """Return the remainder accelerations of translation and slopes, ``deta^T quadratic deta``, (6,)."""
        if self.quadratic is None:
            return np.zeros(6)
        count = len(deta)
        return np.asarray((self.quadratic[:, :count, :count] @ deta) @ deta)


@dataclass(frozen=True, eq=False, repr=False)
class FlexibleBody(MadeFromSource, PickledByFields):
    """The data of a flexible body for Kane's equations.

    Attributes
    ----------
    nodes : ndarray, shape (n, 3)
        Reference coordinates of the mesh in G, m.
    components : tuple of str
        Degrees of freedom of every node.
    basis : ndarray, shape (n * components, K)
        Psi: motion of the nodes from the coordinates, fixed interface components last.
    free_count : int
        Number k of free coordinates.
    stiffness : ndarray, shape (K, K)
    damping : ndarray, shape (k, k)
    moments : MassMoments or NodalMoments
        Inertia: exact from a mass field, or the nodal form.
    interfaces : tuple of InterfaceFrame
    inertia_points : ndarray, shape (P, 3)
        Mass points of the field in m; the nodes where the nodal form is used.
    inertia_mass : csr_matrix
        Scalar mass matrix (P, P) of the field; M of the nodes in the nodal form.
    inertia_basis : ndarray
        Psi at the mass points, (3 P, K); at the nodes in the nodal form.
    cells : tuple of Cells
        For views.
    load_patterns : tuple of LoadPattern
        Surfaces and lines that can carry distributed loads.
    elasticity : Elasticity or None
        Moduli of the cells, for stresses and section forces.
    groups : tuple of NodeShares
        Named parts of the mesh, for contacts.
    structural : ndarray, shape (k, k), or None
        Structural damping H: harmonic motions meet the stiffness ``K + i H``. It acts in frequency responses and modes.
    relaxation : Relaxation or None
        Arms of viscoelastic materials, beside the long-term stiffness.
    stress_modes : ndarray, shape (n, 6, K), or None
        Stress at the nodes of unit coordinates in Pa, of elements with a stress recovery of their own.
    units : str
    provenance : dict
        Origin of the body (json-able).
    """

    nodes: np.ndarray
    components: tuple[str, ...]
    basis: np.ndarray
    free_count: int
    stiffness: np.ndarray
    damping: np.ndarray
    moments: MassMoments | NodalMoments
    interfaces: tuple[InterfaceFrame, ...]
    inertia_points: np.ndarray
    inertia_mass: sp.csr_matrix
    inertia_basis: np.ndarray
    cells: tuple[Cells, ...] = ()
    load_patterns: tuple[LoadPattern, ...] = ()
    elasticity: Elasticity | None = None
    groups: tuple[NodeShares, ...] = ()
    structural: np.ndarray | None = None
    relaxation: Relaxation | None = None
    stress_modes: np.ndarray | None = None
    units: str = UNITS
    provenance: Mapping[str, Any] = field(default_factory=dict, compare=False)

    def __post_init__(self) -> None:
        frozen = [*self._matrices(), self.nodes, *self.moments.arrays().values()]
        for frame in self.interfaces:
            frozen += [frame.position, frame.motion, frame.axes]
            frozen += [] if frame.quadratic is None else [frame.quadratic]
        frozen += [block.nodes for block in self.cells]
        frozen += [] if self.stress_modes is None else [self.stress_modes]
        frozen += [a for pattern in self.load_patterns for a in pattern.arrays().values()]
        frozen += [] if self.structural is None else [self.structural]
        frozen += [a for group in self.groups for a in (group.nodes, group.shares)]
        for array in frozen:
            array.flags.writeable = False

    def _matrices(self) -> list[np.ndarray]:
        return [
            *(self.basis, self.stiffness, self.damping),
            *(self.inertia_points, self.inertia_basis, self.inertia_mass.data),
        ]

    def __repr__(self) -> str:
        interfaces = ", ".join(f"{f.name}{' (fixed)' if f.is_held else ''}" for f in self.interfaces)
        return (
            f"{type(self).__name__}({self.mass:.6g} kg, {len(self.nodes)} nodes, {self.free_count} coordinates, "
            f"interfaces: {interfaces or 'none'})"
        )

    def __str__(self) -> str:
        """Return the representation, and what its maker tells of it."""
        return "\n  ".join((repr(self), *self.provenance.get("told", ())))

    def _repr_html_(self) -> str:
        """Return the representation in notebooks."""
        return served("body_card")(self)

    @property
    def count(self) -> int:
        """Number K of coordinates, free and fixed."""
        return self.basis.shape[1]

    @property
    def fixed_count(self) -> int:
        """Number of interface components fixed in G."""
        return self.count - self.free_count

    @property
    def is_exact(self) -> bool:
        """Whether the inertia is exact (a mass field), or the nodal approximation."""
        return isinstance(self.moments, MassMoments)

    @property
    def is_floating(self) -> bool:
        """Whether no interface is fixed in G: G follows the body's mean motion, and the joint must be a free one."""
        return self.fixed_count == 0

    @property
    def line(self) -> BeamLine | None:
        """Strain fields of an `ExactBeam`; None: any other body."""
        return None

    @property
    def bends_far(self) -> bool:
        """Whether its motion holds for any deformation, and not for small ones alone."""
        return self.line is not None

    @property
    def frequencies(self) -> np.ndarray:
        """Natural frequencies with the fixed interfaces held, shape (k,), in Hz."""
        k = self.free_count
        if k == 0:
            return np.zeros(0)
        squares = scipy.linalg.eigh(self.stiffness[:k, :k], self.moments.elastic_mass[:k, :k], eigvals_only=True)
        return np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)

    @property
    def mass(self) -> float:
        """Mass in kg."""
        return float(self.moments.mass)

    @property
    def center_of_mass(self) -> np.ndarray:
        """Undeformed centre of mass in G, shape (3,), m."""
        generalised, _ = self.moments.leading(0).terms(np.zeros(0), np.zeros(0), np.zeros(3))
        c = generalised[3:6, :3] / self.mass
        return np.array((c[2, 1], c[0, 2], c[1, 0]))

    @property
    def inertia(self) -> np.ndarray:
        """Undeformed inertia about the origin of G, in components of G, shape (3, 3), kg m2."""
        generalised, _ = self.moments.leading(0).terms(np.zeros(0), np.zeros(0), np.zeros(3))
        return generalised[3:6, 3:6]

    @checked
    def interface(self, name: str) -> InterfaceFrame:
        """Return the interface called `name`; raise a ModelError that lists those there are."""
        for frame in self.interfaces:
            if frame.name == name:
                return frame
        known = ", ".join(frame.name for frame in self.interfaces) or "none"
        raise ModelError(f"this flexible body has no interface called {name!r}. It has: {known}")

    @checked("name")
    def load_pattern(self, name: str, over: Over | None = None) -> LoadPattern:
        """Return the surface or line called `name`, with the shape `over` of `System.add_pressure` as a factor."""
        for pattern in self.load_patterns:
            if pattern.name == name:
                return pattern if over is None else pattern.shaped(over, self.nodes, self.basis)
        known = ", ".join(pattern.name for pattern in self.load_patterns) or "none"
        raise ModelError(
            f"this flexible body has no surface or line for loads called {name!r}. It has: {known}. Remedy: make it "
            f"with solid_body(..., surfaces=[{name!r}]), or with beam_model(..., lines={{{name!r}: [...]}})"
        )

    @checked
    def node_frame(self, node: int) -> InterfaceFrame:
        """Return a frame that moves with one node of the mesh (slopes are zero where the node has none)."""
        if not 0 <= node < len(self.nodes):
            raise ModelError(f"node {node} is not one of the {len(self.nodes)} nodes of this body")
        motion = np.zeros((6, self.count))
        width = len(self.components)
        rows: Any = self.basis[node * width : (node + 1) * width]
        motion[[COMPONENTS.index(c) for c in self.components]] = rows.toarray() if sp.issparse(rows) else rows
        return InterfaceFrame(f"node {node}", self.nodes[node].copy(), motion)

    @checked
    def node_displacements(self, eta: np.ndarray) -> np.ndarray:
        """Return the displacement of every node in G, shape (n, 3) in m, from the free coordinates (k,)."""
        given = shaped_numbers(eta, (self.free_count,), "eta, the free coordinates of this body,")
        motion = (self.basis[:, : self.free_count] @ given).reshape(len(self.nodes), len(self.components))
        displacement = np.zeros((len(self.nodes), 3))
        for column, component in enumerate(self.components):
            if component in ("x", "y", "z"):
                displacement[:, COMPONENTS.index(component)] = motion[:, column]
        return displacement

    @checked
    def node_velocities(self, eta: np.ndarray, deta: np.ndarray) -> np.ndarray:
        """Return the velocity of every node in G, shape (n, 3) in m/s, from the free coordinates and their rates."""
        for name, value in (("eta", eta), ("deta", deta)):
            shaped_numbers(value, (self.free_count,), f"{name} of the free coordinates of this body")
        return self.node_displacements(deta)

    def report(self) -> Report:
        """Return a report: mesh quality, mass, modes, effective masses, interfaces, reduction, provenance.

        Returns
        -------
        Report
            ``print(report)``, ``report.to_html(path)`` and ``report.to_markdown(path)``; the last two with pictures of
            the mode shapes where pyvista is installed (``pip install 'kanefe[report]'``).

        Examples
        --------
        ``body.report().to_html("arm.html")``
        """
        return served("body_report")(self)

    @checked
    def save(self, path: str | Path) -> None:
        """Write the body to one file (.npz); an old file survives a failure. See `FlexibleBody.load`."""
        from kanefe.storage.object_file import write_object

        write_object(path, self, file_kind())

    @staticmethod
    @checked
    def load(path: str | Path) -> FlexibleBody:
        """Read a body that `save` wrote.

        Raises
        ------
        FileError
            If the file is missing, truncated, or of another format or version.
        """
        from kanefe.storage.object_file import read_object

        body: FlexibleBody = read_object(path, file_kind())
        return body


def file_kind() -> FileKind:
    """Return the kind of files of flexible bodies.

    Versions 1 and 2 were compressed, and had to be read as a whole; version 3 named classes by their modules.
    """
    from kanefe.storage.object_file import FileKind

    return FileKind("kanefe flexible body", 4, FlexibleBody, "body", "flexible body", "FlexibleBody.save")
