"""Ties of a finite-element model: patches of nodes follow six-component frames.

A solid has no nodal rotations, so an interface is a patch of nodes whose motion, rigidly (RBE2) or on average (RBE3),
is that of a frame. A single node with rotations is its own frame. Each component of a frame is fixed in G or free.
Tied coordinates are the degrees of freedom outside of all interfaces, then those left free in the patches, then the
components of the frames along their axes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.fe_model.averaging import moment_free_columns
from kanefe.fe_model.interface import Interface, as_interface
from kanefe.fe_model.model import COMPONENTS, FiniteElementModel
from kanefe.fe_model.patches import Patch, patch_moments, patch_of


@dataclass(frozen=True, eq=False)
class Tie:
    """One interface in the tied coordinates.

    Attributes
    ----------
    name : str
    nodes : ndarray of int, shape (m,)
        Nodes of the patch.
    position : ndarray, shape (3,)
        Undeformed position of the frame in G, m.
    axes : ndarray, shape (3, 3)
        Rotation matrix from the axes of the undeformed frame to those of G.
    components : tuple of int
        Components of the frame, along its axes, that the patch can follow (0..5).
    fixed : tuple of int
        Components fixed in G, as positions in `components`.
    rows : ndarray of int
        Numbers of the components in the tied coordinates.
    is_rigid : bool
        Whether the nodes move as a rigid body with the frame; else the frame follows their mean motion.
    """

    name: str
    nodes: np.ndarray
    position: np.ndarray
    axes: np.ndarray
    components: tuple[int, ...]
    fixed: tuple[int, ...]
    rows: np.ndarray
    is_rigid: bool

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the components."""
        return tuple(COMPONENTS[c] for c in self.components)

    @property
    def directions(self) -> np.ndarray:
        """Motion of the frame in components of G from its components along its axes, shape (6, components)."""
        return np.asarray(np.kron(np.eye(2), self.axes)[:, list(self.components)])


@dataclass(frozen=True, eq=False)
class InterfaceTies:
    """The transformation between all degrees of freedom and tied coordinates.

    Attributes
    ----------
    transformation : csr_matrix, shape (N, tied)
        T: motion of the nodes from the tied coordinates. The columns of the interior are orthonormal.
    frame_reading : csr_matrix, shape (frame components, N)
        Motion of the frames from the motion of the nodes: its mean, or the rigid motion itself.
    interior_count : int
        Number of interior coordinates, which come first: see `tie_interfaces`.
    ties : tuple of Tie
    """

    transformation: sp.csr_matrix
    frame_reading: sp.csr_matrix
    interior_count: int
    ties: tuple[Tie, ...]

    @property
    def fixed(self) -> np.ndarray:
        """Tied coordinates fixed in G, in the order of the interfaces."""
        return np.array([row for tie in self.ties for row in tie.rows[list(tie.fixed)]], dtype=int)

    def project(self, matrix: sp.csr_matrix) -> sp.csr_matrix:
        """Return ``T^T matrix T``; a matrix that is kept elsewhere has a method of its own for that."""
        if hasattr(matrix, "projected"):
            return matrix.projected(self.transformation)
        if not self.ties:
            return sp.csr_matrix(matrix)
        across = self.transformation.T.tocsr()  # converting the small matrix avoids conversions of the large products
        return across @ sp.csr_matrix(matrix) @ self.transformation

    def coordinates(self, motion: np.ndarray) -> np.ndarray:
        """Return the tied coordinates (tied, m) of motions (N, m) that obey the ties, such as rigid ones."""
        inner, frames = self.transformation[:, : self.interior_count], self.transformation[:, self.interior_count :]
        q = self.frame_reading @ motion
        return np.vstack((inner.T @ (motion - frames @ q), q))


@dataclass(frozen=True, eq=False)
class _Block:
    """Contribution of one patch, over its degrees of freedom: loose and frame columns of T, and motion of the frame."""

    dofs: np.ndarray
    loose: sp.csr_matrix
    frame: np.ndarray
    reading: np.ndarray


def tie_interfaces(model: FiniteElementModel, interfaces: Mapping[str, str | Interface]) -> InterfaceTies:
    """Tie patches of nodes to frames.

    The interior coordinates are the degrees of freedom of the nodes outside of all patches, in their order; then, for
    each patch, the released components of its nodes along the axes of the interface, and the deviations from an average
    (`kanefe.fe_model.averaging`).

    Raises
    ------
    ModelError
        If a group or kind is unknown, a group has no nodes, two interfaces share nodes, a patch cannot follow a
        frame (collinear nodes without rotations) or a fixed component, or weights do not fit.
    """
    patches = separate_patches(model, {name: as_interface(name, given) for name, given in interfaces.items()})
    blocks = [_block(model, patch) for patch in patches]
    tied = np.concatenate([block.dofs for block in blocks]) if blocks else np.zeros(0, dtype=int)
    plain = np.setdiff1d(np.arange(model.size), tied)
    interior = len(plain) + sum(block.loose.shape[1] for block in blocks)
    columns = [sp.csr_matrix((np.ones(len(plain)), (plain, np.arange(len(plain)))), (model.size, len(plain)))]
    columns += [_spread(block.loose, block.dofs, model.size) for block in blocks]
    columns += [_spread(block.frame, block.dofs, model.size) for block in blocks]
    readings = [_spread(block.reading.T, block.dofs, model.size) for block in blocks]
    return InterfaceTies(
        transformation=sp.hstack(columns, format="csr"),
        frame_reading=sp.hstack(readings, format="csr").T.tocsr() if blocks else sp.csr_matrix((0, model.size)),
        interior_count=interior,
        ties=_ties(patches, interior),
    )


def separate_patches(model: FiniteElementModel, interfaces: Mapping[str, Interface]) -> list[Patch]:
    """Return the patches of interfaces; only nodes, components and groups of the model are used.

    Raises
    ------
    ModelError
        If two share a node, or for the reasons of `kanefe.fe_model.patches.patch_of`.
    """
    owner = np.full(len(model.nodes), -1)
    patches: list[Patch] = []
    for name, spec in interfaces.items():
        patch = patch_of(model, name, spec)
        shared = patch.nodes[owner[patch.nodes] >= 0]
        if len(shared):
            raise ModelError(
                f"interfaces {patches[owner[shared[0]]].name!r} and {name!r} share node {shared[0]}: a node can follow "
                "one frame only. Remedy: leave a row of elements between them, or make one interface of both groups"
            )
        owner[patch.nodes] = len(patches)
        patches.append(patch)
    return patches


def _ties(patches: list[Patch], start: int) -> tuple[Tie, ...]:
    ties = []
    for patch in patches:
        rows = start + np.arange(len(patch.components))
        start += len(rows)
        ties.append(
            Tie(
                *(patch.name, patch.nodes, patch.position, patch.axes, patch.components, patch.fixed),
                rows=rows,
                is_rigid=patch.spec.kind != "average",
            )
        )
    return tuple(ties)


def _spread(columns: sp.csr_matrix | np.ndarray, dofs: np.ndarray, size: int) -> sp.csr_matrix:
    """Return columns over some degrees of freedom as columns over all of them."""
    coo = sp.coo_matrix(columns)
    return sp.csr_matrix((coo.data, (dofs[coo.row], coo.col)), (size, columns.shape[1]))


def _block(model: FiniteElementModel, patch: Patch) -> _Block:
    width = len(model.components)
    dofs = (patch.nodes[:, None] * width + np.arange(width)).ravel()
    following, loose, motion = patch.follows, patch.loose, patch.motion
    if patch.spec.kind != "average" or len(motion) == motion.shape[1]:
        return _Block(dofs, loose.tocsr(), following @ motion, np.linalg.pinv(motion) @ following.T)
    moments = patch_moments(model, patch)
    mean = np.linalg.solve(moments @ motion, moments)
    deviations = moment_free_columns(moments, model.nodes[patch.nodes[patch.owner]])
    loose = sp.hstack((loose, following @ deviations), format="csr")
    return _Block(dofs, loose, following @ motion, mean @ following.T)
