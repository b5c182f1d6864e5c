"""The full-order finite-element model: the arrays that cross the border from `kanefe_fem` to `kanefe`.

A model is nodes, the degrees of freedom they carry, sparse M and K, and the *mass field* from which the inertia of a
moving body is exact. It does not depend on the mesh generator or the finite-element library that made it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import shaped_numbers
from kanefe.storage.scipy_later import sp

if TYPE_CHECKING:
    from kanefe.fe_model.load_pattern import NodalPattern
    from kanefe.fe_model.ribs import Ribs
    from kanefe.fe_model.shell_stack import ShellStack

TRANSLATIONS = ("x", "y", "z")


ROTATIONS = ("rx", "ry", "rz")


COMPONENTS = TRANSLATIONS + ROTATIONS
"""Names of the six components of a node's motion, in the order of every 6-vector of the package."""

PRODUCTS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Axes (a, b) of the products w_a w_b of angular speeds, in the order of the spin loads."""

INERTIA_OF_MODES = "inertia of modes"
"""Name of the load of the modes' own accelerations, in what a basis leaves out."""


@dataclass(frozen=True, eq=False)
class NodeGroup:
    """Named nodes of a mesh, a candidate for an interface.

    Attributes
    ----------
    nodes : ndarray of int, shape (m,)
        Node numbers.
    position : ndarray, shape (3,)
        Reference point in m: area-weighted centroid of the facets, or the node itself.
    measure : csr_matrix, shape (m, m), or None
        int N_i N_j over the facets (m2) or lines (m) of the group, for averages. None: the group has nodes only.
    """

    nodes: np.ndarray
    position: np.ndarray
    measure: sp.csr_matrix | None = None


@dataclass(frozen=True, eq=False)
class Cells:
    """One block of cells of one shape, for views.

    Attributes
    ----------
    kind : str
        Shape, by meshio's name ("tetra10", "hexahedron", "line", ...).
    nodes : ndarray of int, shape (m, nodes per cell)
        Node numbers in VTK order.
    """

    kind: str
    nodes: np.ndarray


@dataclass(frozen=True, eq=False)
class MassField:
    """Mass of a body as a cloud of points that only translate: ``r = X + N q``.

    For a Lagrange mesh the points are the nodes and `mass` is the scalar consistent mass matrix; for a beam they are
    integration points of the cross-sections along the axis. Since the field is linear in q, position, velocity and
    acceleration of every point are exact, and so is the inertia (Zwoelfer & Gerstmayr 2020).

    Attributes
    ----------
    points : ndarray, shape (P, 3)
        Reference coordinates X in m.
    mass : csr_matrix, shape (P, P)
        Scalar mass matrix in kg.
    interpolation : csr_matrix, shape (3 P, N)
        N: displacement of the points, point-major, from the degrees of freedom of the model.
    turns : csr_matrix, shape (3 P, N), or None
        Rotation (rad) of the rigid part that each point belongs to, such as a section of a beam. It affects only the
        inertia of the second-order displacement (`kanefe.reduction.stiffening`).
    arms : ndarray, shape (P, 3), or None
        Position of each point in its rigid part relative to the point of the part that only translates, m.
    """

    points: np.ndarray
    mass: sp.csr_matrix
    interpolation: sp.csr_matrix
    turns: sp.csr_matrix | None = None
    arms: np.ndarray | None = None

    def mass_matrix(self) -> sp.csr_matrix:
        """Return the consistent mass matrix ``N^T (Ms (x) I3) N``, shape (N, N)."""
        kron = sp.kron(self.mass, sp.identity(3), format="csr")
        return (self.interpolation.T @ kron @ self.interpolation).tocsr()


def fields_together(fields: Sequence[MassField]) -> MassField:
    """Return the points of several mass fields over the same degrees of freedom as one."""
    turns = [sp.csr_matrix(one.interpolation.shape) if one.turns is None else one.turns for one in fields]
    arms = [np.zeros(one.points.shape) if one.arms is None else one.arms for one in fields]
    return MassField(
        points=np.concatenate([one.points for one in fields]),
        mass=sp.block_diag([one.mass for one in fields], format="csr"),
        interpolation=sp.vstack([one.interpolation for one in fields], format="csr"),
        turns=sp.vstack(turns, format="csr"),
        arms=np.concatenate(arms),
    )


class StressStiffness(Protocol):
    """Function of a static state that gives the geometric stiffness of its stress."""

    def __call__(self, displacement: np.ndarray, load: np.ndarray | None = None, /) -> sp.csr_matrix:
        """Return the geometric stiffness matrix, shape (N, N), of a state; linear in it.

        Parameters
        ----------
        displacement : ndarray, shape (N,)
            Static displacement in m and rad.
        load : ndarray, shape (3 P,), optional
            Forces on the points of the mass field, if the load acts there, N: between nodes they change the section
            forces of a beam.
        """
        ...


class Stresses(Protocol):
    """Function of displacements that gives the stress at the nodes."""

    def __call__(self, displacements: np.ndarray, /) -> np.ndarray:
        """Return the stress at each node, shape (n, 6, m) in Pa: xx, yy, zz, yz, xz, xy in G; linear.

        Parameters
        ----------
        displacements : ndarray, shape (N, m)
            m displacements in m and rad, one a column.
        """
        ...


@dataclass(frozen=True, eq=False)
class ViscoelasticPart:
    """A part of a body whose stress relaxes: ``K (1 - sum w_i + sum w_i exp(-t / tau_i))`` after a step of strain.

    Attributes
    ----------
    stiffness : csr_matrix, shape (N, N)
        Instantaneous stiffness K of the part, N/m.
    weights, times : tuple of float
        w_i, and relaxation times tau_i in s.
    """

    stiffness: sp.csr_matrix
    weights: tuple[float, ...]
    times: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class FiniteElementModel:
    """Full-order matrices of one flexible body in its mesh frame G (Eq. 21).

    Attributes
    ----------
    nodes : ndarray, shape (n, 3)
        Reference coordinates in m.
    components : tuple of str
        Degrees of freedom of every node, among "x", "y", "z", "rx", "ry", "rz"; degree of freedom number
        ``node * len(components) + c``.
    stiffness : csr_matrix, shape (N, N)
        K, in N/m and N m/rad; of viscoelastic parts the long-term stiffness.
    mass : csr_matrix, shape (N, N)
        M, in kg and kg m2.
    mass_field : MassField or None
        For exact inertia. None: the nodal form of Eq. 38 is used, an approximation where nodes rotate.
    damping : csr_matrix or None
        C, in N s/m.
    cells : tuple of Cells
        For views.
    groups : dict of str to NodeGroup
        Candidates for interfaces.
    load_patterns : dict of str to NodalPattern
        Surfaces and lines that can carry distributed loads.
    elasticity : Elasticity or None
        Moduli of the cells, for stresses.
    stress_stiffness : StressStiffness or None
        Geometric stiffness of the stress of a static state. None: motion-induced stiffening is not available, except
        by `geometric_stiffness`.
    geometric_stiffness : dict of str to csr_matrix, shape (N, N), or None
        Geometric stiffness of the unit inertia loads alone, by their names in
        `kanefe.reduction.stiffening.INERTIAL_LOADS`.
    provenance : dict
        Origin of the arrays (json-able).
    generalised : int
        Number of coordinates of a superelement that move none of its nodes, such as modes with the boundary held: the
        last degrees of freedom, after those of the nodes.
    following : csr_matrix, shape (f, N), or None
        Unit directions of rotations that only follow the neighbourhood of their node, one a row: those of the nodes of
        solids, and about the normals of flat shells. They have no stiffness of their own and no mass, and no
        interface holds them.
    structural : csr_matrix, shape (N, N), or None
        Structural damping H, N/m: harmonic motions meet the stiffness ``K + i H``.
    viscoelastic : tuple of ViscoelasticPart
        Parts whose stress relaxes.
    added_mass : csr_matrix, shape (N, N), or None
        Mass in kg of a fluid at rest about the undeformed body, for velocities of the degrees of freedom in components
        of G: symmetric, and other than M not the same in all directions. It has no weight. See
        `kanefe.bodies.wet_moments`.
    stresses : Stresses or None
        Stress recovery of elements other than those of `elasticity`.
    source : ModelSource or None
        How to make it again. It is no field: copies and files have none.
    """

    nodes: np.ndarray
    components: tuple[str, ...]
    stiffness: sp.csr_matrix
    mass: sp.csr_matrix
    mass_field: MassField | None = None
    damping: sp.csr_matrix | None = None
    cells: tuple[Cells, ...] = ()
    groups: Mapping[str, NodeGroup] = field(default_factory=dict)
    load_patterns: Mapping[str, NodalPattern] = field(default_factory=dict)
    elasticity: Elasticity | None = None
    stress_stiffness: StressStiffness | None = None
    geometric_stiffness: Mapping[str, sp.csr_matrix] | None = None
    provenance: Mapping[str, Any] = field(default_factory=dict)
    generalised: int = 0
    following: sp.csr_matrix | None = None
    structural: sp.csr_matrix | None = None
    viscoelastic: tuple[ViscoelasticPart, ...] = ()
    added_mass: sp.csr_matrix | None = None
    stresses: Stresses | None = None
    source: ClassVar[Any] = None

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "source"}

    @property
    def size(self) -> int:
        """Number of degrees of freedom N."""
        return self.nodal_size + self.generalised

    @property
    def nodal_size(self) -> int:
        """Number of degrees of freedom of the nodes, the first ones."""
        return len(self.nodes) * len(self.components)

    @checked
    def rigid_modes(self, about: np.ndarray | tuple[float, float, float] = (0.0, 0.0, 0.0)) -> np.ndarray:
        """Return the motions of the nodes under unit rigid motions, shape (N, 6).

        Columns are three translations and three small rotations about the point `about` (m, in G).
        """
        about = shaped_numbers(about, (3,), "the point about which a body turns")
        motion = rigid_motion(self.nodes, about, self.components)
        return motion if not self.generalised else np.vstack((motion, np.zeros((self.generalised, 6))))

    def unit_rigid_modes(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the rigid motions about the mean of the nodes that move them, as unit columns, and their numbers."""
        R = self.rigid_modes(about=self.nodes.mean(axis=0))
        norms = np.linalg.norm(R, axis=0)
        kept = norms > 1e-12 * norms.max()
        return R[:, kept] / norms[kept], np.flatnonzero(kept)

    @checked
    def group(self, name: str) -> NodeGroup:
        """Return the named group of nodes.

        Raises
        ------
        ModelError
            If there is no such group; the message lists those there are.
        """
        if name not in self.groups:
            known = ", ".join(sorted(self.groups)) or "none"
            raise ModelError(
                f"the mesh has no group of facets or nodes called {name!r}. Remedy: use one of those it has ({known}), "
                "or name a physical group so in the mesh"
            )
        return self.groups[name]


def rigid_motion(
    points: np.ndarray, about: np.ndarray | tuple[float, float, float], components: tuple[str, ...] = TRANSLATIONS
) -> np.ndarray:
    """Return the small rigid motion ``d + theta x (X - about)`` of points, shape (points * components, 6).

    Parameters
    ----------
    points : ndarray, shape (P, 3)
        Positions in m.
    about : array_like, shape (3,)
        Reference point in m.
    components : tuple of str
        Which components of each point's motion to return.
    """
    r = np.asarray(points, dtype=float) - np.asarray(about, dtype=float)
    full = np.zeros((len(r), 6, 6))
    full[:, range(6), range(6)] = 1.0
    full[:, 0, 4], full[:, 0, 5] = r[:, 2], -r[:, 1]
    full[:, 1, 3], full[:, 1, 5] = -r[:, 2], r[:, 0]
    full[:, 2, 3], full[:, 2, 4] = r[:, 1], -r[:, 0]
    rows = [COMPONENTS.index(c) for c in components]
    return full[:, rows, :].reshape(-1, 6)


@dataclass(frozen=True, eq=False)
class Elasticity:
    """Linear elastic moduli of the cells of a mesh: of solids in components of G, of beams in their own axes.

    Stresses and strains are listed as xx, yy, zz, yz, xz, xy, with engineering shear strains (2 e_yz, ...).

    Attributes
    ----------
    table : ndarray, shape (m, 6, 6)
        Different stiffness matrices, Pa. For a plane body the moduli of plane stress or strain are in the places of
        xx, yy and xy.
    of_cell : ndarray of int, shape (cells,)
        Number of the matrix of each cell, in the order of the body's blocks of cells.
    axes : ndarray, shape (cells, 3, 3), or None
        A_GL of beams, axes of each element as columns: x along it, y and z across. The table then holds the stiffness
        of sections to stretch, shear along y and z, twist, and bending about y and z: N for the first three, N m2 for
        the others; infinite where a theory has no shear strain. None: a solid or plane body.
    fibres : ndarray, shape (m, p, 3), or None
        Fibres around the outline of each beam section in the table: y and z (m) and Young's modulus (Pa); zeros where
        the shape of a section is not known.
    shell : ShellStack or None
        Thickness and layers of the cells that are shells; the table is that of the other cells.
    ribs : Ribs or None
        The beams along the lines of a shell. `of_cell` has the number of the section for cells of shells, of the
        stiffener for lines, and of the matrix for those of solids.
    """

    table: np.ndarray
    of_cell: np.ndarray
    axes: np.ndarray | None = None
    fibres: np.ndarray | None = None
    shell: ShellStack | None = None
    ribs: Ribs | None = None


CELL_TYPES = {
    "vertex": 1,
    "line": 3,
    "triangle": 5,
    "quad": 9,
    "tetra": 10,
    "hexahedron": 12,
    "wedge": 13,
    "pyramid": 14,
    "line3": 21,
    "triangle6": 22,
    "quad8": 23,
    "tetra10": 24,
    "hexahedron20": 25,
    "wedge15": 26,
    "pyramid13": 27,
    "quad9": 28,
    "hexahedron27": 29,
    "wedge18": 32,
}
"""VTK's number of each shape of cell."""
